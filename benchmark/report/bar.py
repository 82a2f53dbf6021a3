"""What a bar is: which clouds, what is asked of them, and how that is measured of their records."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..records import Record
from ..scores import share
from .markdown import percent

Records = Sequence[Record]
Measure = Callable[[Sequence[Record]], "Figure"]

STANDARD_ERRORS = 3.0
"""As many are no accident."""


@dataclass(frozen=True)
class Figure:
    """What was measured; `met` is None where the records do not tell."""

    text: str
    met: bool | None
    clouds: int


@dataclass(frozen=True)
class Bar:
    """One line: which clouds, what is asked, and how it is measured of their records.

    Attributes
    ----------
    levels : of each group named, the only one that is looked at; (group, level, whether it is that one)
    """

    case: str
    bar: str
    sets: tuple[str, ...]
    measure: Callable[[Records], Figure]
    levels: tuple[tuple[str, object, bool], ...] = ()

    def concerns(self, record: Record) -> bool:
        at = all((record.groups.get(group) == level) is asked for group, level, asked in self.levels)
        return record.set in self.sets and at


def at_least(least: float, holds: Callable[[Record], bool]) -> Callable[[Records], Figure]:
    """On a share of the clouds something holds."""
    return lambda records: _share(records, holds, lambda found: found >= least)


def at_most(most: float, holds: Callable[[Record], bool]) -> Callable[[Records], Figure]:
    return lambda records: _share(records, holds, lambda found: found <= most)


def _share(records: Records, holds: Callable[[Record], bool], met: Callable[[float], bool]) -> Figure:
    found = share(records, holds)
    return Figure(percent(found), met(found), len(records))


def is_right(record: Record) -> bool:
    return record.right


def has_status(status: str) -> Callable[[Record], bool]:
    return lambda record: record.status == status
