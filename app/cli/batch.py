"""Many clouds: which files, where each answer goes, and the run over all of them."""

import os
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

from primfit.fitting.shrec22 import LAYOUT

from ..engine.answer import to_json
from ..engine.names import Ids, plain
from ..engine.shrec22 import prediction
from ..engine.team import Team, chunks
from ..readers import FORMATS
from .files import Answer, Keep, Problem, Source, answer_file, answer_segments
from .identity import identity

# Answers are JSON: in a folder none is taken for a cloud.
SUFFIXES = tuple(
    sorted(extension for format in FORMATS if format.name != "json" for extension in format.extensions)
)
PACKED = (".gz", ".zst")
ENDINGS = {"json": ".json", "shrec22": "_prediction.txt"}
_POINT = 40
"""Bytes of a point in a file, roughly."""


class InterruptedRunError(RuntimeError):
    """Ctrl-C; the message says how many inputs were done."""


class CollisionError(ValueError):
    """Two inputs would write the same output, or an output would overwrite an input."""


@dataclass
class Summary:
    """How many answers of each status were written, and what could not be answered."""

    n_clouds: int = 0
    statuses: Counter[str] = field(default_factory=Counter)
    problems: list[Problem] = field(default_factory=list)

    def add(self, status: str | None, problem: Problem | None) -> None:
        """Count a cloud that has an answer of this status, if any, and a problem, if any."""
        self.n_clouds += 1
        if status is not None:
            self.statuses[status] += 1
        if problem is not None:
            self.problems.append(problem)


def plan(inputs: Sequence[str], out: Path, format: str, labels: str | None = None) -> dict[Path, str]:
    """Output -> input, in a fixed order; a folder is searched and its inner folders are kept in `out`.

    With `labels` the answers for the segments of an input go into a folder: its output without the ending.

    Raises
    ------
    CollisionError
        If two inputs differ only in their suffix or folder, or in a link on the way to their outputs, so that
        one answer would overwrite the other.
    """
    targets: dict[Path, str] = {}
    places: dict[Path, str] = {}
    real = cache(Path.resolve)
    for name, inner in _expand(inputs):
        target = out / inner.with_name(_unpacked(inner).stem + ENDINGS[format])
        place = real(target.parent) / target.name
        if place not in places:
            places[place] = targets[target] = name
        elif Path(places[place]).resolve() != Path(name).resolve():
            raise CollisionError(f"{places[place]} and {name} would both write {target}")
    sources = {identity(name) for name in targets.values()} - {None}
    for target, name in targets.items():
        if identity(target) in sources:
            raise CollisionError(f"the answer for {name} would overwrite the input {target}")
    if labels:
        _check_folders({_folder(target, format): name for target, name in targets.items()})
    return targets


def _folder(target: Path, format: str) -> Path:
    """Where the answers for the segments of an input go, if its own answer would be `target`."""
    return target.with_name(target.name.removesuffix(ENDINGS[format]))


def _check_folders(folders: Mapping[Path, str]) -> None:
    """No two inputs write into one folder, and none into a folder that an input lies in."""
    resolved: dict[Path, str] = {}
    for folder, name in folders.items():
        other = resolved.setdefault(folder.resolve(), name)
        if other != name:
            raise CollisionError(f"{other} and {name} would both write into {folder}")
    for folder, name in resolved.items():
        for outer in resolved.keys() & set(folder.parents):
            raise CollisionError(f"{resolved[outer]} and {name} would both write into {outer}")
        for inner in resolved.keys() & set(Path(name).resolve().parents):
            raise CollisionError(f"the answers for {resolved[inner]} would lie beside the input {name}")


def _expand(inputs: Sequence[str]) -> list[tuple[str, Path]]:
    """Files as (name, path inside the output folder)."""
    found = []
    for name in inputs:
        path = Path(name)
        if not path.is_dir():
            found.append((name, Path(path.name)))
            continue
        for file in sorted(path.rglob("*")):
            if (
                _unpacked(file).suffix.lower() in SUFFIXES
                and file.is_file()
                and not file.name.endswith(ENDINGS["shrec22"])
            ):
                found.append((str(file), file.relative_to(path)))
    return found


def _unpacked(file: Path) -> Path:
    """`cloud.csv` for `cloud.csv.gz`."""
    return file.with_suffix("") if file.suffix.lower() in PACKED else file


Kept = tuple[str | None, Problem | None]
"""The status of an answer, and why it was not written."""


def run(
    targets: Mapping[Path, str],
    format: str,
    options: Mapping[str, Any],
    workers: int,
    labels: str | None = None,
) -> Summary:
    """Answer every input, write what was found, and say what was not; progress shows on a terminal.

    Raises
    ------
    OSError
        An answer cannot be written.
    LostWorkerError
        A process was ended from outside.
    InterruptedRunError
        Ctrl-C was pressed.
    """
    # Imported here, because every process looks up in this file what to do.
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    summary, finished = Summary(), 0
    before = {target: identity(target) for target in targets}
    terminal = Console(stderr=True)
    columns = (TextColumn("fitting"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    try:
        with (
            Team(workers if labels else min(workers, len(targets))) as team,
            Progress(*columns, console=terminal, disable=not terminal.is_terminal) as progress,
        ):
            task = progress.add_task("fitting", total=len(targets))
            for number, kept in _kept(targets, format, options, labels, team):
                summary.add(*kept)
                progress.update(task, completed=number)
                # The last segment of a file looks like any other.
                finished = number - 1 if labels else number
    except KeyboardInterrupt:
        # Processes are ahead of what came back from them: each answer is a new file.
        later = sum(identity(target) not in (None, before[target]) for target in list(targets)[finished:])
        raise InterruptedRunError(f"{finished + later} of {len(targets)} done") from None
    return summary


def _kept(
    targets: Mapping[Path, str], format: str, options: Mapping[str, Any], labels: str | None, team: Team
) -> Iterator[tuple[int, Kept]]:
    """The number of an input, and what came of it, or of each of its segments."""
    if labels:
        keep = _Places(list(targets), format).keep
        for source, kept in answer_segments(list(targets.values()), options, labels, team, keep):
            yield source.number, kept
        return
    jobs = list(targets.items())
    shares = chunks(jobs, [_n_points(name) for name in targets.values()], team.size)
    work = partial(_answer_file, options, format)
    yield from enumerate(team.in_order(team.submit(work, share) for share in shares), 1)


def _n_points(name: str) -> int:
    """About how many points a file holds."""
    try:
        return os.stat(name).st_size // _POINT
    except OSError:
        return 0


def _answer_file(options: Mapping[str, Any], format: str, job: tuple[Path, str]) -> Kept:
    target, name = job
    return keep(target, name, format, answer_file(name, options))


class _Places:
    """Where answers go that are made in the order of the inputs and of their labels."""

    def __init__(self, targets: list[Path], format: str) -> None:
        self._targets, self._format, self._names = targets, format, Ids()

    def keep(self, source: Source) -> Keep[Kept]:
        """Writes the answer for a file to its place, that for a segment into its folder."""
        target = self._targets[source.number - 1]
        if source.label is not None:
            own = _folder(target, self._format) / (plain(str(source.label)) or "_")
            target = Path(self._names.unique(str(own)) + ENDINGS[self._format])
        return partial(keep, target, source.title, self._format)


def keep(target: Path, name: str, format: str, answer: Answer) -> Kept:
    """Write an answer, where there is one and the format has it."""
    if isinstance(answer, Problem):
        return None, answer
    if format == "json":
        _write(target, to_json(answer) + b"\n")
    elif answer["primitive"] is None:
        return answer["status"], Problem(name, f"nothing to write: {answer['message']}")
    elif answer["primitive"]["kind"] not in LAYOUT:
        kind = answer["primitive"]["kind"]
        return answer["status"], Problem(name, f"nothing to write: the SHREC 2022 track has no {kind}")
    else:
        _write(target, prediction(answer["primitive"]).encode())
    return answer["status"], None


def _write(target: Path, text: bytes) -> None:
    """Write all of it or nothing, so that an interrupted run leaves no half of an answer.

    It is renamed from a random name: one made from that of the answer may be the name of an input.
    """
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{os.urandom(8).hex()}.part")
    try:
        with part.open("xb") as stream:
            stream.write(text)
        os.replace(part, target)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(target)) from None
    finally:
        with suppress(OSError):  # it is there after a failure only
            part.unlink()
