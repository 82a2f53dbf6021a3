"""Numbers for people: as many digits as are known."""

import math

MOST_DECIMALS = 12


def short(value: float) -> str:
    """Of a size or an error: four digits, also where they are zeros."""
    return f"{value:#.4g}".rstrip(".") if value else "0"


def known_to(value: float, deviation: float | None) -> str:
    """With two digits of its standard deviation; nine digits where there is none."""
    if not deviation or not math.isfinite(deviation):
        return f"{value:.9g}"
    decimals = 1 - math.floor(math.log10(deviation))
    if not 0 <= decimals <= MOST_DECIMALS or abs(value) >= 1e9:
        return f"{value:.12g}"
    return f"{value:.{decimals}f}"


def between(low: float | None, high: float | None, deviation: float) -> str:
    """An interval, either end of which may be open."""
    if low is None and high is None:
        return "not bounded by the points"
    if low is None or high is None:
        known, word = (high, "at most") if low is None else (low, "at least")
        assert known is not None
        return f"{word} {known_to(known, deviation)}"
    return f"{known_to(low, deviation)} to {known_to(high, deviation)}"
