"""Processes that share the work on many clouds: chunks of it go out, results come back in its order.

A process is given a chunk when it has answered the last one, so that nothing piles up in its pipe.
What is sent is small: clouds stay in files that each process reads for itself.
"""

import multiprocessing
import os
import pickle
import signal
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from multiprocessing import forkserver
from multiprocessing.connection import wait
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Lock
from time import monotonic
from typing import Any, Generic, Protocol, Self, TypeVar

LARGEST = 8
"""Jobs of a chunk: at some milliseconds a fit, what a process is given at once takes some ten of them."""

HEAVIEST = 30_000
"""Points of a chunk of several jobs."""

AHEAD = 3
"""Chunks under way for each process, so that one that takes long does not keep the others waiting."""

PATIENCE = 1.0
"""Seconds that processes have for the chunk they are at when the work is broken off."""

ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")

# glibc: keep freed memory up to this, which spares each fit some hundred page faults.
KEEP_MEMORY = {"MALLOC_TRIM_THRESHOLD_": str(64 * 2**20), "MALLOC_MMAP_THRESHOLD_": str(16 * 2**20)}

_STARTING = Lock()

T = TypeVar("T")
R = TypeVar("R")
R_co = TypeVar("R_co", covariant=True)


class LostWorkerError(RuntimeError):
    """A process ended while it was at work."""


def chunks(jobs: Sequence[T], sizes: Sequence[int], workers: int) -> Iterator[Sequence[T]]:
    """Jobs in pieces that are worth sending: a few of them each, fewer where they are large or the last ones.

    `sizes` are their numbers of points.
    """
    start = 0
    while start < len(jobs):
        # Half of what is left, in equal shares: all processes end at about the same time.
        most = min(LARGEST, -(-(len(jobs) - start) // (2 * workers)))
        stop, points = start + 1, sizes[start]
        while stop < min(start + most, len(jobs)) and points + sizes[stop] <= HEAVIEST:
            points += sizes[stop]
            stop += 1
        yield jobs[start:stop]
        start = stop


class Outcome(Protocol[R_co]):
    """The results of a chunk, in the order of its jobs."""

    def results(self) -> Iterable[R_co]:
        """Waits for them; raises what a job raised, and `LostWorkerError`."""


class Ready(Generic[R]):
    """Results that need no process."""

    def __init__(self, results: Iterable[R]) -> None:
        self._results = results

    def results(self) -> Iterable[R]:
        return self._results


def in_order(outcomes: Iterable[Outcome[R]], most: Callable[[], int]) -> Iterator[R]:
    """The single results of chunks, of which up to `most()` are asked for ahead."""
    begun: deque[Outcome[R]] = deque()
    for outcome in outcomes:
        begun.append(outcome)
        while len(begun) > most():
            yield from begun.popleft().results()
    while begun:
        yield from begun.popleft().results()


class _Sent(Generic[R]):
    """A chunk that a process has, or will have."""

    def __init__(self, team: "Team", function: Callable[[Any], R], jobs: Sequence[Any]) -> None:
        self._team, self.message = team, (function, jobs)
        self.answer: tuple[list[R], None] | tuple[None, Exception] | None = None

    def results(self) -> list[R]:
        while self.answer is None:
            self._team.advance()
        results, error = self.answer
        if error is not None:
            raise error
        assert results is not None
        return results


class Team:
    """So many processes, alive within a `with`; a team of one is this process itself, and does what is asked
    when the result is wanted, unless it shall be `apart`.

    A process that ends at work costs the chunk that it is at, and another takes its place.

    Ctrl-C and other exceptions within the `with` end the processes, which finish the chunk that they are at
    if that takes no longer than `PATIENCE`.
    """

    here = True
    """Whether its processes are on this machine, and have its files."""

    def __init__(self, size: int, apart: bool = False) -> None:
        self.size = max(1, size)
        self._apart = apart or self.size > 1
        self._context: Any = None
        self._processes: dict[Any, Any] = {}
        self._free: list[Any] = []
        self._busy: dict[Any, _Sent[Any]] = {}
        self._queue: deque[_Sent[Any]] = deque()
        self._folder: TemporaryDirectory[str] | None = None
        self._n_files = 0

    def __enter__(self) -> Self:
        if self._apart:
            self._folder = TemporaryDirectory(prefix="primfit-", ignore_cleanup_errors=True)
            self._context = process_context(["primfit.app.engine.warmed"])
            with starting():
                self._free = [self._started() for _ in range(self.size)]
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self._end(list(self._processes))
        if self._folder is not None:
            self._folder.cleanup()

    def scratch(self) -> Path | None:
        """A new name for a file that goes when the team does; None where the team is this process."""
        if self._folder is None:
            return None
        self._n_files += 1
        return Path(self._folder.name) / str(self._n_files)

    def submit(self, function: Callable[[T], R], jobs: Sequence[T]) -> Outcome[R]:
        """Have a function applied to each of the jobs, by one process; it, they and results are pickled."""
        if not self._apart:
            return Ready(map(function, jobs))
        sent = _Sent(self, function, jobs)
        self._queue.append(sent)
        self._hand_out()
        return sent

    def in_order(self, outcomes: Iterable[Outcome[R]], ahead: int = AHEAD) -> Iterator[R]:
        """The single results of chunks, of which some are asked for ahead."""
        most = ahead * self.size if self._apart else 0
        return in_order(outcomes, lambda: most)

    def advance(self) -> None:
        """Wait until a process has answered, or ended, and give what waits to those that are free."""
        ready: list[Any] = wait(list(self._busy))
        for pipe in ready:
            sent = self._busy.pop(pipe)
            try:
                sent.answer = pipe.recv()
            except (EOFError, OSError):
                self._end([pipe])
                sent.answer = None, LostWorkerError("a process was ended from outside while it worked")
            else:
                self._free.append(pipe)
        self._hand_out()

    def _hand_out(self) -> None:
        while self._queue and len(self._busy) < self.size:
            sent = self._queue.popleft()
            pipe = self._given(sent.message)
            if pipe is None:
                sent.answer = None, LostWorkerError("processes are ended from outside before they work")
            else:
                self._busy[pipe] = sent

    def _given(self, message: Any) -> Any | None:
        """The pipe to the process that has the message now; None where even a new one does not take it."""
        while True:
            new = not self._free
            pipe = self._replaced() if new else self._free.pop()
            try:
                pipe.send(message)
            except OSError:  # it ended while it had nothing to do
                self._end([pipe])
                if new:
                    return None
            else:
                return pipe

    def _replaced(self) -> Any:
        with starting():
            return self._started()

    def _started(self) -> Any:
        """The pipe to a new process; called within `starting`."""
        ours, theirs = self._context.Pipe()
        process = self._context.Process(target=_serve, args=(theirs,), daemon=True)
        process.start()
        theirs.close()
        self._processes[ours] = process
        return ours

    def _end(self, pipes: Iterable[Any]) -> None:
        """Close these pipes, which ends the processes behind them."""
        processes = []
        for pipe in pipes:
            pipe.close()
            processes.append(self._processes.pop(pipe))
        end = monotonic() + PATIENCE
        for process in processes:
            process.join(max(0.0, end - monotonic()))
            process.kill()


def process_context(preload: list[str]) -> Any:
    """How processes are started: on Windows anew, else forked from a small server.

    The server begins at once to import `preload`, and this process goes on meanwhile.
    """
    if sys.platform == "win32":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(preload)
    with _one_thread(), _interrupts_ignored():
        forkserver.ensure_running()
    return context


@contextmanager
def starting() -> Iterator[None]:
    """For processes of the `process_context` that are started within.

    They compute on one thread, never see Ctrl-C, which a terminal sends to all of a group, and do not run the
    script that this process runs.
    """
    with ExitStack() as stack:
        stack.enter_context(_STARTING)
        stack.enter_context(_script_left_out())
        if sys.platform == "win32":
            stack.enter_context(_one_thread())
            stack.enter_context(_interrupts_ignored())
        yield


@contextmanager
def _script_left_out() -> Iterator[None]:
    """Nothing to run that a process finds where it looks for the script of the one that started it."""
    main = sys.modules["__main__"]
    script = {name: getattr(main, name) for name in ("__spec__", "__file__") if hasattr(main, name)}
    for name in script:
        setattr(main, name, None)
    try:
        yield
    finally:
        for name, value in script.items():
            setattr(main, name, value)


@contextmanager
def _one_thread() -> Iterator[None]:
    before = {name: os.environ.get(name) for name in (*KEEP_MEMORY, *ONE_THREAD)}
    os.environ.update(KEEP_MEMORY | os.environ | dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    try:
        before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    except ValueError:  # in a thread: processes ignore it once they run
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _serve(pipe: Any) -> None:
    """The life of a process: chunks come and go until the other end of the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        while True:
            pipe.send(done(pipe.recv_bytes()))
    except (EOFError, OSError):
        return


def done(message: bytes) -> tuple[list[Any], None] | tuple[None, Exception]:
    """The results of a chunk, or what one of its jobs raised."""
    try:
        function, jobs = pickle.loads(message)
        return [function(job) for job in jobs], None
    except Exception as error:
        return None, error
