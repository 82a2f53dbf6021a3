"""Who gets the next free worker: lanes that share the workers' time, and what a newcomer has to expect."""

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass, field
from typing import Generic, TypeVar

W = TypeVar("W")

Abandoned = Callable[[], Awaitable[bool]]
"""Whether nobody waits for a result any more."""

LOOK = 0.25
"""Seconds between two looks whether somebody waits still: work has to end within a second of a client."""

_SMOOTHING = 1 / 8
"""Weight of the last job in the mean of its lane, as TCP smooths round trips (Jacobson 1988)."""


@dataclass(eq=False)
class Turn(Generic[W]):
    """A job's place in its lane, and in time the worker that it is given."""

    lane: "_Lane[W]"
    heavy: bool
    worker: W | None = None
    expected: float = 0.0
    _waiter: asyncio.Future[None] | None = None

    def give(self, worker: W) -> None:
        """Let it begin."""
        self.worker = worker
        self._wake()

    async def wait(self, seconds: float) -> None:
        """Wait for a worker, for so long at most: a turn of the event loop after it is given, no more.

        Until then it is idle, and under load each turn of the loop is milliseconds long.
        """
        loop = asyncio.get_running_loop()
        self._waiter = loop.create_future()
        timer = loop.call_later(seconds, self._wake)
        try:
            await self._waiter
        finally:
            timer.cancel()

    def _wake(self) -> None:
        if self._waiter is not None and not self._waiter.done():
            self._waiter.set_result(None)


@dataclass(eq=False)
class _Lane(Generic[W]):
    """Jobs of one sort in their order; the seconds that all got so far, and those that one takes."""

    waiting: deque[Turn[W]] = field(default_factory=deque)
    served: float = 0.0
    mean: float = 0.0


class Line(Generic[W]):
    """Free workers, and lanes of jobs that wait for one.

    Each lane with something to do gets the same share of the workers' time (start-time fair queueing: Goyal,
    Vin and Cheng, SIGCOMM 1996). All heavy jobs together leave one worker to the others, where there are two.
    """

    def __init__(self, lanes: Iterable[str], size: int) -> None:
        self._lanes: dict[str, _Lane[W]] = {name: _Lane() for name in lanes}
        self._size, self._most_heavy = size, max(1, size - 1)
        self._free: deque[W] = deque()
        self._n_heavy, self._virtual = 0, 0.0

    def n_waiting(self, *names: str) -> int:
        """How many jobs of these lanes wait; of all lanes by default."""
        return sum(len(self._lanes[name].waiting) for name in names or self._lanes)

    def has_room(self, heavy: bool) -> bool:
        """Whether a job would begin at once."""
        # Who waits while a worker is free is heavy, and may not begin.
        return bool(self._free) and not (heavy and self._n_heavy >= self._most_heavy)

    def seconds_to_wait(self, name: str) -> float:
        """What a newcomer to a lane has to expect, by what its jobs took so far."""
        lane = self._lanes[name]
        shared_by = 1 + sum(bool(other.waiting) for other in self._lanes.values() if other is not lane)
        return lane.mean * (len(lane.waiting) + 1) * shared_by / self._size

    def seconds_of_work(self, name: str) -> float:
        """What a job of this lane takes, by those that were done; 0 before the first."""
        return self._lanes[name].mean

    async def turn(self, name: str, heavy: bool, end: float | None, abandoned: Abandoned) -> Turn[W] | None:
        """Wait for a worker; None where the job was abandoned meanwhile.

        Raises `TimeoutError` at `end`, in the time of the event loop. `done` and `free` have to follow.
        """
        loop, lane = asyncio.get_running_loop(), self._lanes[name]
        turn: Turn[W] = Turn(lane, heavy)
        if not lane.waiting:
            lane.served = max(lane.served, self._virtual)
        lane.waiting.append(turn)
        self._hand_out()
        try:
            while turn.worker is None:
                left = LOOK if end is None else min(LOOK, end - loop.time())
                if left <= 0:
                    raise TimeoutError
                await turn.wait(left)
                if turn.worker is None and await abandoned():
                    self.withdraw(turn)
                    return None
        except BaseException:
            self.withdraw(turn)
            raise
        return turn

    def done(self, turn: Turn[W], seconds: float | None, finished: bool = True) -> None:
        """A job is over and took so long; None for one that was not begun.

        One that was cut off says nothing of how long those of its lane take.
        """
        lane = turn.lane
        self._n_heavy -= turn.heavy
        lane.served += (seconds or 0.0) - turn.expected
        if seconds is not None and finished:
            lane.mean += _SMOOTHING * (seconds - lane.mean) if lane.mean else seconds

    def free(self, worker: W) -> None:
        """A worker can take a job."""
        self._free.append(worker)
        self._hand_out()

    def withdraw(self, turn: Turn[W]) -> None:
        """Take a job out that is not begun, whether it has a worker or not."""
        if turn.worker is not None:
            self.done(turn, None)
            self.free(turn.worker)
        else:
            turn.lane.waiting.remove(turn)
            self._hand_out()

    def _hand_out(self) -> None:
        """Give the free workers to those who come next."""
        while self._free and (turn := self._next()):
            turn.lane.waiting.popleft()
            self._virtual = turn.lane.served
            turn.expected = turn.lane.mean
            turn.lane.served += turn.expected
            self._n_heavy += turn.heavy
            turn.give(self._free.popleft())

    def _next(self) -> Turn[W] | None:
        """The first of the lane that got the least, out of those that may begin."""
        firsts = [lane.waiting[0] for lane in self._lanes.values() if lane.waiting]
        if self._n_heavy >= self._most_heavy:
            firsts = [turn for turn in firsts if not turn.heavy]
        return min(firsts, key=lambda turn: turn.lane.served, default=None)
