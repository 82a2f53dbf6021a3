"""The work of a run: tasks go out to a team, parts are written where the work is done, and what is lost is
done again.

A task whose process is lost is given out once more, for mostly a machine was lost and the task is not to
blame. If that is lost, too, its segments are fitted one by one in a process apart: the one that ends its
process twice becomes a row with its problem, and the others keep their answers.
"""

import errno
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from socket import gethostname
from typing import Any

from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

from ..engine.answer import answered
from ..engine.executors import AnyTeam
from ..engine.team import LostWorkerError, Outcome, Team
from ..readers import UnreadableFileError
from . import grouping, places
from .parts import Part, Run, Writer
from .refs import Ref, cloud_at
from .rows import Row, answered_row, problem_row
from .tasks import Task

MOST_LOST = 5
"""Times that a task may lose its process without one of its segments being to blame."""

MOST_ENDED = 10
"""Segments in a row that end their processes: then it is something else that does."""

POISON = "the process that fitted it ended, and another one did, too: it may need more memory than there is"

Told = Callable[[Task, Part], None]


class LostTaskError(RuntimeError):
    """Processes are lost again and again, and no segment is to blame."""


def run(run: Run, team: AnyTeam, options: Mapping[str, Any], told: Told = lambda *_: None) -> None:
    """Do what is due.

    Parameters
    ----------
    run : begun; who begins it ends it
    team : who does the tasks
    options : as `engine.answer.answered` takes them
    told : is called for each task that is finished

    Raises
    ------
    LostTaskError
        Processes cannot keep alive.
    OSError
        A part cannot be written, or what a segment is stored in cannot be read for now. The run can go on.
    """
    lost: Iterable[Task] = run.due()
    for _ in range(2):
        lost = _round(run, team, options, lost, told)
    if not lost:
        return
    with Team(1, apart=True) as apart:
        care = _Care(apart, options)
        for task in lost:
            _finish(run, task, care.part(run.writer, task), told)


def _round(
    run: Run, team: AnyTeam, options: Mapping[str, Any], tasks: Iterable[Task], told: Told
) -> list[Task]:
    """Give these tasks to the team; returns those that were lost."""
    work = partial(_done, run.writer, options, team.here)
    asked: Iterator[Outcome[tuple[Task, Part | None, bool]]] = (
        _Given(task, team.submit(work, [task])) for task in tasks
    )
    lost: list[Task] = []
    in_a_row = 0
    for task, part, process_lost in team.in_order(asked):
        if part is not None:
            _finish(run, task, part, told)
        else:
            lost.append(task)
        if not process_lost:
            in_a_row = 0
            continue
        in_a_row += 1
        if in_a_row > MOST_LOST * max(10, team.size):
            raise LostTaskError(f"{in_a_row} tasks in a row lost their process; is there enough memory?")
    return lost


def _finish(run: Run, task: Task, part: Part, told: Told) -> None:
    run.finished(task, part)
    told(task, part)


@dataclass(frozen=True)
class _Given:
    """A task that the team has, with its part, or None and whether that is because its process was lost."""

    task: Task
    outcome: Outcome[Part]

    def results(self) -> list[tuple[Task, Part | None, bool]]:
        try:
            return [(self.task, part, False) for part in self.outcome.results()]
        except LostWorkerError:
            return [(self.task, None, True)]
        except MissingHereError as missing:
            if os.access(missing.place, os.R_OK):
                why = f"machine {missing.machine} of the cluster does not find it: {missing.why}"
                raise OSError(errno.ENOENT, why, missing.place) from None
            return [(self.task, None, False)]


class MissingHereError(RuntimeError):
    """A file is not on this machine of a cluster; it may be on the one that the run was started on."""

    def __init__(self, place: str, why: str, machine: str) -> None:
        super().__init__(place, why, machine)
        self.place, self.why, self.machine = place, why, machine


def _done(writer: Writer, options: Mapping[str, Any], here: bool, task: Task) -> Part:
    """Do a task, in a process of the team."""
    return writer.write(task, [row_of(options, ref, here) for ref in task.refs])


def row_of(options: Mapping[str, Any], ref: Ref, here: bool = True) -> Row:
    """The row of a segment: its answer, or what is wrong with it.

    `here` says that this is the machine that the run was started on. What another one does not find is no
    problem of the segment.

    Raises
    ------
    LostWorkerError
        There is not enough memory, which is so on this machine only.
    MissingHereError
        Its file is not on this machine.
    OSError
        What is stored for it, or lies on another machine, cannot be read for now.
    """
    try:
        cloud, used = cloud_at(ref, options)
        return answered_row(ref, *answered(cloud, used))
    except MemoryError:
        raise LostWorkerError("there is not enough memory") from None
    except OSError as error:
        place, why = ref.store or ref.file, error.strerror or str(error)
        own = (FileNotFoundError, IsADirectoryError) if places.is_remote(place) else _OF_THE_FILE
        if grouping.is_store(place) or not isinstance(error, own):
            raise
        if not (here or places.is_remote(place)):
            raise MissingHereError(place, why, gethostname()) from None
        return problem_row(ref, why)
    except UnreadableFileError as error:
        return problem_row(ref, f"{error.field}: {error.message}")
    except (InvalidPointCloudError, InvalidOptionError) as error:
        return problem_row(ref, str(error))
    except Exception as error:  # one segment must not cost the others their answers
        return problem_row(ref, f"internal error, please report it: {error!r}")


_OF_THE_FILE = (FileNotFoundError, PermissionError, IsADirectoryError, NotADirectoryError)
"""What may be wrong with a file itself. Of a server it is not that access is denied: credentials expire."""


class _Care:
    """Tasks done segment by segment in one process.

    `_lost` counts the processes of a task that no segment is to blame for; `_ended` the segments in a row,
    of all tasks, that ended theirs.
    """

    def __init__(self, apart: Team, options: Mapping[str, Any]) -> None:
        self._apart, self._work = apart, partial(row_of, options)
        self._lost = self._ended = 0

    def part(self, writer: Writer, task: Task) -> Part:
        """Do a task; raises `LostTaskError`."""
        self._lost = 2
        return writer.write(task, [self._row(ref) for ref in task.refs])

    def _row(self, ref: Ref) -> Row:
        for attempt in range(2):
            self._wait_for_a_process()
            try:
                [row] = self._apart.submit(self._work, [ref]).results()
            except LostWorkerError:
                continue
            self._lost, self._ended = self._lost + attempt, 0
            return row
        self._ended += 1
        if self._ended >= MOST_ENDED:
            raise LostTaskError(f"{self._ended} segments in a row ended their processes, up to {ref.id}")
        return problem_row(ref, POISON)

    def _wait_for_a_process(self) -> None:
        """One that has shown that it lives, so that what ends it next is what it is given next."""
        while True:
            try:
                self._apart.submit(_nothing, [None]).results()
                return
            except LostWorkerError as error:
                self._lost += 1
                if self._lost >= MOST_LOST:
                    raise LostTaskError(
                        f"a task lost its process {self._lost} times, and no segment is to blame: {error}"
                    ) from None


def _nothing(_: None) -> None:
    """What any process that lives can do."""
