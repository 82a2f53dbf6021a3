"""What the app itself is asked: how it cuts segments into tasks, and what it sends for one.

Apart from `speed/asked.py` the only place of the benchmark that imports the app; `pyproject.toml` says so.
"""

import pickle
from collections.abc import Iterable, Iterator
from pathlib import Path

import orjson

from primfit.app.bulk.parts import FOLDER, Part, Writer, part_file, part_files
from primfit.app.bulk.refs import Ref
from primfit.app.bulk.tasks import Task, tasks


def cut(points: Iterable[int]) -> list[tuple[int, int]]:
    """Segments and points of each task, for segments of so many points."""
    refs = (Ref(str(index), "", None, n) for index, n in enumerate(points))
    return [(len(task.refs), sum(ref.n_points for ref in task.refs)) for task in tasks(refs)]


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


def _size(message: object) -> int:
    return len(pickle.dumps(message, pickle.HIGHEST_PROTOCOL))


__all__ = ["FOLDER", "cut", "part_file", "part_files", "planned", "sent"]
