"""The folder of a run: refused where it is another's, gone on with after a kill, the same at its end."""

import json
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from primfit.app.bulk import parts
from primfit.app.bulk.parts import OtherRunError, Part, Run, part_file, part_files, progress_of
from primfit.app.bulk.rows import problem_row
from primfit.app.bulk.tasks import Task
from tests.app.bulk import killed

pytest.importorskip("pyarrow", reason="needs pyarrow, of the extra bulk")
INPUTS, OPTIONS = {"names": ["a.las"]}, {"seed": 1}


def begun(out: Path, **changed: object) -> Run:
    return Run.begin(out, INPUTS, OPTIONS | changed, killed.tasks)


def do(run: Run, task: Task) -> Part:
    part = run.writer.write(task, [problem_row(ref, "no points") for ref in task.refs])
    run.finished(task, part)
    return part


def finish(run: Run) -> list[int]:
    """Do what is due; the numbers of these tasks."""
    numbers = []
    for task in run.due():
        do(run, task)
        numbers.append(task.number)
    run.end()
    return numbers


def forbidden(scratch: Path) -> Iterator[Task]:
    raise AssertionError("the plan is there already")


@pytest.mark.skipif(
    not hasattr(sys, "addaudithook") or sys.platform == "win32", reason="needs fork and SIGKILL"
)
@pytest.mark.slow
@pytest.mark.parametrize("often", ["often", "at the end"])
def test_a_run_killed_anywhere_goes_on_and_ends_with_the_same_bytes(often: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.app.bulk.killed", tmp_path / "runs", often],
        capture_output=True, text=True, cwd=Path(__file__).parents[3],
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    runs = [json.loads(line) for line in done.stdout.splitlines()]
    # Each task opens its part and renames it; the plan and the manifest come on top.
    assert len(runs) > 2 * killed.N_TASKS + 10
    assert all(run["same"] for run in runs)
    assert not any(run["again"] for run in runs)
    assert [run["ended"][0] for run in runs] == [False] * (len(runs) - 1) + [True]


def test_nothing_but_the_run_is_left_at_its_end(tmp_path: Path) -> None:
    run = begun(tmp_path)
    assert finish(run) == [0, 1, 2, 3]
    assert sorted(killed.tree(tmp_path)) == [
        "_primfit/lock",
        "_primfit/manifest.json",
        "_primfit/plan.jsonl",
        *(f"part-{number:06d}.parquet" for number in range(4)),
    ]
    manifest = json.loads((tmp_path / "_primfit" / "manifest.json").read_bytes())
    assert manifest["complete"] is True
    assert manifest["plan"]["segments"] == 12 and manifest["plan"]["points"] == 1200
    assert [part["rows"] for part in manifest["parts"]] == [3] * 4
    assert manifest["parts"][0]["statuses"] == {"problem": 3}
    assert run.statuses == {"problem": 12}


def test_a_finished_run_has_nothing_to_do(tmp_path: Path) -> None:
    finish(begun(tmp_path))
    before = killed.tree(tmp_path)
    assert finish(Run.begin(tmp_path, INPUTS, OPTIONS, forbidden)) == []
    assert killed.tree(tmp_path) == before


def test_the_plan_is_made_once(tmp_path: Path) -> None:
    run = begun(tmp_path)
    do(run, next(run.due()))
    run.end()
    assert progress_of(tmp_path) == (1, 4)
    assert finish(Run.begin(tmp_path, INPUTS, OPTIONS, forbidden)) == [1, 2, 3]


@pytest.mark.parametrize(
    ("inputs", "options", "told"),
    [
        (INPUTS, {"seed": 2}, "options.seed: 1 there, 2 now"),
        (INPUTS, {"seed": 1, "unit": "m"}, 'options.unit: null there, "m" now'),
        ({"names": ["b.las"]}, OPTIONS, 'inputs.names: ["a.las"] there, ["b.las"] now'),
    ],
)
@pytest.mark.parametrize("complete", [True, False])
def test_another_run_is_refused_and_nothing_touched(
    inputs: dict[str, object], options: dict[str, object], told: str, complete: bool, tmp_path: Path
) -> None:
    run = begun(tmp_path)
    do(run, next(run.due()))
    if complete:
        finish(run)
    run.end()
    (tmp_path / ".left.part").write_bytes(b"half")
    before = {file: (file.stat().st_mtime_ns, file.stat().st_ino) for file in tmp_path.rglob("*")}
    with pytest.raises(OtherRunError) as error:
        Run.begin(tmp_path, inputs, options, killed.tasks)
    assert str(error.value) == f"{tmp_path} holds another run ({told}); give another folder"
    assert {file: (file.stat().st_mtime_ns, file.stat().st_ino) for file in tmp_path.rglob("*")} == before


def test_parts_of_an_unknown_run_are_not_written_over(tmp_path: Path) -> None:
    part_file(tmp_path, 0).write_bytes(b"of somebody")
    with pytest.raises(OtherRunError, match="holds parts of a run that is not known"):
        begun(tmp_path)
    assert [file.name for file in tmp_path.iterdir()] == ["part-000000.parquet"]


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"run": {}}'])
def test_a_manifest_that_is_none_is_refused(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "_primfit").mkdir()
    (tmp_path / "_primfit" / "manifest.json").write_bytes(content)
    with pytest.raises(OtherRunError, match=r"is not the manifest of a run"):
        begun(tmp_path)


@pytest.mark.parametrize("harm", ["cut", "gone", "of another run"])
def test_a_part_that_is_not_whole_is_done_again(harm: str, tmp_path: Path) -> None:
    run = begun(tmp_path / "out")
    finish(run)
    before = killed.tree(tmp_path / "out")
    part = part_file(tmp_path / "out", 2)
    if harm == "cut":
        part.write_bytes(part.read_bytes()[:-100])
    elif harm == "gone":
        part.unlink()
    else:
        other = begun(tmp_path / "other", seed=2, unit="m")
        finish(other)
        part.write_bytes(part_file(tmp_path / "other", 2).read_bytes())
        (manifest := tmp_path / "out" / "_primfit" / "manifest.json").write_bytes(
            manifest.read_bytes().replace(
                f'"bytes": {len(bytes.fromhex(before[part.name]))}'.encode(), b'"bytes": 1'
            )
        )
    # What a plan has left for its tasks went with the end of the run.
    assert finish(Run.begin(tmp_path / "out", INPUTS, OPTIONS, forbidden)) == [2]
    assert killed.tree(tmp_path / "out") == before


def test_a_plan_that_was_changed_is_refused(tmp_path: Path) -> None:
    begun(tmp_path).end()
    with (tmp_path / "_primfit" / "plan.jsonl").open("ab") as plan:
        plan.write(b"[4, []]\n")
    with pytest.raises(OtherRunError, match=r"plan.jsonl is not what it was"):
        begun(tmp_path)


@pytest.mark.skipif(sys.platform == "win32", reason="needs locks of POSIX")
def test_two_processes_do_not_work_in_one_folder(tmp_path: Path) -> None:
    run = begun(tmp_path)
    script = (
        "import sys; from pathlib import Path; from tests.app.bulk import killed\n"
        "killed.work(Path(sys.argv[1]), Path(sys.argv[1]) / 'told')"
    )
    order = [sys.executable, "-c", script, str(tmp_path)]
    root = Path(__file__).parents[3]
    done = subprocess.run(order, capture_output=True, text=True, cwd=root)
    assert f"another process is at work in {tmp_path}" in done.stderr.splitlines()[-1]
    run.end()
    assert subprocess.run(order, cwd=root).returncode == 0


def test_a_plan_that_breaks_off_leaves_no_plan(tmp_path: Path) -> None:
    def broken(scratch: Path) -> Iterator[Task]:
        yield next(killed.tasks(scratch))
        raise OSError("no such bucket")

    with pytest.raises(OSError, match="no such bucket"):
        Run.begin(tmp_path, INPUTS, OPTIONS, broken)
    assert not (tmp_path / "_primfit" / "plan.jsonl").exists()
    assert finish(begun(tmp_path)) == [0, 1, 2, 3]


def test_a_manifest_that_takes_long_is_written_more_seldom(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "_primfit" / "manifest.json"
    run = begun(tmp_path)
    times = iter([100.0, 102.0])  # of the beginning and the end of a writing
    monkeypatch.setattr(parts, "monotonic", lambda: next(times))
    run.save()
    before, [first, second, *_] = file.read_bytes(), run.due()
    times = iter([102.0 + 2.0 / parts.SAVING - 0.1])
    do(run, first)
    assert file.read_bytes() == before
    times = iter([102.0 + 2.0 / parts.SAVING] * 3)
    do(run, second)
    assert len(json.loads(file.read_bytes())["parts"]) == 2
    monkeypatch.undo()
    run.end()


def test_parts_are_in_the_order_of_their_tasks(tmp_path: Path) -> None:
    for number in (1_000_000, 999_999, 3):
        part_file(tmp_path, number).touch()
    assert part_files(tmp_path) == [part_file(tmp_path, number) for number in (3, 999_999, 1_000_000)]


def test_a_plan_of_many_tasks_is_not_held_in_memory(tmp_path: Path) -> None:
    import tracemalloc

    def many(scratch: Path) -> Iterator[Task]:
        return (Task(number, killed.refs_of(number)) for number in range(20_000))

    tracemalloc.start()
    run = Run.begin(tmp_path, INPUTS, OPTIONS, many)
    assert sum(len(task.refs) for task in run.due()) == 60_000
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (tmp_path / "_primfit" / "plan.jsonl").stat().st_size > 2_000_000
    assert most < 1_000_000
    run.end()
