"""A run as a discrete simulation: one driver, workers on nodes that may be lost, and a storage for all.

It follows `app/bulk/run.py`. The driver plans, then hands out tasks in order, and waits for the oldest one
when so many are under way or wait for their turn; every few seconds it writes the manifest. What is lost with
a node is done again after all others, and what is lost then, one by one at the end.
"""

from collections import deque
from collections.abc import Callable, Generator, Iterable
from functools import partial
from typing import Any

import numpy as np
import simpy

from .model import Course, Fleet, Loads, Parameters
from .records import Executor
from .shared import Shared

Process = Generator[Any, Any, None]


def simulate(parameters: Parameters, executor: Executor, fleet: Fleet, loads: Loads, seed: int = 0) -> Course:
    """The course of a run; the same for the same seed. Raises `RuntimeError` where no node is left."""
    env = simpy.Environment()
    team, planned = parameters.teams[executor], parameters.start + parameters.planned * loads.n_segments
    rng = np.random.default_rng(seed)
    alone = team.slower * loads.work(parameters, rng)
    tasks = _tasks(parameters, fleet, loads, alone, rng)
    workers = _Workers(env, fleet, rng, team.start, fleet.killed and fleet.killed * len(loads))
    driver = _Driver(env, parameters, executor, workers)
    env.run(env.process(driver.run(planned, tasks)))
    return Course(env.now, float(alone.sum()), planned, planned + driver.busy, workers.n_lost, fleet.workers)


class _Task:
    """A task on its way; what is planned for it is dropped when `attempt` has changed."""

    __slots__ = ("attempt", "done", "lost", "node", "read", "told", "work", "written")

    def __init__(self, work: float, read: float, written: float) -> None:
        self.work, self.read, self.written = work, read, written
        self.attempt = 0
        self.begin_anew()

    def begin_anew(self) -> None:
        self.done = self.lost = False
        self.told: simpy.Event | None = None
        self.node = -1

    def end(self, lost: bool = False) -> None:
        """Its part is there, or the driver knows that there will be none."""
        self.done, self.lost = True, lost
        if self.told is not None:
            self.told.succeed()


def _tasks(
    parameters: Parameters, fleet: Fleet, loads: Loads, work: Any, rng: np.random.Generator
) -> Iterable[_Task]:
    slow = rng.random(len(work)) < fleet.straggling
    taken = np.where(slow, fleet.straggle * work, work)
    read, written = parameters.point_bytes * loads.points, parameters.row_bytes * loads.segments
    return (_Task(*map(float, each)) for each in zip(taken, read, written, strict=True))


class _Driver:
    """Who hands out tasks; `busy` are the seconds that it was at work since the plan."""

    def __init__(
        self, env: simpy.Environment, parameters: Parameters, executor: Executor, workers: "_Workers"
    ) -> None:
        self._env, self._parameters, self._workers = env, parameters, workers
        self._team = parameters.teams[executor]
        self._n_done, self._saved, self.busy = 0, 0.0, 0.0
        self._pause = parameters.saved_every

    def run(self, planned: float, tasks: Iterable[_Task]) -> Process:
        yield self._env.timeout(planned + self._team.start)
        self._saved = self._env.now
        self._workers.begin()
        for _ in range(2):
            lost: list[_Task] = []
            yield from self._round(tasks, lost)
            tasks = lost
        if lost:  # one by one, in one process
            yield self._env.timeout(self._team.start + sum(task.work for task in lost))
        yield self._env.timeout(self._team.end)

    def _round(self, tasks: Iterable[_Task], lost: list[_Task]) -> Process:
        """Hand out all tasks, and collect those that were lost."""
        begun: deque[_Task] = deque()
        for task in tasks:
            task.begin_anew()
            if self._team.per_task:
                yield self._for(self._team.per_task)
            begun.append(task)
            self._workers.give(task)
            while len(begun) > self._parameters.ahead * self._workers.size:
                yield from self._oldest(begun.popleft(), lost)
        while begun:
            yield from self._oldest(begun.popleft(), lost)

    def _oldest(self, task: _Task, lost: list[_Task]) -> Process:
        """Wait for the task that was handed out first."""
        if not task.done:
            task.told = self._env.event()
            yield task.told
        if task.lost:
            lost.append(task)
            return
        self._n_done += 1
        if self._parameters.saved and self._env.now - self._saved >= self._pause:
            taken = self._parameters.saved * self._n_done
            yield self._for(taken)
            self._saved, self._pause = self._env.now, self._pause_after(taken)

    def _pause_after(self, taken: float) -> float:
        return max(self._parameters.saved_every, taken / self._parameters.saving)

    def _for(self, seconds: float) -> simpy.Event:
        self.busy += seconds
        return self._env.timeout(seconds)


class _Workers:
    """Nodes with their processors, and the storage."""

    def __init__(
        self,
        env: simpy.Environment,
        fleet: Fleet,
        rng: np.random.Generator,
        start: float,
        kill_at: float | None,
    ) -> None:
        self._env, self._fleet, self._rng = env, fleet, rng
        self._start, self._kill_at = start, kill_at
        drawn = 1.0 + fleet.uneven * rng.standard_normal(fleet.nodes)
        self._speed = [float(speed) for speed in np.maximum(drawn, 0.1)]
        self._n_alive = fleet.nodes
        # The last of the list comes first: tasks go to all nodes in turns.
        self._idle = [node for _ in range(fleet.cores) for node in range(fleet.nodes)]
        self._waiting: deque[_Task] = deque()
        self._at_work: dict[_Task, None] = {}
        self._shared = None if fleet.shared is None else Shared(env, fleet.shared)
        self._pipe_free = 0.0
        self.n_finished = self.n_lost = 0

    def begin(self) -> None:
        """From now on nodes are lost."""
        if np.isfinite(self._fleet.loss.every):
            for node in range(self._fleet.nodes):
                self._env.process(self._losses(node))

    @property
    def size(self) -> int:
        """How many there are; never none, for the driver waits for more."""
        return max(1, self._n_alive * self._fleet.cores)

    def give(self, task: _Task) -> None:
        self._waiting.append(task)
        self._hand_out()

    def _hand_out(self) -> None:
        while self._waiting and self._idle:
            task = self._waiting.popleft()
            task.node = self._idle.pop()
            self._at_work[task] = None
            self._read(task)

    def _read(self, task: _Task) -> None:
        read, work = self._moved(task.read), task.work / self._speed[task.node]
        if self._shared is None:
            self._later(read + work, task, self._write)
        else:
            self._later(read, task, partial(self._compute, self._shared, work))

    def _compute(self, shared: Shared, work: float, task: _Task) -> None:
        shared.begin(task, work, partial(self._write, task))

    def _write(self, task: _Task) -> None:
        if delay := self._moved(task.written):
            self._later(delay, task, self._finish)
        else:
            self._finish(task)

    def _finish(self, task: _Task) -> None:
        del self._at_work[task]
        task.end()
        self.n_finished += 1
        self._idle.append(task.node)
        if self._kill_at is not None and self.n_finished >= self._kill_at:
            self._kill_at = None
            self._lose(self._fleet.nodes - 1)
        self._hand_out()

    def _later(self, delay: float, task: _Task, do: Callable[[_Task], None]) -> None:
        """Do this then, unless the task is lost meanwhile."""
        attempt = task.attempt

        def then(_: simpy.Event) -> None:
            if task.attempt == attempt:
                do(task)

        timeout = self._env.timeout(delay)
        assert timeout.callbacks is not None
        timeout.callbacks.append(then)

    def _moved(self, n_bytes: float) -> float:
        """Seconds until so many bytes are read or written. Who asks first is served first, which keeps the
        storage as busy as equal shares would."""
        storage, now = self._fleet.storage, self._env.now
        if np.isinf(storage.bandwidth):
            return storage.latency
        self._pipe_free = max(now, self._pipe_free) + n_bytes / storage.bandwidth
        return storage.latency + self._pipe_free - now

    def _losses(self, node: int) -> Process:
        loss = self._fleet.loss
        while True:
            yield self._env.timeout(self._rng.exponential(loss.every))
            self._lose(node)
            if not np.isfinite(loss.back):
                return
            yield self._env.timeout(loss.back + self._start)
            self._return(node)

    def _lose(self, node: int) -> None:
        """The tasks of a node are lost; the driver knows it later."""
        self._n_alive -= 1
        self._idle = [other for other in self._idle if other != node]
        lost = [task for task in self._at_work if task.node == node]
        if self._shared is not None:
            self._shared.stop(lost)
        for task in lost:
            del self._at_work[task]
            task.attempt += 1
            self.n_lost += 1
            self._later(self._fleet.loss.detected, task, partial(_Task.end, lost=True))

    def _return(self, node: int) -> None:
        self._n_alive += 1
        self._idle += [node] * self._fleet.cores
        self._hand_out()
