"""Numbers for people: as many digits as are known, in a unit that spares them leading zeros."""

import math
from dataclasses import dataclass

from primfit.fitting.uncertainty.values import Interval

SMALLER = {
    "m": (("m", 1.0), ("mm", 1e3), ("µm", 1e6), ("nm", 1e9)),
    "mm": (("mm", 1.0), ("µm", 1e3), ("nm", 1e6)),
}
"""Units that lengths in a unit may be printed in, and how many of them it is."""

NO_ZEROS = 0.1
"""From here on a number has no zero after its point."""

SYMMETRIC = 0.05
"""Relative difference of the two halves of an interval up to which it is printed as one half."""

KNOWN = 1e-9
"""Digits of a number below so small a share of the size of the cloud are those of the rounding."""

GROUPED, LARGEST, MOST_DECIMALS = 1e4, 1e15, 9
"""From the first on numbers of a column are whole, from the second on their zeros are not printed; nor are
those of numbers that would have more decimals."""


@dataclass(frozen=True)
class Unit:
    """What lengths are printed in: a name, empty where the unit is not known, and how many the input's is."""

    name: str
    factor: float = 1.0

    @classmethod
    def of(cls, size: float, unit: str | None) -> "Unit":
        """The largest unit in which a size has no leading zeros."""
        for name, factor in SMALLER.get(unit or "", ()):
            if abs(size) * factor >= NO_ZEROS or size == 0.0:
                return cls(name, factor)
        return cls(*SMALLER[unit][-1]) if unit in SMALLER else cls(unit or "")

    @property
    def bracketed(self) -> str:
        """Behind the name of a column or an axis."""
        return f" [{self.name}]" if self.name else ""

    def short(self, value: float) -> str:
        return short(value * self.factor)

    def two(self, value: float) -> str:
        """Two digits, as of half an interval."""
        return rounded(value * self.factor, value * self.factor)

    def said(self, value: float) -> str:
        """With the unit."""
        return f"{self.short(value)} {self.name}".rstrip()


def length(value: float, unit: str | None) -> tuple[str, str]:
    """The number and the unit that it is printed in."""
    of = Unit.of(value, unit)
    return of.short(value), of.name


def said(value: float, unit: str | None) -> str:
    """A length with its unit."""
    return Unit.of(value, unit).said(value)


def count(n: int, noun: str) -> str:
    """`1 point`, `1,200 points`."""
    return f"{n:,} {noun}" + ("" if n == 1 else "s")


def short(value: float) -> str:
    """Of a size or an error: four digits, also where they are zeros, and all before the point."""
    if GROUPED <= abs(value) < LARGEST:
        return f"{value:,.0f}"
    return f"{value:#.4g}".rstrip(".") if value else "0"


def column(value: float, size: float) -> str:
    """In a column of numbers of about this size, which has four digits: with as many decimals as that."""
    decimals = max(_decimals(size) + 2, 0)
    if abs(value) >= LARGEST or decimals > MOST_DECIMALS:
        return short(value)
    return f"{value:,.0f}" if abs(value) >= GROUPED else f"{value:z.{decimals}f}"


def rounded(value: float, known: float) -> str:
    """To two digits of what it is known to, and to two digits of its own at least."""
    if abs(value) >= LARGEST or not math.isfinite(known):
        return f"{value:.9g}"
    decimals = _decimals(known)
    if decimals < 0 and value:
        decimals = max(decimals, _decimals(value))
    return f"{round(value, decimals):z.{max(decimals, 0)}f}"


def _decimals(size: float) -> int:
    """Decimals that show two digits of a number of this size; less than 0 where these stand before zeros."""
    return 1 - math.floor(math.log10(abs(size))) if size else 0


def measured(value: float, interval: Interval | None, size: float, factor: float = 1.0) -> tuple[str, str]:
    """A number and its interval of 95%, to two digits of half of it.

    Parameters
    ----------
    size : of the cloud, in the unit of the number before it is multiplied
    factor : that the number, its interval and the size are multiplied by
    """
    value, least = value * factor, KNOWN * size * factor
    if interval is None:
        return f"{value:.9g}" if abs(value) > least else "0", ""
    if interval.method == "held":
        return f"{value:.9g}" if abs(value) > least else "0", "held by a constraint"
    ends = [end if end is None else end * factor for end in (interval.low, interval.high)]
    low, high = ends
    halves = [abs(value - end) for end in ends if end is not None]
    known = max(max(halves, default=interval.standard_deviation * factor), least)
    return rounded(value, known), _interval(value, low, high, known if known > least else 0.0)


def _interval(value: float, low: float | None, high: float | None, known: float) -> str:
    """As ± where it is symmetric, by its ends where it is not; either of them may be open."""
    if low is None or high is None:
        return _open(low, high, known)
    if not known:
        return plus_minus("rounding")
    below, above = value - low, high - value
    if abs(above - below) <= SYMMETRIC * known:
        return plus_minus(rounded(known, known))
    return f"{rounded(low, known)} to {rounded(high, known)}"


def plus_minus(half: str) -> str:
    """Half of an interval, on one line with its sign."""
    return f"±\u00a0{half}"


def _open(low: float | None, high: float | None, known: float) -> str:
    for end, word in ((low, "at least"), (high, "at most")):
        if end is not None:
            return f"{word} {rounded(end, known)}"
    return "unbounded"
