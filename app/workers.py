"""Worker processes, each behind its own pipe: one may be killed or die without touching the others."""

import asyncio
import logging
import multiprocessing
import os
import sys
from collections.abc import Awaitable, Callable, Coroutine, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any

from app.problems import BusyError, TimeLimitError, WorkerDiedError

_START_LIMIT = 120.0
_START_PAUSE = 2.0
_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
_log = logging.getLogger("primfit")

Work = Callable[[Any], Any]
Abandoned = Callable[[], Awaitable[bool]]
Run = Callable[[Any, Abandoned], Awaitable[Any]]


def _context(preload: list[str]) -> Any:
    """Processes are forked from a small server that has imported everything, or spawned without one."""
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    if sys.platform == "win32":
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(preload)
    return context


def _serve(connection: Connection, warm: Callable[[], Any], work: Work) -> None:
    """The life of a worker process: warm up, say so, then confirm and do jobs until the pipe closes."""
    import signal

    # A signal to the whole group is for the service, which lets us finish and then ends us.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(5)
    try:
        connection.send((True, warm()))
    except Exception as error:
        connection.send((False, f"{type(error).__name__}: {error}"))
        return
    while True:
        try:
            job = connection.recv()
        except EOFError:
            return
        connection.send(None)
        connection.send(work(job))


class _Worker:
    """One process and our end of its pipe."""

    def __init__(self, context: Any, warm: Callable[[], Any], work: Work) -> None:
        self._context, self._warm, self._work = context, warm, work
        self._process: Any = None
        self._connection: Any = None
        self._stopped = False
        self.n_starts = 0
        self.greeting: Any = None

    @property
    def alive(self) -> bool:
        process = self._process
        return process is not None and process.is_alive()

    def start(self) -> None:
        self._connection, theirs = self._context.Pipe()
        process = self._context.Process(
            target=_serve, args=(theirs, self._warm, self._work), daemon=True, name="primfit-worker"
        )
        process.start()
        self._process = process
        theirs.close()
        if self._stopped:
            self.kill()
            raise WorkerDiedError("the service is stopping")
        warm, greeting = self._receive(_START_LIMIT)
        if not warm:
            self.kill()
            raise WorkerDiedError(f"a worker did not start: {greeting}")
        self.greeting = greeting
        self.n_starts += 1

    def call(self, job: Any, time_limit: float) -> Any:
        """Have a job done; if that fails, the process is gone afterwards."""
        try:
            self._begin(job, time_limit)
        except WorkerDiedError:
            # It ended while it was idle: the job is not to blame, and goes to a new process.
            self._begin(job, time_limit)
        return self._receive(time_limit)

    def _begin(self, job: Any, time_limit: float) -> None:
        """Hand a job over and wait until the process says that it has it."""
        if not self.alive:
            self.start()
        try:
            self._connection.send(job)
        except OSError as error:
            self.kill()
            raise WorkerDiedError("the worker process had ended") from error
        self._receive(time_limit)

    def _receive(self, time_limit: float) -> Any:
        try:
            if self._connection.poll(time_limit):
                return self._connection.recv()
        except (EOFError, OSError) as error:
            self.kill()
            raise WorkerDiedError("the worker process ended while it worked on this request") from error
        self.kill()
        raise TimeLimitError(
            f"not done after {time_limit:g} s, the limit of this service; the work was stopped"
        )

    def kill(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._connection.close()
            self._process = None

    def stop(self) -> None:
        """End the process from another thread than the one that may be waiting for it."""
        self._stopped = True
        if (process := self._process) is not None:
            process.kill()
            process.join()


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
        context = _context(preload or [])
        self._workers = [_Worker(context, warm, work) for _ in range(size)]
        self._threads = ThreadPoolExecutor(size, thread_name_prefix="primfit-pipe")
        self._free: asyncio.Queue[_Worker] = asyncio.Queue()
        self._warm: set[_Worker] = set()
        self._tasks: set[asyncio.Task[Any]] = set()
        self._time_limit, self._queue_size = time_limit, queue_size
        self.n_waiting, self.n_busy = 0, 0
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
        """Have a job done by the next free worker, unless it is `abandoned` when its turn comes.

        Raises `BusyError`, `TimeLimitError`, `WorkerDiedError`; returns None for an abandoned job.
        """
        if self._free.empty() and self.n_waiting >= self._queue_size:
            raise BusyError(f"{self.n_waiting} requests are waiting, the limit of this service")
        self.n_waiting += 1
        try:
            worker = await self._free.get()
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
                return await self._unless_abandoned(await self._free.get(), job, abandoned)

        self._n_batches += 1
        try:
            yield run
        finally:
            self._n_batches -= 1

    async def _unless_abandoned(self, worker: _Worker, job: Any, abandoned: Abandoned) -> Any:
        given_up = True
        try:
            given_up = await abandoned()
        finally:  # also where this caller is cancelled meanwhile: no worker is lost
            if given_up:
                self._free.put_nowait(worker)
        if given_up:
            return None
        return await asyncio.shield(self._spawn(self._call(worker, job)))

    async def _call(self, worker: _Worker, job: Any) -> Any:
        self.n_busy += 1
        try:
            return await self._in_thread(worker.call, job, self._time_limit)
        finally:
            self.n_busy -= 1
            if worker.alive:
                self._free.put_nowait(worker)
            else:
                self._spawn(self._revive(worker))

    async def _revive(self, worker: _Worker) -> None:
        """Start a worker, and try again for as long as it does not come up."""
        self._warm.discard(worker)
        while not worker.alive:
            try:
                await self._in_thread(worker.start)
            except Exception as error:
                _log.error("%s; trying again", error)
                await asyncio.sleep(_START_PAUSE)
        self._warm.add(worker)
        self._free.put_nowait(worker)

    def _in_thread(self, function: Callable[..., Any], *args: Any) -> asyncio.Future[Any]:
        return asyncio.get_running_loop().run_in_executor(self._threads, function, *args)

    def _spawn(self, coroutine: Coroutine[Any, Any, Any]) -> asyncio.Task[Any]:
        task = asyncio.create_task(coroutine)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)
        return task

    def stop(self) -> None:
        """End every worker, busy or not."""
        for task in self._tasks:
            task.cancel()
        self._threads.shutdown(wait=False, cancel_futures=True)
        for worker in self._workers:
            worker.stop()
