"""A batch that goes on behind any of its lines tells the rest of them, byte for byte."""

import asyncio
import gzip
from pathlib import Path
from typing import Any

import orjson
import pytest

from primfit.app.engine.items import Told
from primfit.app.service.batch_stream import Batch, NotAgainError
from primfit.app.service.job_work import new_job, open_job
from primfit.app.service.metrics import Metrics
from primfit.app.service.settings import Settings
from primfit.app.service.spool import Spool
from primfit.app.workers import jobs
from primfit.app.workers.batch_jobs import FileJob
from tests.paths import EXAMPLES

Lines = list[tuple[Told | None, bytes]]
SETTINGS = Settings(workers=2)
SPOOL = Spool(None, None, 0)
SEGMENTS, FEW = (EXAMPLES / "segments.csv").read_bytes(), (EXAMPLES / "few.csv").read_bytes()
FILES = [("a.csv", SEGMENTS), ("bad.xyz", b"1 2 3"), ("a.csv", FEW), ("A.csv", SEGMENTS), ("a.csv", SEGMENTS)]


def _form(files: list[tuple[str, bytes]], boundary: bytes = b"B") -> bytes:
    head = b'--%s\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n%s\r\n'
    parts = [head % (boundary, name.encode(), content) for name, content in files]
    return b"".join(parts) + b"--%s--\r\n" % boundary


def _asked(content_type: str, coding: str | None = None) -> dict[str, Any]:
    media_type = content_type.partition(";")[0]
    query = [["kinds", "cylinder"]]
    return {
        "request_id": "r",
        "media_type": media_type,
        "content_type": content_type,
        "coding": coding,
        "query": query,
    }


def _opened(asked: dict[str, Any], body: bytes | Path, unpacked: Path | None = None) -> Any:
    return jobs.run(open_job(asked, body, unpacked, SETTINGS))


async def _lines(told: list[Told], run: Any = None) -> Lines:
    asked, body = _asked("multipart/form-data; boundary=B"), _form(FILES)

    async def here(job: Any, heavy: bool = False) -> Any:
        return jobs.run(job)

    opened = _opened(asked, body)
    with SPOOL.files() as scratch:
        batch = Batch(
            "r", body, "multipart/form-data", opened, SETTINGS, scratch, run or here, 2, Metrics(), {}, told
        )
        return [line async for line in batch.told_lines()]


def test_it_goes_on_behind_any_of_its_lines() -> None:
    whole = asyncio.run(_lines([]))
    told = [about for about, _ in whole if about is not None]
    assert [(each.file, each.index, each.of) for each in told[:5]] == [
        (1, 0, 3),
        (1, 1, 3),
        (1, 2, 3),
        (2, 0, 1),
        (3, 0, 1),
    ]
    ids = [orjson.loads(line)["id"] for _, line in whole[:-1]]
    assert ids[:6] == ["a.csv#1", "a.csv#2", "a.csv#3", "bad.xyz", "a.csv~2", "A.csv~3#1"]
    assert len(set(map(str.casefold, ids))) == len(ids)
    # Within a file, behind one, behind the one that has the same name, and behind all of them.
    for n_told in (1, 3, 5, 7, len(told)):
        assert asyncio.run(_lines(told[:n_told])) == whole[n_told:]


def test_what_is_told_is_not_done_again() -> None:
    done: list[Any] = []

    async def noted(job: Any, heavy: bool = False) -> Any:
        done.append(job)
        return jobs.run(job)

    told = [about for about, _ in asyncio.run(_lines([])) if about is not None]
    asyncio.run(_lines(told[:9], noted))
    # Of the last file, whose first segment is told, two segments; of the others nothing.
    assert [isinstance(job, FileJob) for job in done] == [True, False, False]


def test_a_file_that_was_cut_and_is_not_any_more_is_told() -> None:
    told = [about for about, _ in asyncio.run(_lines([])) if about is not None]

    async def refused(job: Any, heavy: bool = False) -> Any:
        return jobs.Reply(504, b"{}")

    with pytest.raises(NotAgainError):
        asyncio.run(_lines(told[:1], refused))


def test_the_fingerprint_is_that_of_the_files_and_options_however_they_are_sent(tmp_path: Path) -> None:
    def fingerprint(asked: dict[str, Any], body: bytes | Path, held: bytes | Path) -> str:
        with SPOOL.file() as scratch:
            unpacked = Path(scratch.name) if asked["coding"] else None
            opened = _opened(asked, body, unpacked)
            return new_job("", None, asked, body, held, opened).fingerprint

    body = _form(FILES)
    first = fingerprint(_asked("multipart/form-data; boundary=B"), body, body)
    other = _form(FILES, b"another")
    assert fingerprint(_asked("multipart/form-data; boundary=another"), other, other) == first
    packed = gzip.compress(body)
    assert fingerprint(_asked("multipart/form-data; boundary=B", "gzip"), packed, body) == first
    (tmp_path / "body").write_bytes(body)
    assert (
        fingerprint(_asked("multipart/form-data; boundary=B"), tmp_path / "body", tmp_path / "body") == first
    )
    fewer = _form(FILES[1:])
    assert fingerprint(_asked("multipart/form-data; boundary=B"), fewer, fewer) != first
    asked = _asked("multipart/form-data; boundary=B") | {"query": [["kinds", "sphere"]]}
    assert fingerprint(asked, body, body) != first
