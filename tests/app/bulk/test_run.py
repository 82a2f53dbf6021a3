"""The work of a run: the same parts whoever does it, and processes that are killed at it."""

import errno
import json
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from primfit.app.bulk import places
from primfit.app.bulk.parts import Run, part_files
from primfit.app.bulk.refs import Ref
from primfit.app.bulk.rows import problem_row
from primfit.app.bulk.run import POISON, LostTaskError, row_of, run
from primfit.app.bulk.tasks import Task
from primfit.app.engine.team import Team
from primfit.fitting.primitives.sphere import Sphere
from tests.app.bulk.poison import Poison

parquet = pytest.importorskip("pyarrow.parquet", reason="needs the extra bulk: pip install 'primfit[bulk]'")
fifos = pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="finds who reads a pipe in /proc")

N, EACH = 12, 3


def content_of(number: int) -> bytes:
    azimuth, polar = np.random.default_rng(number).uniform(0, 3, (2, 100))
    points = Sphere(np.array([1.0, 2.0, 3.0]), 0.5 + number).surface(azimuth, polar)
    return "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist()).encode()


@pytest.fixture
def clouds(tmp_path: Path) -> Path:
    """Spheres, a file that is no cloud, and one that is missing."""
    folder = tmp_path / "clouds"
    folder.mkdir()
    for number in range(N):
        (folder / f"{number:02}.csv").write_bytes(content_of(number))
    (folder / "04.csv").write_text("words\n")
    (folder / "05.csv").unlink()
    return folder


def planned(clouds: Path) -> list[Task]:
    refs = [Ref(f"{n:02}.csv", str(clouds / f"{n:02}.csv"), None, 100) for n in range(N)]
    return [Task(i, tuple(refs[i * EACH : (i + 1) * EACH])) for i in range(N // EACH)]


def done(clouds: Path, out: Path, team: Team, options: Mapping[str, object] | None = None) -> list[int]:
    """The tasks that were finished, in that order."""
    begun = Run.begin(out, {"clouds": "spheres"}, options or {}, lambda _: planned(clouds))
    finished: list[int] = []
    try:
        with team:
            run(begun, team, options or {}, lambda task, _: finished.append(task.number))
    finally:
        begun.end()
    return finished


def parts(out: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in part_files(out)}


def rows(out: Path) -> list[tuple[str, str, str]]:
    table = parquet.read_table([str(file) for file in part_files(out)])
    return [(row["id"], row["status"], row["message"]) for row in table.to_pylist()]


def test_parts_do_not_depend_on_who_wrote_them(clouds: Path, tmp_path: Path) -> None:
    for name, team in {"here": Team(1), "apart": Team(1, apart=True), "two": Team(2)}.items():
        assert done(clouds, tmp_path / name, team) == [0, 1, 2, 3]
    assert parts(tmp_path / "here") == parts(tmp_path / "apart") == parts(tmp_path / "two")
    found = rows(tmp_path / "here")
    assert [name for name, *_ in found] == [f"{n:02}.csv" for n in range(N)]
    assert [status for _, status, _ in found].count("fitted") == N - 2
    assert [(name, status) for name, status, _ in found[4:6]] == [
        ("04.csv", "problem"),
        ("05.csv", "problem"),
    ]
    assert found[5][2] == "No such file or directory"


def test_what_is_finished_is_not_done_again(clouds: Path, tmp_path: Path) -> None:
    done(clouds, tmp_path / "whole", Team(1))
    done(clouds, tmp_path / "again", Team(1))
    manifest = tmp_path / "again" / "_primfit" / "manifest.json"
    known = json.loads(manifest.read_bytes())
    known["parts"] = [part for part in known["parts"] if part["task"] == 0]
    manifest.write_text(json.dumps(known))
    (tmp_path / "again" / "part-000002.parquet").unlink()
    before = (tmp_path / "again" / "part-000001.parquet").stat()
    assert done(clouds, tmp_path / "again", Team(1)) == [2]
    assert (tmp_path / "again" / "part-000001.parquet").stat().st_mtime_ns == before.st_mtime_ns
    assert parts(tmp_path / "again") == parts(tmp_path / "whole")


def test_a_part_that_is_not_here_is_not_finished(clouds: Path, tmp_path: Path) -> None:
    begun = Run.begin(tmp_path / "out", {}, {}, lambda _: planned(clouds))
    try:
        task = next(begun.due())
        part = begun.writer.write(task, [problem_row(ref, "") for ref in task.refs])
        [file] = part_files(tmp_path / "out")
        file.unlink()
        with pytest.raises(OSError, match="all machines need the same folder"):
            begun.finished(task, part)
        elsewhere = replace(begun.writer, out=str(tmp_path / "none"))
        with pytest.raises(OSError, match="does not see the folder"):
            elsewhere.write(task, [])
        assert not begun.done and not (tmp_path / "none").exists()
    finally:
        begun.end()


class Elsewhere(Team):
    """A team that is taken for one on other machines."""

    here = False


def test_what_another_machine_does_not_find_is_no_problem_of_the_segment(
    clouds: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    done(clouds, tmp_path / "whole", Team(1))
    # The file that is gone is gone here, too: its row is the same.
    assert sorted(done(clouds, tmp_path / "cluster", Elsewhere(1))) == [0, 1, 2, 3]
    assert parts(tmp_path / "cluster") == parts(tmp_path / "whole")
    hidden = str(clouds / "07.csv")
    read = places.read_bytes

    def without(place: str) -> bytes:
        if place == hidden:
            raise FileNotFoundError(errno.ENOENT, "No such file or directory", place)
        return read(place)

    monkeypatch.setattr(places, "read_bytes", without)
    with pytest.raises(OSError, match=r"of the cluster does not find it.*07\.csv"):
        done(clouds, tmp_path / "blind", Elsewhere(1))


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (FileNotFoundError(2, "No such file or directory"), "problem"),
        (PermissionError(13, "ExpiredToken"), None),
    ],
)
def test_an_object_that_is_missing_is_a_row_and_a_denied_one_ends_the_run(
    error: OSError, status: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(place: str) -> bytes:
        raise error

    monkeypatch.setattr(places, "read_bytes", failing)
    ref = Ref("a", "s3://bucket/a.csv", None, 100)
    if status is None:
        with pytest.raises(PermissionError):
            row_of({}, ref)
    else:
        assert row_of({}, ref)["status"] == status


@fifos
@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("times", [1, 2, 3])
def test_a_process_that_is_killed_costs_no_answer(
    clouds: Path, tmp_path: Path, workers: int, times: int
) -> None:
    """Once: the task is given out again. Twice: segment by segment; three times: this segment once more."""
    done(clouds, tmp_path / "whole", Team(1))
    (clouds / "07.csv").unlink()
    poison = Poison(clouds / "07.csv", times, content_of(7))
    poison.start()
    assert sorted(done(clouds, tmp_path / "killed", Team(workers, apart=True))) == [0, 1, 2, 3]
    assert len(set(poison.killed)) == times
    assert parts(tmp_path / "killed") == parts(tmp_path / "whole")


@fifos
def test_a_segment_that_ends_two_processes_by_itself_is_a_row_with_its_problem(
    clouds: Path, tmp_path: Path
) -> None:
    done(clouds, tmp_path / "whole", Team(1))
    (clouds / "07.csv").unlink()
    poison = Poison(clouds / "07.csv", 5)
    poison.start()
    assert sorted(done(clouds, tmp_path / "killed", Team(2))) == [0, 1, 2, 3]
    assert len(set(poison.killed)) == 4
    expected = rows(tmp_path / "whole")
    expected[7] = ("07.csv", "problem", POISON)
    assert rows(tmp_path / "killed") == expected


class Deadly:
    """What ends any process that it is sent to."""

    def __reduce__(self) -> tuple[object, ...]:
        return sys.exit, (1,)


def test_what_ends_every_process_ends_the_run_and_is_blamed_on_no_segment(
    clouds: Path, tmp_path: Path
) -> None:
    begun = Run.begin(tmp_path / "out", {}, {}, lambda _: planned(clouds))
    try:
        with pytest.raises(LostTaskError, match="10 segments in a row"), Team(2) as team:
            run(begun, team, {"seed": Deadly()})
    finally:
        begun.end()
