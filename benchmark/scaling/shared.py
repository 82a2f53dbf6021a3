"""Processors that more workers share than there are of them: all have equal shares."""

from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import Any

import simpy


@dataclass
class _Job:
    """What is left of it, in seconds of a processor of its own."""

    left: float
    then: Callable[[], None]


class Shared:
    """So many processors, and the jobs that are on them."""

    def __init__(self, env: simpy.Environment, processors: int) -> None:
        self._env, self._processors = env, processors
        self._jobs: dict[Hashable, _Job] = {}
        self._since = 0.0
        self._change = 0

    def begin(self, name: Hashable, seconds: float, then: Callable[[], None]) -> None:
        """Compute so long on a processor, or longer on a share of one; `then` is called at the end."""
        self._advance()
        self._jobs[name] = _Job(seconds, then)
        self._await_next()

    def stop(self, names: Iterable[Hashable]) -> None:
        """Take these jobs away, where they are."""
        self._advance()
        for name in names:
            self._jobs.pop(name, None)
        self._await_next()

    @property
    def _rate(self) -> float:
        return min(1.0, self._processors / max(1, len(self._jobs)))

    def _advance(self) -> None:
        for job in self._jobs.values():
            job.left -= self._rate * (self._env.now - self._since)
        self._since = self._env.now

    def _await_next(self) -> None:
        """The job that ends first, unless another comes or goes before."""
        self._change += 1
        if not self._jobs:
            return
        name = min(self._jobs, key=lambda name: self._jobs[name].left)
        timeout = self._env.timeout(max(0.0, self._jobs[name].left) / self._rate, (name, self._change))
        assert timeout.callbacks is not None
        timeout.callbacks.append(self._ended)

    def _ended(self, timeout: Any) -> None:
        name, change = timeout.value
        if change != self._change:
            return
        self._advance()
        job = self._jobs.pop(name)
        self._await_next()
        job.then()
