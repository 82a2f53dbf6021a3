"""Many clouds: the run over all of them, and what is kept of each answer."""

import os
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from primfit.fitting.shrec22 import LAYOUT

from ..bulk.places import write_whole
from ..engine.answer import to_json
from ..engine.executors import AnyTeam
from ..engine.names import Ids, plain
from ..engine.shrec22 import prediction
from ..engine.team import chunks
from .files import Answer, Problem, Source, answer_file, answer_segments
from .identity import identity
from .plan import ENDINGS, Plan, folder_of

if TYPE_CHECKING:
    from ..exports.many import Part

_POINT = 40
"""Bytes of a point in a file, roughly."""


class Kept(NamedTuple):
    """What came of a cloud: the status of its answer, why that was not written, and its part of the files
    about all clouds, if there are any."""

    status: str | None
    problem: Problem | None
    part: "Part | None" = None


class InterruptedRunError(RuntimeError):
    """Ctrl-C; the message says how many inputs were done."""


@dataclass
class Summary:
    """How many answers of each status were written, what could not be answered, and what is no cloud."""

    n_clouds: int = 0
    statuses: Counter[str] = field(default_factory=Counter)
    problems: list[Problem] = field(default_factory=list)
    skipped: list[Problem] = field(default_factory=list)
    parts: "list[Part]" = field(default_factory=list)

    def add(self, status: str | None, problem: Problem | None, part: "Part | None") -> None:
        """Count a cloud that has an answer of this status, if any, and a problem, if any."""
        if problem is not None and problem.no_cloud:
            self.skipped.append(problem)
            return
        self.n_clouds += 1
        if status is not None:
            self.statuses[status] += 1
        if problem is not None:
            self.problems.append(problem)
        if part is not None:
            self.parts.append(part)


@dataclass(frozen=True)
class Gather:
    """What is gathered of each answer for the files about all clouds; pictures, too, if wanted."""

    pictures: bool


def run(
    plan: Plan,
    format: str,
    options: Mapping[str, Any],
    workers: AnyTeam,
    labels: str | None = None,
    gather: Gather | None = None,
) -> Summary:
    """Answer every input, write what was found, and say what was not; progress shows on a terminal.

    `workers` share the work; they begin and end here.

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

    targets, summary, finished = plan.targets, Summary(), 0
    before = {target: identity(target) for target in targets}
    terminal = Console(stderr=True)
    columns = (TextColumn("fitting"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    try:
        with (
            workers as team,
            Progress(*columns, console=terminal, disable=not terminal.is_terminal) as progress,
        ):
            task = progress.add_task("fitting", total=len(targets))
            for number, kept in _kept(plan, format, options, labels, gather, team):
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
    plan: Plan,
    format: str,
    options: Mapping[str, Any],
    labels: str | None,
    gather: Gather | None,
    team: AnyTeam,
) -> Iterator[tuple[int, Kept]]:
    """The number of an input, and what came of it, or of each of its segments."""
    places = _Places(plan, format, gather, labels)
    names = list(plan.targets.values())
    if labels:
        for source, kept in answer_segments(names, options, labels, team, places.keep):
            yield source.number, kept
        return
    jobs = [places.keep(Source(number, name)) for number, name in enumerate(names, 1)]
    shares = chunks(jobs, [_n_points(name) for name in names], team.size)
    work = partial(_answer_file, options)
    yield from enumerate(team.in_order(team.submit(work, share) for share in shares), 1)


def _n_points(name: str) -> int:
    """About how many points a file holds."""
    try:
        return os.stat(name).st_size // _POINT
    except OSError:
        return 0


def _answer_file(options: Mapping[str, Any], keep: "Keeper") -> Kept:
    return keep(answer_file(keep.name, options))


class _Places:
    """Where answers go that are made in the order of the inputs and of their labels."""

    def __init__(self, plan: Plan, format: str, gather: Gather | None, labels: str | None) -> None:
        self._plan, self._targets, self._format = plan, list(plan.targets), format
        self._gather, self._labels, self._names = gather, labels, Ids()
        self._n_segments = 0

    def keep(self, source: Source) -> "Keeper":
        """Writes the answer for a file to its place, that for a segment into its folder."""
        target, number = self._targets[source.number - 1], source.number
        where = {"file": source.name} | ({"label": source.label} if self._labels else {})
        if source.label is not None:
            own = folder_of(target, self._format) / (plain(str(source.label)) or "_")
            target = Path(self._names.unique(str(own)) + ENDINGS[self._format])
            self._n_segments += 1
            number = self._n_segments
        inner = self._plan.searched.get(source.name)
        short = replace(source, name=Path(source.name).name if inner is None else str(inner)).title
        gather = self._gathered(number)
        return Keeper(target, source.title, self._format, inner is not None, where, short, gather)

    def _gathered(self, number: int) -> Gather | None:
        """Of the first clouds with pictures, where these are wanted."""
        if self._gather is None or not self._gather.pictures:
            return self._gather
        from ..exports.many import PICTURED

        return replace(self._gather, pictures=number <= PICTURED)


@dataclass(frozen=True)
class Keeper:
    """Keeps an answer, in the process that made it.

    Attributes
    ----------
    target : where it is written
    name : of the cloud, before people
    searched : the cloud was found in a folder: it is left out if it is not meant for one
    where, short : the same by column of a table, and without the folder that was searched
    gather : what is gathered for files about all clouds, if there are any
    """

    target: Path
    name: str
    format: str
    searched: bool
    where: Mapping[str, Any]
    short: str
    gather: Gather | None

    def __call__(self, answer: Answer) -> Kept:
        """Write it, where there is one and the format has it."""
        if isinstance(answer, Problem):
            return Kept(None, replace(answer, no_cloud=answer.no_cloud and self.searched), self._part(answer))
        content = answer[1]
        return Kept(content["status"], self._written(content), self._part(answer))

    def _written(self, content: Mapping[str, Any]) -> Problem | None:
        """Why it was not written; None where it was."""
        if self.format == "json":
            write_whole(str(self.target), to_json(content) + b"\n")
        elif content["primitive"] is None:
            return Problem(self.name, f"nothing to write: {content['message']}")
        elif content["primitive"]["kind"] not in LAYOUT:
            kind = content["primitive"]["kind"]
            return Problem(self.name, f"nothing to write: the SHREC 2022 track has no {kind}")
        else:
            write_whole(str(self.target), prediction(content["primitive"]).encode())
        return None

    def _part(self, answer: Answer) -> "Part | None":
        """Its part of the files about all clouds, without the points."""
        if self.gather is None:
            return None
        from ..exports.many import Part, pictured

        if isinstance(answer, Problem):
            return Part(self.where, self.short, None, answer.message)
        part = Part(self.where, self.short, answer[0])
        if self.gather.pictures:
            part = pictured(part)
        return replace(part, recognition=replace(answer[0], points=None))
