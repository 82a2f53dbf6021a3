"""What a proof is: cases drawn from a seed, and what is measured of each."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

Figures = dict[str, float]
Level = str | float


@dataclass(frozen=True, eq=False)
class Trial:
    """One case.

    Attributes
    ----------
    groups : what the report groups by
    drawn : the case in words
    measure : the figures of it; infinite where an answer is missing or another one than it should be
    """

    groups: Mapping[str, Level]
    drawn: str
    measure: Callable[[], Figures]


@dataclass(frozen=True)
class Proof:
    """A family of cases: case `i` of a seed is draw(seed, i); small and full runs take so many."""

    about: str
    small: int
    full: int
    draw: Callable[[int, int], Trial]


class UnfittedError(RuntimeError):
    """There is no answer to measure."""
