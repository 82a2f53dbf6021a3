"""The answer for a file on disk or on standard input: what the command line asks of the engine."""

import sys
from collections import deque
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError
from primfit.fitting.names import ANSWER_PARTS

from ..bulk.refs import read_cloud
from ..engine.answer import answered, answered_prepared
from ..engine.cut import Label, Piece, cut_cloud, pieces
from ..engine.executors import AnyTeam
from ..engine.fit import prepared
from ..engine.names import base_name, plain
from ..engine.team import Outcome, Ready, chunks
from ..readers import Cloud, UnreadableFileError
from .identity import STDIN

if TYPE_CHECKING:
    from ..exports import Fitted

R = TypeVar("R")


@dataclass(frozen=True)
class Problem:
    """Why a file has no answer; `exit_status` is 2 for bad input, 1 where primfit itself failed.

    `no_cloud` says that it is not meant for a cloud.
    """

    name: str
    message: str
    exit_status: int = 2
    no_cloud: bool = False


Answer = tuple[Recognition, dict[str, Any]] | Problem
"""What was recognized and the body of `POST /fit`, or why there is none."""


def answer_file(
    name: str,
    options: Mapping[str, Any],
    how: Callable[[Cloud, Mapping[str, Any]], tuple[Recognition, dict[str, Any]]] = answered,
) -> Answer:
    """What was recognized in a file and the body of `POST /fit` for it, or what is wrong with it.

    `options` are those of `engine.fit` that were given beside the file; `how` answers for what was read.
    """
    try:
        return how(*_read(name, options, None))
    except Exception as error:  # one file must not cost the others their answers
        return _problem(name, error)


def fit_file(
    name: str, options: Mapping[str, Any], formats: Collection[str] = ()
) -> "tuple[Fitted, dict[str, Any]] | Problem":
    """What was recognized in a file and the body of `POST /fit` for it, or what is wrong with it.

    It is not fitted where the options leave out what one of the `formats` of exports needs.
    """
    from ..exports import Fitted, check_parts, check_unit

    try:
        cloud, used = _read(name, options, None)
        cloud = prepared(cloud, used)
        check_parts(formats, used.get("include", ANSWER_PARTS))
        check_unit(formats, cloud.unit)
        recognition, content = answered_prepared(cloud, used)
        return Fitted(recognition, cloud, used, file_name(name)), content
    except Exception as error:
        return _problem(name, error)


def file_name(name: str) -> str | None:
    """What a report calls a file, without its folders; standard input has no name."""
    return None if name == STDIN else base_name(name)


def _read(name: str, options: Mapping[str, Any], labels: str | None) -> tuple[Cloud, dict[str, Any]]:
    """The cloud in a file, and the options that hold for it."""
    data = sys.stdin.buffer.read() if name == STDIN else Path(name).read_bytes()
    return read_cloud(data, options, labels)


def _problem(name: str, error: Exception) -> Problem:
    match error:
        case IsADirectoryError():
            return Problem(name, "a folder; to fit the clouds in it: primfit batch FOLDER --out ANSWERS")
        case OSError():
            return Problem(name, error.strerror or str(error))
        case UnreadableFileError():
            return Problem(name, f"{error.field}: {error.message}", no_cloud=error.no_cloud)
        case InvalidPointCloudError() | InvalidOptionError():
            return Problem(name, str(error))
    return Problem(name, f"internal error, please report it: {error!r}", exit_status=1)


@dataclass(frozen=True)
class Source:
    """Where an answer comes from: the number (from 1) and name of a file, and the label of its segment.

    There is no label where the file has none, or cannot be cut.
    """

    number: int
    name: str
    label: Label | None = None

    @property
    def title(self) -> str:
        """The segment before people: `scan.csv#3`, or the file alone."""
        return self.name if self.label is None else f"{self.name}#{plain(str(self.label))}"


Keep = Callable[[Answer], R]
"""What the process that made an answer does with it."""


@dataclass(frozen=True)
class _FileJob(Generic[R]):
    """A file to be cut, and where the points of its segments go; `scratch` is None for one process alone."""

    name: str
    options: Mapping[str, Any]
    labels: str
    scratch: Path | None
    keep: Keep[R]


@dataclass(frozen=True)
class _CutFile:
    """The segments of a file by their labels: how each is had, their numbers of points, the options used."""

    labels: list[Label]
    pieces: list[Piece]
    sizes: list[int]
    options: Mapping[str, Any]


_SegmentJob = tuple[str, Piece, Mapping[str, Any], Keep[R]]
"""The title of a segment, how it is had, the options, and what is done with the answer."""


def answer_segments(
    names: Sequence[str],
    options: Mapping[str, Any],
    labels: str,
    team: AnyTeam,
    keep: Callable[[Source], Keep[R]],
) -> Iterator[tuple[Source, R]]:
    """What comes of the answers for the segments of many files: file by file, in each by label, ascending.

    Parameters
    ----------
    labels : the column of labels, or `AUTO_LABELS`
    team : who cuts the files and fits the segments; any number of processes gives the same answers
    keep : what is done with the answer for a source, by the process that made it
    """
    under_way: deque[tuple[Source, Path | None]] = deque()

    def outcomes() -> Iterator[Outcome[R]]:
        for number, (job, opened) in enumerate(_opened(names, options, labels, team, keep), 1):
            if not isinstance(opened, _CutFile):
                under_way.append((Source(number, job.name), None))
                yield Ready([opened])
                continue
            sources = [Source(number, job.name, label) for label in opened.labels]
            jobs: list[_SegmentJob[R]] = [
                (source.title, piece, opened.options, keep(source))
                for source, piece in zip(sources, opened.pieces, strict=True)
            ]
            under_way.extend((source, None) for source in sources[:-1])
            under_way.append((sources[-1], job.scratch))
            for share in chunks(jobs, opened.sizes, team.size):
                yield team.submit(_answer_segment, share)

    for result in team.in_order(outcomes()):
        source, done_with = under_way.popleft()
        yield source, result
        if done_with is not None:
            done_with.unlink(missing_ok=True)


def _opened(
    names: Sequence[str],
    options: Mapping[str, Any],
    labels: str,
    team: AnyTeam,
    keep: Callable[[Source], Keep[R]],
) -> Iterator[tuple[_FileJob[R], _CutFile | R]]:
    """Each file, cut; of one without labels, or that is bad, what comes of its answer."""
    jobs = [
        _FileJob(name, options, labels, team.scratch(), keep(Source(number, name)))
        for number, name in enumerate(names, 1)
    ]
    opened: Iterator[_CutFile | R] = team.in_order((team.submit(_open, [job]) for job in jobs), ahead=1)
    return zip(jobs, opened, strict=True)


def _open(job: _FileJob[R]) -> _CutFile | R:
    try:
        cloud, used = _read(job.name, job.options, job.labels)
        cut = cut_cloud(cloud)
        if cut is not None:
            sizes = [stop - start for start, stop in pairwise(cut.bounds)]
            return _CutFile(cut.labels, pieces(cut, job.scratch), sizes, used)
        answer: Answer = answered(cloud, used)
    except Exception as error:
        answer = _problem(job.name, error)
    return job.keep(answer)


def _answer_segment(job: _SegmentJob[R]) -> R:
    title, piece, options, keep = job
    try:
        answer: Answer = answered(piece(), options)
    except Exception as error:
        answer = _problem(title, error)
    return keep(answer)
