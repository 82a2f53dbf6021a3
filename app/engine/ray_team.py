"""Processes of a Ray cluster that share the work on many clouds: the same as `Team`, on many machines."""

import asyncio
import os
import pickle
import socket
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from time import monotonic
from typing import Any, Generic, Self, TypeVar

from .team import AHEAD, KEEP_MEMORY, ONE_THREAD, LostWorkerError, Outcome, done, in_order

ASKED_EVERY = 5.0
"""Seconds after which the number of processors is asked for again: clusters grow and shrink."""

ANSWERS_WITHIN = 10.0
"""Seconds in which a cluster answers that is there."""

NAMES = {"RAY_USAGE_STATS_ENABLED": "0", "RAY_ACCEL_ENV_VAR_OVERRIDE_ON_ZERO": "0"}
"""What Ray is told unless the environment says otherwise: to report nothing of its use to its makers, and to
leave alone what makes graphics cards visible."""

T = TypeVar("T")
R = TypeVar("R")


class ClusterError(RuntimeError):
    """There is no cluster, or it cannot do the work; the message is what Ray says of it, in one line."""


class _Asked(Generic[R]):
    """A chunk that the cluster has, or will have."""

    def __init__(self, team: "RayTeam", message: bytes) -> None:
        self._team, self.message = team, message
        self.reference: Any = None

    def results(self) -> list[R]:
        results, error = self._team.answer(self)
        if error is not None:
            raise error
        return results


class RayTeam:
    """The processors of a cluster, or some of them, within a `with`.

    Chunks are tasks of Ray that it does not repeat: one whose process, machine or memory is lost is a
    `LostWorkerError`, as in a `Team`. A chunk lies in the object store of this machine until it is done; its
    paths mean what they mean here, so that all machines need the same ones.

    Parameters
    ----------
    workers : how many chunks are worked on at once; None for one on each processor of the cluster
    address : of the cluster, as `ray.init` takes it; None for that of RAY_ADDRESS or one that runs on this
        machine already, and else for one that is started, and ends with the `with`
    warm : processes begin with everything loaded; not worth it where others than these fit
    """

    here = False
    """Whether its processes are on this machine, and have its files."""

    def __init__(self, workers: int | None = None, address: str | None = None, warm: bool = True) -> None:
        self._ray = _ray()
        self._workers, self._address, self._warm = workers, address, warm
        self._processors, self._counted = 1, float("-inf")
        self._queue: deque[_Asked[Any]] = deque()
        self._under_way: dict[Any, _Asked[Any]] = {}

    def __enter__(self) -> Self:
        self._joined = not self._ray.is_initialized()
        if self._joined:
            _join(self._ray, self._address)
        self._task = self._ray.remote(_do).options(
            name="primfit", num_cpus=1, max_retries=0, runtime_env={"env_vars": _environment()}
        )
        return self

    def __exit__(self, *_: object) -> None:
        self._queue.clear()
        for reference in self._under_way:
            with suppress(Exception):
                self._ray.cancel(reference, force=True)
        if self._joined:
            self._ray.shutdown()

    @property
    def size(self) -> int:
        """How many chunks are worked on at once."""
        if self._workers is not None:
            return self._workers
        if monotonic() - self._counted >= ASKED_EVERY:
            self._processors = max(1, int(self._ray.cluster_resources().get("CPU", 1)))
            self._counted = monotonic()
        return self._processors

    def scratch(self) -> Path | None:
        """None: a file of this machine is none of the others."""
        return None

    def submit(self, function: Callable[[T], R], jobs: Sequence[T]) -> Outcome[R]:
        """Have a function applied to each of the jobs, by one process; it, they and results are pickled."""
        asked = _Asked[R](self, pickle.dumps((function, jobs), pickle.HIGHEST_PROTOCOL))
        self._queue.append(asked)
        self._hand_out()
        return asked

    def in_order(self, outcomes: Iterable[Outcome[R]], ahead: int = AHEAD) -> Iterator[R]:
        """The single results of chunks, of which some are asked for ahead."""
        return in_order(outcomes, lambda: ahead * self.size)

    def answer(self, asked: _Asked[R]) -> tuple[Any, Exception | None]:
        """The results of a chunk, or what one of its jobs raised; waits for them."""
        while asked.reference is None or (self._workers and asked.reference in self._under_way):
            self._advance()
        self._under_way.pop(asked.reference, None)
        errors = self._ray.exceptions
        lost = (
            errors.WorkerCrashedError,
            errors.NodeDiedError,
            errors.LocalRayletDiedError,
            errors.OutOfMemoryError,
            errors.ObjectLostError,
        )
        try:
            answer: tuple[Any, Exception | None] = pickle.loads(self._ray.get(asked.reference))
        except lost as error:
            return None, LostWorkerError(f"a process was lost while it worked: {_line(error)}")
        except errors.RayError as error:
            return None, ClusterError(_line(error))
        finally:
            asked.reference = None
        return answer

    async def awaited(self, asked: Outcome[R]) -> list[R]:
        """`asked.results()` for an event loop, of a team without a number of `workers`.

        Where nobody waits for it any more, the chunk is given up, and the process that is at it ends.
        """
        assert isinstance(asked, _Asked) and asked.reference is not None
        try:
            await asyncio.gather(asyncio.wrap_future(asked.reference.future()), return_exceptions=True)
        except asyncio.CancelledError:
            self._under_way.pop(asked.reference, None)
            self._ray.cancel(asked.reference, force=True)
            raise
        return asked.results()

    def _advance(self) -> None:
        """Wait until one of the chunks is done, and give the cluster the next."""
        ready, _ = self._ray.wait(list(self._under_way), num_returns=1, fetch_local=False)
        for reference in ready:
            del self._under_way[reference]
        self._hand_out()

    def _hand_out(self) -> None:
        """Give the cluster what waits: all of it, unless `workers` says how much."""
        while self._queue and (self._workers is None or len(self._under_way) < self._workers):
            asked = self._queue.popleft()
            asked.reference = self._task.remote(os.getcwd(), self._warm, asked.message)
            asked.message = b""
            self._under_way[asked.reference] = asked


def _ray() -> Any:
    for name, value in NAMES.items():
        os.environ.setdefault(name, value)
    try:
        import ray
        import ray.exceptions
    except ImportError as error:
        raise ImportError("the executor ray needs an extra: pip install 'primfit[ray]'") from error
    return ray


def _join(ray: Any, address: str | None) -> None:
    """Raises `ClusterError`."""
    _check_reachable(address or os.environ.get("RAY_ADDRESS"))
    try:
        ray.init(address=address, include_dashboard=False, log_to_driver=False, logging_level="error")
    except (ConnectionError, OSError, RuntimeError, ValueError, ray.exceptions.RayError) as error:
        where = "there is no cluster" if address is None else f"there is no cluster at {address}"
        raise ClusterError(f"{where}: {_line(error)}") from None


def _check_reachable(address: str | None) -> None:
    """Raise `ClusterError` where nobody listens: Ray itself tries for minutes, and then ends this process."""
    host, colon, port = (address or "").rpartition(":")
    if not colon or not port.isdigit():
        return
    try:
        socket.create_connection((host.rpartition("//")[2], int(port)), timeout=ANSWERS_WITHIN).close()
    except OSError as error:
        raise ClusterError(f"there is no cluster at {address}: {error.strerror or error}") from None


def _environment() -> dict[str, str]:
    """Of the processes: what those of a `Team` have."""
    return {name: os.environ.get(name, value) for name, value in KEEP_MEMORY.items()} | dict.fromkeys(
        ONE_THREAD, "1"
    )


def _do(folder: str, warm: bool, message: bytes) -> bytes:
    """What a process of the cluster does with a chunk; a warm one does its first with everything loaded."""
    if warm:
        from . import warmed  # noqa: F401

    with suppress(OSError):
        os.chdir(folder)
    return pickle.dumps(done(message), pickle.HIGHEST_PROTOCOL)


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__
