"""The folder of a run: what is to be done, what is finished, and the files of both.

A part holds the rows of one task. It is written whole or not at all, by whoever did the task; the manifest
is told later. A run that was killed in between finds its parts again: what is finished is not done twice.
Nothing here depends on times, machines or the number of workers: the same run ends with the same bytes.
"""

import os
import re
import shutil
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from errno import ENOENT
from hashlib import sha256
from pathlib import Path
from socket import gethostname
from time import monotonic
from typing import Any, BinaryIO, Self

import orjson

from primfit.fitting.plain import plain
from primfit.models.names import CLASSIFIER

from ..engine.answer import versions
from . import places
from .refs import Ref
from .rows import VERSION, Row, told_of, written
from .tasks import Task

try:
    from fcntl import LOCK_EX, LOCK_NB, lockf
except ImportError:  # Windows has no such locks
    lockf = None  # type: ignore[assignment]

FOLDER = "_primfit"
"""Beside the parts; readers of Parquet leave names out that begin so."""

PATTERN = "part-*.parquet"
_NUMBERED = re.compile(r"part-\d{6,}\.parquet")
SAVED_EVERY = 5.0
"""Seconds from one writing of the manifest to the next, at least."""

SAVING = 0.05
"""Share of its time that the driver spends on the manifest at most: it is written whole, and becomes long."""

_SORTED = orjson.OPT_SORT_KEYS | orjson.OPT_INDENT_2


class OtherRunError(ValueError):
    """The folder belongs to another run, or another process is at work in it; nothing in it was touched."""


@dataclass(frozen=True, slots=True)
class Part:
    """What is known of a finished part.

    Attributes
    ----------
    rows : one a segment
    points : of its segments, as the plan has them
    statuses : how many rows there are of each
    bytes, sha256 : of the file
    """

    rows: int
    points: int
    statuses: Mapping[str, int]
    bytes: int
    sha256: str


@dataclass(frozen=True, slots=True)
class Plan:
    """What there is to do in all; points are about, as a `Ref` has them."""

    tasks: int
    segments: int
    points: int
    bytes: int


@dataclass(frozen=True, slots=True)
class Writer:
    """Writes parts of a run, in any process on any machine that has its folder; small, to be sent there."""

    out: str
    run: str

    def write(self, task: Task, rows: Sequence[Row]) -> Part:
        """The rows of the segments of a task, in their order, as its part; raises `OSError`."""
        if not (Path(self.out) / FOLDER).is_dir():
            raise OSError(ENOENT, f"machine {gethostname()} does not see the folder of the run", self.out)
        points = sum(ref.n_points for ref in task.refs)
        content = written(rows, {"run": self.run, "task": task.number, "points": points})
        places.write_whole(str(part_file(Path(self.out), task.number)), content)
        return _part(content, points, [row["status"] for row in rows])


@dataclass
class Run:
    """A run in a folder: `begin` it, do what is `due`, say what is `finished`, `end` it.

    Attributes
    ----------
    out : where the parts are
    plan : what there is to do in all
    done : what is finished of it, by the number of the task
    """

    out: Path
    identity: Mapping[str, Any]
    plan: Plan
    done: dict[int, Part]
    _lock: BinaryIO
    _saved: float = field(default_factory=monotonic)
    _pause: float = field(default_factory=lambda: SAVED_EVERY)

    @classmethod
    def begin(
        cls,
        out: Path,
        inputs: Mapping[str, Any],
        options: Mapping[str, Any],
        plan: Callable[[Path], Iterable[Task]],
    ) -> Self:
        """Begin a run, or go on with the same one where it was broken off.

        Parameters
        ----------
        out : a folder, which is made; all machines that write parts see it under this name
        inputs : what decides which segments there are, in plain values: names, labels, columns
        options : of the fit, as `engine.answer.answered` takes them
        plan : gives the tasks, numbered from 0; it may leave files that they are about in the folder it is
            given, which lasts until the end of the run. It is asked once, not again where a run goes on

        Raises
        ------
        OtherRunError
            The folder holds another run, or parts of none, or another process is at work there.
        OSError
            The folder cannot be written; or what `plan` raises.
        """
        identity = _identity(inputs, options)
        _check_same(out, identity)
        folder = out / FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        lock = _locked(folder)
        try:
            _sweep(out)
            known = _manifest(out) or {"plan": None, "parts": []}
            planned = known["plan"] and Plan(**known["plan"])
            if planned is None:
                places.write_whole(str(folder / "manifest.json"), _written(identity, None, {}, False))
                planned = _write_plan(folder, plan)
            elif _size(folder / "plan.jsonl") != planned.bytes:
                raise OtherRunError(f"{folder / 'plan.jsonl'} is not what it was; give another folder")
            done = _found(out, _run_of(identity), known["parts"])
            run = cls(out, identity, planned, done, lock)
            run.save()
        except BaseException:
            lock.close()
            raise
        return run

    @property
    def scratch(self) -> Path:
        """The folder that `plan` was given."""
        return self.out / FOLDER / "scratch"

    @property
    def writer(self) -> Writer:
        """For those who do tasks."""
        return Writer(str(self.out), _run_of(self.identity))

    @property
    def statuses(self) -> Counter[str]:
        """How many rows there are of each status so far."""
        return sum((Counter(part.statuses) for part in self.done.values()), Counter[str]())

    def due(self) -> Iterator[Task]:
        """The tasks that were not finished when this began, one after the other from the disk."""
        before = frozenset(self.done)
        with (self.out / FOLDER / "plan.jsonl").open("rb") as lines:
            for line in lines:
                if int(line[1 : line.index(b",")]) not in before:
                    number, refs = orjson.loads(line)
                    yield Task(number, tuple(map(Ref.from_plain, refs)))

    def finished(self, task: Task, part: Part) -> None:
        """A part is written; the manifest is told now and then.

        Raises `OSError` where it is not here: then it was written by a machine that has another folder of
        this name.
        """
        file = part_file(self.out, task.number)
        try:
            with file.open("rb") as stream:  # a network file system is asked again when a file is opened
                there = os.fstat(stream.fileno()).st_size
        except FileNotFoundError:
            there = None
        if there != part.bytes:
            why = "a worker has written it, but it is not here: all machines need the same folder"
            raise OSError(ENOENT, why, str(file))
        self.done[task.number] = part
        if monotonic() - self._saved >= self._pause:
            self.save()

    def save(self) -> None:
        """Write the manifest; raises `OSError`."""
        begun = monotonic()
        complete = len(self.done) == self.plan.tasks
        content = _written(self.identity, self.plan, self.done, complete)
        places.write_whole(str(self.out / FOLDER / "manifest.json"), content)
        self._saved = monotonic()
        self._pause = max(SAVED_EVERY, (self._saved - begun) / SAVING)

    def end(self) -> None:
        """Write the manifest for the last time; of a complete run what was only needed on the way goes."""
        try:
            self.save()
            if len(self.done) == self.plan.tasks:
                shutil.rmtree(self.scratch, ignore_errors=True)
                _sweep(self.out)
        finally:
            self._lock.close()


def part_file(out: Path, number: int) -> Path:
    """Where the part of a task is."""
    return out / f"part-{number:06d}.parquet"


def part_files(out: Path) -> list[Path]:
    """All parts there are, in the order of their tasks."""
    return sorted((file for file in out.glob(PATTERN) if _NUMBERED.fullmatch(file.name)), key=_number)


def progress_of(out: Path) -> tuple[int, int] | None:
    """How many tasks of the run in a folder are finished, and of how many; None where there is no run."""
    known = _manifest(out)
    if known is None:
        return None
    return len(known["parts"]), 0 if known["plan"] is None else known["plan"]["tasks"]


def _number(file: Path) -> int:
    return int(file.stem.removeprefix("part-"))


def _identity(inputs: Mapping[str, Any], options: Mapping[str, Any]) -> dict[str, Any]:
    """What decides the content of a run, as it reads back from JSON."""
    asked = {
        "schema": VERSION,
        "inputs": plain(inputs),
        "options": plain(options),
        "versions": versions(options.get("classifier", CLASSIFIER)),
    }
    read: dict[str, Any] = orjson.loads(orjson.dumps(asked, option=orjson.OPT_SORT_KEYS))
    return read


def _run_of(identity: Mapping[str, Any]) -> str:
    """A name for it that no other has."""
    return sha256(orjson.dumps(identity, option=orjson.OPT_SORT_KEYS)).hexdigest()


def _check_same(out: Path, identity: Mapping[str, Any]) -> None:
    """Raise `OtherRunError` where the folder is not free, and not that of this run."""
    known = _manifest(out)
    if known is None:
        if next(out.glob(PATTERN), None) is not None:
            raise OtherRunError(f"{out} holds parts of a run that is not known; give another folder")
        return
    if known["run"] != identity:
        told = "; ".join(_differences(known["run"], identity))
        raise OtherRunError(f"{out} holds another run ({told}); give another folder")


def _differences(there: Mapping[str, Any], now: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for name in sorted({*there, *now}):
        old, new = there.get(name), now.get(name)
        if isinstance(old, Mapping) and isinstance(new, Mapping):
            yield from _differences(old, new, f"{prefix}{name}.")
        elif old != new:
            yield f"{prefix}{name}: {_short(old)} there, {_short(new)} now"


def _short(value: Any) -> str:
    text = orjson.dumps(value).decode()
    return text if len(text) <= 60 else f"{text[:57]}..."


def _manifest(out: Path) -> dict[str, Any] | None:
    """What the manifest says; raises `OtherRunError` where it is none."""
    file = out / FOLDER / "manifest.json"
    try:
        known: dict[str, Any] = orjson.loads(file.read_bytes())
        known["run"], known["plan"], known["parts"]
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (ValueError, LookupError, TypeError):
        raise OtherRunError(f"{file} is not the manifest of a run; give another folder") from None
    return known


def _written(
    identity: Mapping[str, Any], plan: Plan | None, done: Mapping[int, Part], complete: bool
) -> bytes:
    parts = [{"task": number, **asdict(done[number])} for number in sorted(done)]
    content = {"run": identity, "plan": plan and asdict(plan), "complete": complete, "parts": parts}
    return orjson.dumps(content, option=_SORTED) + b"\n"


def _write_plan(folder: Path, plan: Callable[[Path], Iterable[Task]]) -> Plan:
    """A line a task, all of them or none."""
    scratch, file = folder / "scratch", folder / "plan.jsonl.part"
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    tasks = segments = points = size = 0
    with file.open("wb") as stream:
        for task in plan(scratch):
            size += stream.write(orjson.dumps([task.number, [ref.to_plain() for ref in task.refs]]) + b"\n")
            tasks, segments = tasks + 1, segments + len(task.refs)
            points += sum(ref.n_points for ref in task.refs)
    os.replace(file, folder / "plan.jsonl")
    return Plan(tasks, segments, points, size)


def _found(out: Path, run: str, listed: Iterable[Mapping[str, Any]]) -> dict[int, Part]:
    """The parts that are there whole: those of the manifest, and those written after it."""
    known = {each["task"]: Part(**{name: each[name] for name in each if name != "task"}) for each in listed}
    found = {}
    for file in part_files(out):
        part = known.get(_number(file))
        if part is None or part.bytes != _size(file):
            part = _read(file, run)
        if part is not None:
            found[_number(file)] = part
    return found


def _read(file: Path, run: str) -> Part | None:
    """What a part says of itself; None where it is damaged, or of another run."""
    content = file.read_bytes()
    told = told_of(content)
    if told is None or told.about.get("run") != run or told.about.get("task") != _number(file):
        return None
    return _part(content, told.about["points"], told.statuses)


def _part(content: bytes, points: int, statuses: Sequence[str]) -> Part:
    counts = dict(sorted(Counter(statuses).items()))
    return Part(len(statuses), points, counts, len(content), sha256(content).hexdigest())


def _size(file: Path) -> int | None:
    try:
        return file.stat().st_size
    except FileNotFoundError:
        return None


def _sweep(out: Path) -> None:
    """Remove what writers that were killed have left half done."""
    for file in (*out.glob(".*.part"), *(out / FOLDER).glob("*.part")):
        with suppress(OSError):
            file.unlink()


def _locked(folder: Path) -> BinaryIO:
    """A file that this process alone has; it is let go when it ends, however it ends."""
    lock = (folder / "lock").open("ab")
    if lockf is not None:
        try:
            lockf(lock, LOCK_EX | LOCK_NB)
        except (BlockingIOError, PermissionError):
            lock.close()
            raise OtherRunError(f"another process is at work in {folder.parent}; wait for its end") from None
        except OSError:  # a file system without locks
            pass
    return lock
