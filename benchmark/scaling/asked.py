"""What the app is asked: how it cuts segments into tasks, what it sends for one, and what its steps cost.

Apart from `speed/asked.py` the only place of the benchmark that imports the app; `pyproject.toml` says so.
"""

import pickle
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import cycle, islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import orjson

from primfit.app.bulk.parts import FOLDER, SAVED_EVERY, SAVING, Part, Run, Writer, part_file, part_files
from primfit.app.bulk.refs import Ref
from primfit.app.bulk.run import row_of
from primfit.app.bulk.sources import references
from primfit.app.bulk.tasks import Task, tasks
from primfit.app.engine.executors import team_of
from primfit.app.engine.ray_team import RayTeam
from primfit.app.engine.team import AHEAD, LostWorkerError

from .records import Executor

_PART = Part(250, 180_000, {"ambiguous": 20, "fitted": 230}, 400_000, "0" * 64)


def cut(points: Iterable[int]) -> list[tuple[int, int, int]]:
    """Segments of each task, their points, and the sum of their squares, for segments of so many points."""
    refs = (Ref(str(index), "", None, n) for index, n in enumerate(points))
    return [holds(task) for task in tasks(refs)]


def holds(task: Task) -> tuple[int, int, int]:
    """What `cut` says of a task."""
    points = [ref.n_points for ref in task.refs]
    return len(points), sum(points), sum(n * n for n in points)


def planned(out: Path) -> Iterator[Task]:
    """The tasks of a run."""
    with (out / FOLDER / "plan.jsonl").open("rb") as lines:
        for line in lines:
            number, refs = orjson.loads(line)
            yield Task(number, tuple(map(Ref.from_plain, refs)))


def sent(out: Path) -> tuple[int, int]:
    """Bytes that go to processes for the tasks of a run, and bytes that come back."""
    manifest = orjson.loads((out / FOLDER / "manifest.json").read_bytes())
    parts = [Part(**{k: v for k, v in each.items() if k != "task"}) for each in manifest["parts"]]
    writer = Writer(str(out), "0" * 64)
    there = sum(_size((writer, [task])) for task in planned(out))
    return there, sum(_size(([part], None)) for part in parts)


def answers(out: Path) -> list[tuple[Any, ...]]:
    """Status, kind, number of points and radius of each row of a run, in their order."""
    import pyarrow.parquet

    columns = ["status", "kind", "n_points", "radius"]
    tables = (pyarrow.parquet.read_table(str(file), columns=columns) for file in part_files(out))
    return [tuple(row.values()) for table in tables for row in table.to_pylist()]


def _size(message: object) -> int:
    return len(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))


def segment_seconds(out: Path) -> tuple[list[tuple[int, float]], list[float]]:
    """Points and processor time of each segment of a run from its points to its row, and the time that it
    takes to write each part."""
    segments, parts = list[tuple[int, float]](), list[float]()
    with TemporaryDirectory() as folder:
        (Path(folder) / FOLDER).mkdir()  # as in the folder of a run
        writer = Writer(folder, "0" * 64)
        for task in planned(out):
            if not segments:
                row_of({}, task.refs[0])  # loads the weights
            rows = []
            for ref in task.refs:
                before = time.process_time()
                rows.append(row_of({}, ref))
                segments.append((ref.n_points, time.process_time() - before))
            before = time.process_time()
            writer.write(task, rows)
            parts.append(time.process_time() - before)
    return segments, parts


def driver_seconds(out: Path, n: int, executor: Executor, workers: int, address: str | None) -> float:
    """Seconds of processor time of a driver for a task like those of a run, from its line of the plan on,
    where workers have nothing to do."""
    given = list(islice(cycle(list(planned(out))), n))
    lines = [orjson.dumps([task.number, [ref.to_plain() for ref in task.refs]]) for task in given]
    with team_of(executor, workers if executor == "local" else None, address, apart=True) as team:
        list(team.in_order(team.submit(_nothing, [task]) for task in given[: 2 * workers]))
        before = time.process_time()
        list(team.in_order(team.submit(_nothing, [task]) for task in map(_read, lines)))
        return (time.process_time() - before) / n


def _read(line: bytes) -> Task:
    number, refs = orjson.loads(line)
    return Task(number, tuple(map(Ref.from_plain, refs)))


def _nothing(task: Task) -> Part:
    return _PART


def planning_seconds(list_: Path, n: int) -> float:
    """Seconds to plan, for each of the n segments of the files of a list, without the first imports."""
    return min(_planning(f"@{list_}") for _ in range(3)) / n


def _planning(given: str) -> float:
    with TemporaryDirectory() as folder:
        before = time.perf_counter()
        run = Run.begin(
            Path(folder) / "run",
            {"inputs": [given], "labels": None, "columns": None},
            {},
            lambda scratch: tasks(references([given], None, None, str(scratch))),
        )
        took = time.perf_counter() - before
        run.end()
    return took


def saving_seconds(n: int) -> float:
    """Seconds to write a manifest, for each of n parts in it."""
    with TemporaryDirectory() as folder:
        run = Run.begin(
            Path(folder) / "run", {"inputs": [], "labels": None, "columns": None}, {}, lambda _: []
        )
        run.done = {number: replace(_PART, rows=number) for number in range(n)}
        before = time.perf_counter()
        run.save()
        took = time.perf_counter() - before
        run.done = {}
        run.end()
        return took / n


def detection_seconds(address: str, kill: Iterator[None]) -> float:
    """Seconds from the loss of the only node, by `next(kill)` while it is at work, to the error."""
    with RayTeam(1, address) as team:
        asked = team.submit(time.sleep, [0.01])
        asked.results()
        asked = team.submit(time.sleep, [600])
        time.sleep(3.0)
        next(kill, None)
        before = time.perf_counter()
        try:
            asked.results()
        except LostWorkerError:
            return time.perf_counter() - before
    raise AssertionError("a task of a lost node has ended")


__all__: Sequence[str] = (
    "AHEAD",
    "FOLDER",
    "SAVED_EVERY",
    "SAVING",
    "cut",
    "detection_seconds",
    "driver_seconds",
    "holds",
    "part_file",
    "part_files",
    "planned",
    "planning_seconds",
    "saving_seconds",
    "segment_seconds",
    "sent",
)
