"""The answer for a file on disk or on standard input: what the command line asks of the engine."""

import signal
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError

from ..engine.answer import answered
from ..engine.items import Item
from ..engine.names import Ids, base_name, plain
from ..engine.segments import cut_cloud
from ..exports import Fitted
from ..readers import Cloud, UnreadableFileError, read

STDIN = "-"
_AHEAD = 4
_T = TypeVar("_T")
_R = TypeVar("_R")


@dataclass(frozen=True)
class Problem:
    """Why a file has no answer; `exit_status` is 2 for bad input, 1 where primfit itself failed."""

    name: str
    message: str
    exit_status: int = 2


def answer_file(name: str, options: Mapping[str, Any]) -> dict[str, Any] | Problem:
    """The body of `POST /fit` for a file, or what is wrong with it.

    `options` are those of `engine.fit` that were given beside the file.
    """
    found = fit_file(name, options)
    return found if isinstance(found, Problem) else found[1]


def fit_file(name: str, options: Mapping[str, Any]) -> tuple[Fitted, dict[str, Any]] | Problem:
    """What was recognised in a file and the body of `POST /fit` for it, or what is wrong with it."""
    try:
        cloud, used = _read(name, options, None)
        recognition, content = answered(cloud, used)
        return Fitted(recognition, cloud, used), content
    except Exception as error:  # one file must not cost the others their answers
        return _problem(name, error)


def _read(name: str, options: Mapping[str, Any], labels: str | None) -> tuple[Cloud, dict[str, Any]]:
    """The cloud in a file, and the options that hold for it."""
    data = sys.stdin.buffer.read() if name == STDIN else Path(name).read_bytes()
    cloud = read(data, labels=labels)
    return cloud, _with_options_of(cloud, options)


def _problem(name: str, error: Exception) -> Problem:
    match error:
        case OSError():
            return Problem(name, error.strerror or str(error))
        case UnreadableFileError():
            return Problem(name, f"{error.field}: {error.message}")
        case InvalidPointCloudError() | InvalidOptionError():
            return Problem(name, str(error))
    return Problem(name, f"internal error, please report it: {error!r}", exit_status=1)


def _with_options_of(cloud: Cloud, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options given, and those in the file: JSON may hold some, as the body of `POST /fit` does."""
    if not cloud.options:
        return dict(given)
    # Imported here, because few files hold options and the check brings half of the service along.
    from ..wire.options import check_options
    from ..wire.problems import InvalidOptionsError

    try:
        return check_options((), given, cloud.options)
    except InvalidOptionsError as error:
        bad = error.errors[0]
        raise UnreadableFileError(bad.field, bad.message) from None


def answer_files(
    names: Sequence[str], options: Mapping[str, Any], workers: int
) -> Iterator[dict[str, Any] | Problem]:
    """The answers of many files, in their order; how many processes share the work changes nothing else."""
    return _each(partial(answer_file, options=dict(options)), names, min(workers, len(names)))


@dataclass(frozen=True)
class Source:
    """Where a segment comes from: its item, and the number (from 1) and name of its file."""

    item: Item
    number: int
    name: str

    @property
    def title(self) -> str:
        """The segment before people: `scan.csv#3`, or the file alone where it has no labels."""
        return self.name if self.item.label is None else f"{self.name}#{plain(str(self.item.label))}"


def answer_segments(
    names: Sequence[str], options: Mapping[str, Any], labels: str, workers: int
) -> Iterator[tuple[Source, dict[str, Any] | Problem]]:
    """The answers for the segments of many files: file by file, and in each by its label, ascending.

    `labels` is the column of labels, or `AUTO_LABELS`. A file is cut here, and its segments are fitted by the
    processes: any number of them gives the same answers.
    """
    return _each(_answer_segment, _segments(names, options, labels), workers)


_Job = tuple[Source, Cloud | Problem, Mapping[str, Any]]


def _segments(names: Sequence[str], options: Mapping[str, Any], labels: str) -> Iterator[_Job]:
    ids = Ids()
    for number, name in enumerate(names, 1):
        file = None if name == STDIN else base_name(name)
        whole = Source(Item.of_file(file, number, ids), number, name)
        try:
            cloud, used = _read(name, options, labels)
            cut = cut_cloud(cloud)
        except Exception as error:
            yield whole, _problem(name, error), {}
            continue
        if cut is None:
            yield whole, cloud, used
            continue
        for label, _, segment in cut:
            yield replace(whole, item=whole.item.segment(label, ids)), segment, used


def _answer_segment(job: _Job) -> tuple[Source, dict[str, Any] | Problem]:
    source, cloud, options = job
    if isinstance(cloud, Problem):
        return source, cloud
    try:
        return source, answered(cloud, options)[1]
    except Exception as error:
        return source, _problem(source.title, error)


def _each(function: Callable[[_T], _R], jobs: Iterable[_T], workers: int) -> Iterator[_R]:
    """What a function makes of each job, in their order; a few jobs more than there are processes wait."""
    if workers <= 1:
        yield from map(function, jobs)
        return
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        with _interrupts_ignored():
            pool.submit(abs, 0)  # starts the processes
        waiting: deque[Future[_R]] = deque()
        try:
            for job in jobs:
                waiting.append(pool.submit(function, job))
                if len(waiting) > _AHEAD * workers:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes started here never see Ctrl-C, which a terminal sends to all: this process stops them."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
