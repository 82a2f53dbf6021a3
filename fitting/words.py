"""Numbers and sentences for people: sensible digits, the unit beside them, ends of ranges that differ."""

import math
from collections.abc import Callable, Iterable
from decimal import Decimal

DIGITS = 3
"""Significant digits of a measured number; as many are shown where they are zeros."""

_PLAIN_FROM, _PLAIN_TO = 1e-6, 1e9
"""Sizes that are written without a power of ten."""

_MOST_DIGITS = 17
"""With so many, numbers of 64 bits that differ are written differently."""


def digits(value: float, n_digits: int = DIGITS) -> str:
    """A number in so many significant digits: `0.0200`, `123000`, `3.88e-09`."""
    if not value:
        return "0"
    if not math.isfinite(value):
        return f"{value:g}"
    text = f"{value:.{n_digits - 1}e}"
    return format(Decimal(text), "f") if _PLAIN_FROM <= abs(value) < _PLAIN_TO else text


def with_unit(text: str, unit: str | None) -> str:
    """A number and the name of its unit, where one is known."""
    return f"{text} {unit}" if unit else text


def figure(value: float, unit: str | None = None, n_digits: int = DIGITS) -> str:
    """A measured number with its unit: `0.0200 mm`."""
    return with_unit(digits(value, n_digits), unit)


def as_given(value: float, unit: str | None = None) -> str:
    """A number that a caller gave, in as few digits as read back to it: `5 mm`."""
    return with_unit(repr(float(value)).removesuffix(".0"), unit)


def between(low: float | None, high: float | None, unit: str | None = None) -> str:
    """A range whose ends differ as they are written: `4.990 to 5.010 mm`. An end that is None is open."""
    if low is None or high is None:
        if low is None:
            return "not bounded by the points" if high is None else f"at most {figure(high, unit)}"
        return f"at least {figure(low, unit)}"
    if low == high:
        return figure(low, unit)
    decimals = 1 - math.floor(math.log10(high - low))
    ends = (digits(end, _significant(end, decimals)) for end in (low, high))
    return with_unit(" to ".join(ends), unit)


def _significant(value: float, decimals: int) -> int:
    """Digits of a number down to a decimal place, within reason."""
    if not value:
        return DIGITS
    return min(max(DIGITS, math.floor(math.log10(abs(value))) + 1 + decimals), _MOST_DIGITS)


def unlike(one: float, other: float, written: Callable[[float, int], str] = digits) -> tuple[str, str]:
    """Two numbers in as many digits as tell them apart; `written` takes a number and how many digits."""
    for n_digits in range(DIGITS, _MOST_DIGITS + 1):
        texts = written(one, n_digits), written(other, n_digits)
        if texts[0] != texts[1]:
            break
    return texts


def percent(share: float, n_digits: int = DIGITS) -> str:
    """A share as whole percents, with a decimal more for each digit over three."""
    return f"{share:.{n_digits - DIGITS}%}"


def part(share: float) -> str:
    """A share as percents that are 0 or 100 only if it is none or all."""
    if share in (0.0, 1.0):
        return percent(share)
    return max((unlike(share, end, percent)[0] for end in (0.0, 1.0)), key=len)


def listed(names: Iterable[str], last: str) -> str:
    """Names in a sentence, `last` before the last of them: `a plane, a sphere or a cone`."""
    *first, end = names
    return f"{', '.join(first)} {last} {end}" if first else end


def sentences(*clauses: str) -> str:
    """Clauses, each as a sentence of its own: it begins with a capital letter and ends with a full stop."""
    told = (clause.strip() for clause in clauses)
    return " ".join(f"{each[0].upper()}{each[1:].rstrip('.')}." for each in told if each)
