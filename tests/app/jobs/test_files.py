"""The files of a job: what counts is read back, the rest is written again, a full disk changes nothing."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from primfit.app.engine.items import Told
from primfit.app.jobs.files import Folder, Line
from primfit.app.jobs.record import Part
from primfit.app.wire.problems import InsufficientStorageError
from tests.app.disks import disk_of


def _line(k: int, file: int = 1, of: int = 1000) -> Line:
    told = Told(file, k, of, ("fitted", "ambiguous", "no_fit", "problems")[k % 4], k)
    return told, json.dumps({"id": f"i{k}", "label": k, "answer": "x" * k}).encode() + b"\n"


LINES = [_line(k) for k in range(20)]
SUMMARY: Line = (None, b'{"summary":{"items":20}}\n')


def _read(folder: Folder, parts: list[Part], offset: int = 0, limit: int = 100) -> bytes:
    return b"".join(stretch.read() for stretch in folder.of("j").page(parts, offset, limit))


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    made = Folder(tmp_path / "deep" / "jobs")
    made.create("j", b"the body")
    return made


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with disk_of("64k", tmp_path / "small") as place:
        yield place


def test_a_body_is_kept_from_bytes_and_from_a_file(folder: Folder, tmp_path: Path) -> None:
    (tmp_path / "large").write_bytes(b"large" * 1000)
    folder.create("k", tmp_path / "large")
    assert folder.of("j").body.read_bytes() == b"the body"
    assert folder.of("k").body.read_bytes() == b"large" * 1000
    assert folder.ids() == {"j", "k"}
    for private in (folder.path, folder.of("k").folder):
        assert private.stat().st_mode & 0o777 == 0o700
    folder.of("k").remove_body()
    folder.remove("k")
    assert folder.ids() == {"j"}


def test_pages_are_cut_from_the_parts_of_several_attempts(folder: Folder) -> None:
    parts = []
    for attempt, (start, stop) in enumerate([(0, 7), (7, 8), (8, 20)], 1):
        appender = folder.of("j").appender(attempt)
        appender.append(LINES[start : start + 1])
        parts.append(appender.append(LINES[start + 1 : stop]))
    for offset in range(22):
        for limit in (1, 2, 5, 13, 40):
            expected = b"".join(line for _, line in LINES[offset : offset + limit])
            assert _read(folder, parts, offset, limit) == expected
    assert folder.of("j").told(parts) == [told for told, _ in LINES]


def test_the_summary_is_a_line_that_is_about_no_item(folder: Folder) -> None:
    part = folder.of("j").appender(1).append([*LINES[:2], SUMMARY])
    assert _read(folder, [part], 2) == SUMMARY[1]
    assert folder.of("j").told([part]) == [told for told, _ in LINES[:2]]


def test_what_an_attempt_wrote_and_nobody_counted_is_not_read(folder: Folder) -> None:
    counted = folder.of("j").appender(1).append(LINES[:3])
    stale = folder.of("j").appender(1)
    stale.part = counted
    stale.append(LINES[5:9])
    mine = folder.of("j").appender(2).append(LINES[3:5])
    assert _read(folder, [counted, mine]) == b"".join(line for _, line in LINES[:5])
    assert folder.of("j").told([counted, mine]) == [told for told, _ in LINES[:5]]


def test_a_full_disk_leaves_nothing_of_a_body(small_disk: Path) -> None:
    folder = Folder(small_disk)
    with pytest.raises(InsufficientStorageError):
        folder.create("j", b"x" * 100_000)
    assert folder.ids() == set()
    folder.create("k", b"x" * 1000)


def test_a_full_disk_leaves_the_results_as_they_were_and_takes_more_when_there_is_room(
    small_disk: Path,
) -> None:
    folder = Folder(small_disk)
    folder.create("j", b"body")
    appender = folder.of("j").appender(1)
    appender.append(LINES[:5])
    filler = small_disk / "filler"
    with pytest.raises(OSError):
        filler.write_bytes(b"x" * 100_000)
    with pytest.raises(InsufficientStorageError):
        appender.append([_line(30_000, of=30_001)])
    filler.unlink()
    part = appender.append(LINES[5:9])
    assert _read(folder, [part]) == b"".join(line for _, line in LINES[:9])
