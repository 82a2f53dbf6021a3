"""Worker processes, each behind its own pipe: one may be killed or die without touching the others."""

import asyncio
import logging
import math
import socket
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from ..engine.team import process_context, starting
from ..wire.problems import BusyError, TimeLimitError, WorkerDiedError
from .line import LOOK, Abandoned, Line, Turn
from .pipe import Pipe
from .worker import Work, serve

SMALL, LARGE, BATCHES, LARGE_ITEMS = "small", "large", "batches", "large items"
"""The lanes: requests with small and with large clouds, and the small and large items of all batches."""

_START_LIMIT = 120.0
_START_PAUSE = 2.0
_GRACE = 0.5
"""Seconds in which a job that nobody waits for any more may end by itself, which costs no new process."""
_OFF = 2.0
"""How far off what is expected of the line may be: who waits for nothing in the end is refused late."""
_log = logging.getLogger("primfit")


class Run(Protocol):
    """Have a job done; None where it was abandoned."""

    async def __call__(self, job: Any, abandoned: Abandoned, *, heavy: bool = False) -> Any: ...


class _NotTakenError(WorkerDiedError):
    """The process ended before it had taken the job."""


class _Worker:
    """One process and our end of its pipe."""

    def __init__(self, context: Any, warm: Callable[[], Any], work: Work, litter: Path | None) -> None:
        self._context, self._life = context, (warm, work, litter)
        self._process: Any = None
        self._socket: socket.socket | None = None
        self._pipe: Pipe | None = None
        self._stopped = False
        self.n_starts = 0
        self.greeting: Any = None

    @property
    def alive(self) -> bool:
        process = self._process
        return process is not None and process.is_alive()

    @property
    def reachable(self) -> bool:
        """Whether its end of the pipe is open: it ends with the process, and this asks no system call."""
        return self._pipe is not None and not self._pipe.closed

    async def start(self) -> None:
        self.kill()
        # The first process of all waits until the server that it is forked from has imported everything.
        await asyncio.to_thread(self._start_process)
        loop = asyncio.get_running_loop()
        _, self._pipe = await loop.create_connection(Pipe, sock=self._socket)
        try:
            warm, greeting = await self._receive(self._pipe, loop.time() + _START_LIMIT)
        except TimeoutError:
            warm, greeting = False, f"not warm after {_START_LIMIT:g} s"
        if not warm:
            self.kill()
            raise WorkerDiedError(f"a worker did not start: {greeting}")
        self.greeting = greeting
        self.n_starts += 1

    def _start_process(self) -> None:
        self._socket, theirs = socket.socketpair()
        process = self._context.Process(
            target=serve, args=(theirs, *self._life), daemon=True, name="primfit-worker"
        )
        with theirs, starting():
            process.start()
        self._process = process
        if self._stopped:
            self.kill()

    def hand_over(self, job: Any) -> bool:
        """Send it a job; false where it cannot be reached."""
        if self._pipe is None or self._pipe.closed:
            return False
        self._pipe.send(job)
        return True

    async def call(self, job: Any, end: float, handed_over: bool) -> Any:
        """Have a job done until `end`, in the time of the event loop; if that fails, the process is gone."""
        try:
            return await self._done(job, end, handed_over)
        except _NotTakenError:
            # It ended while it was idle: the job is not to blame, and goes to a new process.
            return await self._done(job, end, False)

    async def _done(self, job: Any, end: float, handed_over: bool) -> Any:
        if not handed_over and not self.hand_over(job):
            await self.start()
            self.hand_over(job)
        assert self._pipe is not None
        return await self._receive(self._pipe, end)

    async def _receive(self, pipe: Pipe, end: float) -> Any:
        """The message of the process."""
        try:
            async with asyncio.timeout_at(end):
                return await pipe.message()
        except (TimeoutError, asyncio.CancelledError):
            self.kill()
            raise
        except ConnectionError as error:
            self.kill()
            if pipe.taken:
                raise WorkerDiedError("the worker process ended while it worked on this request") from error
            raise _NotTakenError("the worker process had ended") from error

    def kill(self) -> None:
        """End the process, where there is one, and then close the pipe: it tells by this which of us died."""
        if self.alive:
            self._process.kill()
        if self._pipe is not None:
            self._pipe.abort()
        elif self._socket is not None:
            self._socket.close()
        self._process = self._socket = self._pipe = None

    def stop(self) -> None:
        """End the process, also one that is still being started."""
        self._stopped = True
        process = self._process
        self.kill()
        if process is not None:
            process.join()


class WorkerPool:
    """A fixed number of warm workers, and the line of jobs in front of them."""

    def __init__(
        self,
        size: int,
        warm: Callable[[], Any],
        work: Work,
        *,
        time_limit: float = 60.0,
        queue_size: int = 64,
        preload: list[str] | None = None,
        litter: Path | None = None,
    ) -> None:
        context = process_context(preload or [])
        self._workers = [_Worker(context, warm, work, litter) for _ in range(size)]
        self._line: Line[_Worker] = Line((SMALL, LARGE, BATCHES, LARGE_ITEMS), size)
        self._warm: set[_Worker] = set()
        self._tasks: set[asyncio.Task[Any]] = set()
        self._stopped = False
        self._time_limit, self._queue_size = time_limit, queue_size
        self.n_busy = 0
        # Large items that may not begin must not hold up the small ones.
        self._turns = {heavy: asyncio.Semaphore(max(1, size - heavy)) for heavy in (False, True)}
        self._n_batches, self._n_items = 0, 0

    @property
    def size(self) -> int:
        """How many workers there are."""
        return len(self._workers)

    @property
    def n_warm(self) -> int:
        """Workers that have warmed up; one that ended while idle counts, since its next job restarts it."""
        return len(self._warm)

    @property
    def n_waiting(self) -> dict[str, int]:
        """How many jobs wait for a worker, by their lane."""
        return {name: self._line.n_waiting(name) for name in (SMALL, LARGE)} | {BATCHES: self._n_items}

    @property
    def n_restarts(self) -> int:
        """Workers that came up in place of one that had ended."""
        return sum(max(0, worker.n_starts - 1) for worker in self._workers)

    @property
    def greeting(self) -> Any:
        """What `warm` returned in the first worker, None before that."""
        return self._workers[0].greeting

    def start(self) -> None:
        """Begin to warm the workers up; `n_warm` counts those that are."""
        for worker in self._workers:
            self._spawn(self._revive(worker))

    def check_room(self, large: bool, patience: float | None = None) -> None:
        """Raise `BusyError` where a request would be refused now: ask before its body is received."""
        if self._line.has_room(large):
            return
        lane = LARGE if large else SMALL
        n_waiting, wait = self._line.n_waiting(lane), self._line.seconds_to_wait(lane)
        work = self._line.seconds_of_work(lane)
        if n_waiting >= self._queue_size:
            raise _busy(
                f"{n_waiting} requests with {lane} clouds are waiting, the limit of this service", wait
            )
        if _OFF * wait + work > (patience := self._patience(patience)):
            late = f"too late for an answer within {patience:g} s"
            raise _busy(f"its turn would come in about {wait:.2g} s, {late}", wait)

    async def run(
        self, job: Any, abandoned: Abandoned, *, large: bool = False, patience: float | None = None
    ) -> Any:
        """Have a job of a request done when its turn has come; returns None where it was abandoned.

        Parameters
        ----------
        abandoned : whether the client has left, which is asked again and again: what is begun ends then
        large : for its own lane, so that it does not hold up small ones
        patience : seconds that waiting and work may take, at most the time limit

        Raises
        ------
        BusyError
            Too many wait already, or its turn did not come in time.
        TimeLimitError, WorkerDiedError
            It was begun, but not finished.
        """
        self.check_room(large, patience)
        patience = self._patience(patience)
        end = asyncio.get_running_loop().time() + patience
        lane = LARGE if large else SMALL
        # Work that is begun so late that it will be cut off is lost, and a worker with it.
        begun_by = end - min(self._line.seconds_of_work(lane), patience / _OFF)
        try:
            turn = await self._line.turn(lane, large, begun_by, abandoned)
        except TimeoutError:
            wait = self._line.seconds_to_wait(lane)
            raise _busy(f"no worker was free within {patience:g} s; it was not begun", wait) from None
        return None if turn is None else await self._do(turn, job, end, patience, abandoned)

    def check_batch(self) -> None:
        """Raise `BusyError` where no batch could be opened now."""
        if self._n_batches >= max(1, self._queue_size):
            wait = self._line.seconds_to_wait(BATCHES)
            raise _busy(f"{self._n_batches} batches are open, the limit of this service", wait)

    @contextmanager
    def batch(self) -> Iterator[Run]:
        """`run` for the jobs of one batch, which take turns with everybody else's.

        A batch has as many jobs under way as there are workers, and so have all batches together, each in its
        turn; they have a lane of their own beside the requests. None is refused, and each has the time limit
        from when it is begun.

        Raises `BusyError` where as many batches are open as requests may wait.
        """
        self.check_batch()
        mine = asyncio.Semaphore(self.size)

        async def run(job: Any, abandoned: Abandoned, *, heavy: bool = False) -> Any:
            with self._counted() as begun:
                async with mine, self._turns[heavy]:
                    lane = LARGE_ITEMS if heavy else BATCHES
                    turn = await self._line.turn(lane, heavy, None, abandoned)
                    begun()
                    if turn is None:
                        return None
                    end = asyncio.get_running_loop().time() + self._time_limit
                    return await self._do(turn, job, end, self._time_limit, abandoned)

        self._n_batches += 1
        try:
            yield run
        finally:
            self._n_batches -= 1

    @contextmanager
    def _counted(self) -> Iterator[Callable[[], None]]:
        """Count an item of a batch among those that wait until it is begun, or given up."""
        waits = 1
        self._n_items += waits

        def begun() -> None:
            nonlocal waits
            self._n_items -= waits
            waits = 0

        try:
            yield begun
        finally:
            begun()

    async def _do(
        self, turn: Turn[_Worker], job: Any, end: float, patience: float, abandoned: Abandoned
    ) -> Any:
        """Have the worker do it, and end the work a moment after nobody waits for it any more."""
        worker = turn.worker
        assert worker is not None
        try:
            # The process is idle until then, and a task begins a turn of the event loop later.
            handed_over = worker.hand_over(job)
        except BaseException:
            self._line.withdraw(turn)
            raise
        call = self._spawn(self._call(turn, worker, job, end, handed_over))
        try:
            while not call.done():
                await asyncio.wait((call,), timeout=LOOK)
                if not call.done() and await abandoned():
                    self._give_up(call)
                    return None
        except asyncio.CancelledError:
            self._give_up(call)
            raise
        try:
            return call.result()
        except TimeoutError:
            raise TimeLimitError(f"not done within {patience:g} s; the work was stopped") from None

    def _give_up(self, call: asyncio.Task[Any]) -> None:
        call.add_done_callback(_look_at)
        asyncio.get_running_loop().call_later(_GRACE, call.cancel)

    async def _call(
        self, turn: Turn[_Worker], worker: _Worker, job: Any, end: float, handed_over: bool
    ) -> Any:
        loop = asyncio.get_running_loop()
        began, finished = loop.time(), False
        self.n_busy += 1
        try:
            result = await worker.call(job, end, handed_over)
            finished = True
            return result
        finally:
            self.n_busy -= 1
            self._line.done(turn, loop.time() - began, finished)
            if worker.reachable:
                self._line.free(worker)
            elif not self._stopped:
                self._spawn(self._revive(worker))

    def _patience(self, patience: float | None) -> float:
        return self._time_limit if patience is None else min(patience, self._time_limit)

    async def _revive(self, worker: _Worker) -> None:
        """Start a worker, and try again for as long as it does not come up."""
        self._warm.discard(worker)
        while not worker.alive:
            try:
                await worker.start()
            except Exception as error:
                _log.error("%s; trying again", error)
                await asyncio.sleep(_START_PAUSE)
        self._warm.add(worker)
        self._line.free(worker)

    def _spawn(self, coroutine: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        task = asyncio.create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def stop(self) -> None:
        """End every worker, busy or not."""
        self._stopped = True
        for task in self._tasks:
            task.cancel()
        for worker in self._workers:
            worker.stop()


def _busy(message: str, seconds: float) -> BusyError:
    """The refusal of a job, which may be sent again when the line has moved on."""
    return BusyError(message, {"Retry-After": str(max(1, math.ceil(seconds)))})


def _look_at(task: asyncio.Task[Any]) -> None:
    """Look at what came of it, so that nobody is told when the task is thrown away."""
    if not task.cancelled():
        task.exception()
