"""Segments in tasks: what a process is given at once."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from .refs import Ref

LARGEST = 1000
"""Segments of a task, at most."""

LONGEST = 5.0
"""Seconds that a task of several segments takes, at most and about: to send it takes far less, and little is
lost with it."""

PER_SEGMENT, PER_POINT = 0.015, 7.3e-6
"""Seconds of a core, measured by `python -m primfit.benchmark.speed.cost`."""


@dataclass(frozen=True, slots=True)
class Task:
    """The segments that one process fits, one after the other, into one part.

    Attributes
    ----------
    number : from 0 on, in the order of the segments
    """

    number: int
    refs: tuple[Ref, ...]


def seconds(segments: int, points: int) -> float:
    """About how long one core takes for so many segments with so many points in all."""
    return PER_SEGMENT * segments + PER_POINT * points


def tasks(refs: Iterable[Ref]) -> Iterator[Task]:
    """Segments in their order, cut into tasks; how, depends on nothing but the segments."""
    number, cut, cost = 0, list[Ref](), 0.0
    for ref in refs:
        own = seconds(1, ref.n_points)
        if cut and (len(cut) == LARGEST or cost + own > LONGEST):
            yield Task(number, tuple(cut))
            number, cut, cost = number + 1, [], 0.0
        cut.append(ref)
        cost += own
    if cut:
        yield Task(number, tuple(cut))
