"""Workers on a Ray cluster: each job is a task there, done by a process that is like a worker of the service.

Ray ends a process whose cluster is lost. So it runs in one apart, the driver, and what is under way there is
lost at most.
"""

import asyncio
import os
import pickle
import signal
import socket
from asyncio import StreamReader, StreamWriter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import version
from typing import Any

from ..engine.ray_team import ClusterError, RayTeam
from ..engine.team import LostWorkerError, process_context, starting
from ..wire.problems import WorkerDiedError
from . import PRELOAD, jobs
from .line import Abandoned
from .pool import Run, WorkerPool

LEAST, MOST = 16, 128
"""Jobs of a batch that are worth having under way, for each worker that a service would have: a small
cluster that may grow does so when tasks wait; each has a temporary file."""

TRIES = 5
"""Processes that may be lost over a job: it is a machine mostly, and none of these is to blame."""

WARM_WITHIN = 120.0
"""Seconds that a process of the cluster has to load the weights."""

_LENGTH = 8


class ClusterLostError(ConnectionError):
    """There is no cluster now, or it does not do the work; the message says why."""


@dataclass(frozen=True)
class Terms:
    """What a process of the cluster goes by."""

    log_format: str
    worker_memory: int
    time_limit: float
    version: str = version("primfit")


class Cluster:
    """What a `WorkerPool` is for batches, on the cluster at an address; see `RayTeam`."""

    def __init__(self, address: str | None, terms: Terms) -> None:
        self._address, self._terms = address, terms
        self._driver: _Driver | None = None
        self._joining = asyncio.Lock()

    async def size(self) -> int:
        """As how many workers it counts now; raises `ClusterLostError`."""
        return min(MOST, max(LEAST, (await self._joined()).processors))

    @contextmanager
    def batch(self) -> Iterator[Run]:
        """`run` for the jobs of one batch.

        It raises `ClusterLostError`, upon which a batch may go on later, and what `WorkerPool.batch` has.
        """
        yield self._run

    async def _run(self, job: Any, abandoned: Abandoned, *, heavy: bool = False) -> Any:
        for _ in range(TRIES):
            try:
                return await (await self._joined()).done(job)
            except LostWorkerError:
                continue
        raise WorkerDiedError(f"{TRIES} processes of the cluster were lost while they worked on this")

    async def _joined(self) -> "_Driver":
        async with self._joining:
            if self._driver is None or self._driver.lost is not None:
                self._driver = await _Driver.start(self._address, self._terms)
            return self._driver

    def stop(self) -> None:
        """Leave the cluster, which ends what is under way there."""
        if self._driver is not None:
            self._driver.stop()


class _Driver:
    """The process that Ray runs in, and what it was asked."""

    def __init__(self, process: Any, reader: StreamReader, writer: StreamWriter, processors: int) -> None:
        self._process, self._reader, self._writer = process, reader, writer
        self.processors = processors
        self.lost: ClusterLostError | None = None
        self._asked: dict[int, asyncio.Future[Any]] = {}
        self._n_asked = 0
        self._listener = asyncio.create_task(self._listen())

    @classmethod
    async def start(cls, address: str | None, terms: Terms) -> "_Driver":
        """One that has joined the cluster; raises `ClusterLostError`."""
        ours, theirs = socket.socketpair()
        process = await asyncio.to_thread(_started, theirs, address, terms)
        reader, writer = await asyncio.open_connection(sock=ours)
        try:
            processors, refusal = await _receive(reader)
        except (EOFError, OSError):
            processors, refusal = 0, "Ray ended its process when it joined the cluster"
        except asyncio.CancelledError:
            writer.close()
            raise
        if refusal is not None:
            writer.close()
            raise ClusterLostError(refusal)
        return cls(process, reader, writer, processors)

    async def done(self, job: Any) -> Any:
        """What a job results in; where nobody waits for it any more, the process that is at it ends."""
        if self.lost is not None:
            raise self.lost
        self._n_asked += 1
        number = self._n_asked
        self._asked[number] = future = asyncio.get_running_loop().create_future()
        _send(self._writer, (number, job))
        try:
            return await future
        except asyncio.CancelledError:
            if self.lost is None:
                _send(self._writer, (number, None))
            raise
        finally:
            self._asked.pop(number, None)

    async def _listen(self) -> None:
        with suppress(EOFError, OSError):
            while True:
                number, result, error, self.processors = await _receive(self._reader)
                future = self._asked.get(number)
                if future is not None and not future.done():
                    if error is None:
                        future.set_result(result)
                    else:
                        future.set_exception(error)
        self.lost = ClusterLostError("the cluster is lost: Ray has ended its process")
        self._writer.close()
        for future in self._asked.values():
            if not future.done():
                future.set_exception(self.lost)

    def stop(self) -> None:
        self._listener.cancel()
        self._writer.close()


def _started(theirs: socket.socket, address: str | None, terms: Terms) -> Any:
    context = process_context(PRELOAD)
    process = context.Process(target=_drive, args=(theirs, address, terms), daemon=True, name="primfit-ray")
    with theirs, starting():
        process.start()
    return process


def _send(writer: StreamWriter, message: Any) -> None:
    content = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    writer.write(len(content).to_bytes(_LENGTH, "big") + content)


async def _receive(reader: StreamReader) -> Any:
    """The next message; raises `EOFError` where there is none any more."""
    n_bytes = int.from_bytes(await reader.readexactly(_LENGTH), "big")
    return pickle.loads(await reader.readexactly(n_bytes))


def _drive(pipe: socket.socket, address: str | None, terms: Terms) -> None:
    """The life of the driver: it joins the cluster, and asks it, until the service closes the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    asyncio.run(_joined(pipe, address, terms))


async def _joined(pipe: socket.socket, address: str | None, terms: Terms) -> None:
    reader, writer = await asyncio.open_connection(sock=pipe)
    try:
        # Where there is none at all, Ray would start one, of this machine alone.
        with RayTeam(None, address or os.environ.get("RAY_ADDRESS", "auto"), warm=False) as team:
            _send(writer, (team.size, None))
            with suppress(EOFError, OSError):
                await _ask(team, terms, reader, writer)
    except (ClusterError, ImportError) as error:
        _send(writer, (0, str(error)))
        await writer.drain()
    os._exit(0)  # Ray has threads that would be waited for


async def _ask(team: RayTeam, terms: Terms, reader: StreamReader, writer: StreamWriter) -> None:
    """Pass on what the service asks, and what comes of it, until there is no service."""
    asked: dict[int, asyncio.Task[None]] = {}

    async def answer(number: int, job: Any) -> None:
        result: Any = None
        problem: Exception | None = None
        try:
            [result] = await team.awaited(team.submit(partial(do, terms), [job]))
        except ClusterError as error:
            problem = ClusterLostError(str(error))
        except Exception as error:
            problem = error
        finally:
            asked.pop(number, None)
        _send(writer, (number, result, problem, team.size))

    while True:
        number, job = await _receive(reader)
        if job is not None:
            asked[number] = asyncio.create_task(answer(number, job))
        elif number in asked:
            asked[number].cancel()


def do(terms: Terms, job: Any) -> Any:
    """Do a job of a service in a process of the cluster, with the limits that its own workers have.

    Raises
    ------
    ClusterLostError
        This machine cannot.
    WorkerDiedError, TimeLimitError
        As in a service.
    """
    if terms.version != version("primfit"):
        raise ClusterLostError(
            f"a machine of the cluster has primfit {version('primfit')}, the service {terms.version}"
        )
    return _hand(terms).do(job)


class _Hand:
    """A worker beside a process of the cluster, which may kill it."""

    def __init__(self, terms: Terms) -> None:
        warm = partial(jobs.warm, terms.log_format, terms.worker_memory)
        self._pool = WorkerPool(1, warm, jobs.run, time_limit=terms.time_limit, preload=PRELOAD)
        self._loop = asyncio.new_event_loop()
        self._loop.run_until_complete(self._start())

    async def _start(self) -> None:
        self._pool.start()

    def do(self, job: Any) -> Any:
        return self._loop.run_until_complete(self._do(job))

    async def _do(self, job: Any) -> Any:
        try:
            async with asyncio.timeout(WARM_WITHIN):
                while not self._pool.n_warm:
                    await asyncio.sleep(0.01)
        except TimeoutError:
            raise ClusterLostError("a machine of the cluster does not get the weights loaded") from None
        with self._pool.batch() as run:
            return await run(job, _never)


_hand = cache(_Hand)


async def _never() -> bool:
    return False
