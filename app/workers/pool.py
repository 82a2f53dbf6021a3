"""Worker processes, each behind its own pipe: one may be killed or die without touching the others."""

import asyncio
import logging
import os
import pickle
import socket
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from contextlib import contextmanager
from typing import Any

from ..engine.team import process_context, starting
from ..wire.problems import BusyError, TimeLimitError, WorkerDiedError
from .pipe import TAKEN, Pipe, packed, read

_START_LIMIT = 120.0
_START_PAUSE = 2.0
_log = logging.getLogger("primfit")

Work = Callable[[Any], Any]
Abandoned = Callable[[], Awaitable[bool]]
Run = Callable[[Any, Abandoned], Awaitable[Any]]


def _serve(pipe: socket.socket, warm: Callable[[], Any], work: Work) -> None:
    """The life of a worker process: warm up, say so, then confirm and do jobs until the pipe closes."""
    import signal

    # A signal to the whole group is for the service, which lets us finish and then ends us.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(5)
    try:
        greeting = (True, warm())
    except Exception as error:
        greeting = (False, f"{type(error).__name__}: {error}")
    pipe.sendall(TAKEN + packed(greeting))
    while content := read(pipe):
        job = pickle.loads(content)
        pipe.sendall(TAKEN)
        pipe.sendall(packed(work(job)))


class _NotTakenError(WorkerDiedError):
    """The process ended before it had taken the job."""


class _Worker:
    """One process and our end of its pipe."""

    def __init__(self, context: Any, warm: Callable[[], Any], work: Work) -> None:
        self._context, self._warm, self._work = context, warm, work
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
        warm, greeting = await self._receive(self._pipe, _START_LIMIT)
        if not warm:
            self.kill()
            raise WorkerDiedError(f"a worker did not start: {greeting}")
        self.greeting = greeting
        self.n_starts += 1

    def _start_process(self) -> None:
        self._socket, theirs = socket.socketpair()
        process = self._context.Process(
            target=_serve, args=(theirs, self._warm, self._work), daemon=True, name="primfit-worker"
        )
        with theirs, starting():
            process.start()
        self._process = process
        if self._stopped:
            self.kill()

    async def call(self, job: Any, time_limit: float) -> Any:
        """Have a job done; if that fails, the process is gone afterwards."""
        try:
            return await self._done(job, time_limit)
        except _NotTakenError:
            # It ended while it was idle: the job is not to blame, and goes to a new process.
            return await self._done(job, time_limit)

    async def _done(self, job: Any, time_limit: float) -> Any:
        if not self.reachable:
            await self.start()
        assert self._pipe is not None
        self._pipe.send(job)
        return await self._receive(self._pipe, time_limit)

    async def _receive(self, pipe: Pipe, time_limit: float) -> Any:
        """The message of the process."""
        try:
            async with asyncio.timeout(time_limit):
                return await pipe.message()
        except TimeoutError:
            self.kill()
            raise TimeLimitError(
                f"not done after {time_limit:g} s, the limit of this service; the work was stopped"
            ) from None
        except ConnectionError as error:
            self.kill()
            if pipe.taken:
                raise WorkerDiedError("the worker process ended while it worked on this request") from error
            raise _NotTakenError("the worker process had ended") from error

    def kill(self) -> None:
        """End the process, where there is one, and close the pipe."""
        if self.alive:
            self._process.kill()
            self._process.join()
        if self._pipe is not None:
            self._pipe.abort()
        elif self._socket is not None:
            self._socket.close()
        self._process = self._socket = self._pipe = None

    def stop(self) -> None:
        """End the process, also one that is still being started."""
        self._stopped = True
        self.kill()


class WorkerPool:
    """A fixed number of warm workers; `run` hands a job to the next free one."""

    def __init__(
        self,
        size: int,
        warm: Callable[[], Any],
        work: Work,
        *,
        time_limit: float = 60.0,
        queue_size: int = 64,
        preload: list[str] | None = None,
    ) -> None:
        context = process_context(preload or [])
        self._workers = [_Worker(context, warm, work) for _ in range(size)]
        self._free: asyncio.Queue[_Worker] = asyncio.Queue()
        self._warm: set[_Worker] = set()
        self._tasks: set[asyncio.Task[Any]] = set()
        self._time_limit, self._queue_size = time_limit, queue_size
        self.n_waiting, self.n_busy, self._n_queued = 0, 0, 0
        self._turns, self._n_batches = asyncio.Semaphore(size), 0

    @property
    def size(self) -> int:
        """How many workers there are."""
        return len(self._workers)

    @property
    def n_warm(self) -> int:
        """Workers that have warmed up; one that ended while idle counts, since its next job restarts it."""
        return len(self._warm)

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

    async def run(self, job: Any, abandoned: Abandoned) -> Any:
        """Have a job done by the next free worker, unless it had to wait and was `abandoned` meanwhile.

        Raises `BusyError`, `TimeLimitError`, `WorkerDiedError`; returns None for an abandoned job.
        """
        if not self._free.empty() and not self._n_queued:
            return await self._do(self._free.get_nowait(), job)
        if self._free.empty() and self.n_waiting >= self._queue_size:
            raise BusyError(f"{self.n_waiting} requests are waiting, the limit of this service")
        self.n_waiting += 1
        try:
            worker = await self._next_free()
        finally:
            self.n_waiting -= 1
        return await self._unless_abandoned(worker, job, abandoned)

    @contextmanager
    def batch(self) -> Iterator[Run]:
        """`run` for the jobs of one batch, which take turns with everybody else's.

        A batch has as many jobs under way as there are workers, and so have all batches together, each in its
        turn; such a job then waits for a worker behind the requests that came before it. None is refused.

        Raises `BusyError` where as many batches are open as requests may wait.
        """
        if self._n_batches >= max(1, self._queue_size):
            raise BusyError(f"{self._n_batches} batches are open, the limit of this service")
        mine = asyncio.Semaphore(self.size)

        async def run(job: Any, abandoned: Abandoned) -> Any:
            async with mine, self._turns:
                return await self._unless_abandoned(await self._next_free(), job, abandoned)

        self._n_batches += 1
        try:
            yield run
        finally:
            self._n_batches -= 1

    async def _next_free(self) -> _Worker:
        self._n_queued += 1
        try:
            return await self._free.get()
        finally:
            self._n_queued -= 1

    async def _unless_abandoned(self, worker: _Worker, job: Any, abandoned: Abandoned) -> Any:
        given_up = True
        try:
            given_up = await abandoned()
        finally:  # also where this caller is cancelled meanwhile: no worker is lost
            if given_up:
                self._free.put_nowait(worker)
        if given_up:
            return None
        return await self._do(worker, job)

    async def _do(self, worker: _Worker, job: Any) -> Any:
        """Have the worker do it to the end, also where the caller is cancelled meanwhile."""
        return await asyncio.shield(self._spawn(self._call(worker, job)))

    async def _call(self, worker: _Worker, job: Any) -> Any:
        self.n_busy += 1
        try:
            return await worker.call(job, self._time_limit)
        finally:
            self.n_busy -= 1
            if worker.reachable:
                self._free.put_nowait(worker)
            else:
                self._spawn(self._revive(worker))

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
        self._free.put_nowait(worker)

    def _spawn(self, coroutine: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        task = asyncio.create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def stop(self) -> None:
        """End every worker, busy or not."""
        for task in self._tasks:
            task.cancel()
        for worker in self._workers:
            worker.stop()
