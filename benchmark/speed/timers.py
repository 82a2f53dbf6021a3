"""Timers around functions by name, in every module that uses them, of processor time within each alone."""

import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import wraps
from importlib import import_module
from typing import Any


class NameGoneError(ValueError):
    """The table of steps names a function that is not there, or is never entered."""


class Clock:
    """Seconds of the processor by step; those of an inner one are not those of the outer one.

    Attributes
    ----------
    seconds, entries : by step, since the last `reset`: how long, and how often it was entered
    entered : the steps that were entered at any time
    """

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self.entries: Counter[str] = Counter()
        self.entered: set[str] = set()
        self._within: list[str] = []
        self._since = 0

    def reset(self) -> None:
        self.seconds, self.entries = {}, Counter()

    def _turn(self) -> None:
        """Give the innermost step what has passed."""
        now = time.process_time_ns()
        if self._within:
            step = self._within[-1]
            self.seconds[step] = self.seconds.get(step, 0.0) + 1e-9 * (now - self._since)
        self._since = now

    def _enter(self, step: str) -> None:
        self._turn()
        self.entered.add(step)
        self.entries[step] += 1
        self._within.append(step)

    def _leave(self) -> None:
        self._turn()
        self._within.pop()

    @contextmanager
    def step(self, name: str) -> Iterator[None]:
        self._enter(name)
        try:
            yield
        finally:
            self._leave()

    def around(self, step: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """The function with its time counted."""

        @wraps(function)
        def timed(*arguments: Any, **named: Any) -> Any:
            self._enter(step)
            try:
                return function(*arguments, **named)
            finally:
                self._leave()

        return timed


@contextmanager
def timers(clock: Clock, steps: Mapping[str, Sequence[str]], root: str = "primfit") -> Iterator[None]:
    """The functions `module:name` or `module:Class.name` of each step with timers around them.

    They are replaced wherever a module of the package holds them, and put back in the end.

    Raises
    ------
    NameGoneError : a function is not there
    """
    placed: list[tuple[Any, str, Any]] = []
    try:
        for step, names in steps.items():
            for name in names:
                owner, attribute, found = _found(f"{root}.{name}", step)
                for holder, held in _holders(owner, attribute, found, root):
                    placed.append((holder, held, found))
                    setattr(holder, held, _around(clock, step, found))
        yield
    finally:
        for holder, held, found in reversed(placed):
            setattr(holder, held, found)


def _found(name: str, step: str) -> tuple[Any, str, Any]:
    """Where a function is defined: module or class, name, and what stands there."""
    module, _, path = name.partition(":")
    *classes, attribute = path.split(".")
    try:
        owner: Any = import_module(module)
        for each in classes:
            owner = getattr(owner, each)
        return owner, attribute, vars(owner)[attribute]
    except (ImportError, AttributeError, KeyError):
        raise NameGoneError(
            f"the step `{step}` names {name}, which is gone; change it in benchmark/speed/table.py"
        ) from None


def _around(clock: Clock, step: str, found: Any) -> Any:
    if isinstance(found, classmethod | staticmethod):
        return type(found)(clock.around(step, found.__func__))
    return clock.around(step, found)


def _holders(owner: Any, attribute: str, found: Any, root: str) -> list[tuple[Any, str]]:
    """The owner, and all modules of the package that have imported the function by any name."""
    modules = [
        module for name, module in list(sys.modules.items()) if name == root or name.startswith(f"{root}.")
    ]
    others = [
        (module, name)
        for module in modules
        if module is not None and module is not owner
        for name, value in list(vars(module).items())
        if value is found
    ]
    return [(owner, attribute), *others]


def check_entered(clock: Clock, steps: Mapping[str, Sequence[str]]) -> None:
    """Raise `NameGoneError` for a step that no cloud has led into: its functions are no longer called."""
    for step, names in steps.items():
        if step not in clock.entered:
            raise NameGoneError(
                f"the step `{step}` was never entered: nobody calls {', '.join(names)}; "
                "change it in benchmark/speed/table.py"
            )
