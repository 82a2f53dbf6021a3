"""Tables and numbers in Markdown."""

from collections.abc import Iterable, Sequence

import numpy as np

NOTHING = "–"


def table(header: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> list[str]:
    """The lines of a table; the first `left` columns are flush left, the others flush right."""
    rule = ["---"] * left + ["--:"] * (len(header) - left)
    return [f"| {' | '.join(cells)} |" for cells in (header, rule, *rows)]


def percent(share: float, digits: int = 1) -> str:
    """All and nothing without digits; what is neither is not rounded to them."""
    if np.isnan(share):
        return NOTHING
    if share in (0.0, 1.0):
        return f"{100 * share:.0f}%"
    text = f"{100 * share:.{digits}f}"
    return f"{100 * share:.2g}%" if float(text) == 0.0 else f"{text}%" if float(text) < 100.0 else "over 99%"


def scientific(value: float) -> str:
    """Two digits; an infinite one is a wrong answer."""
    if np.isnan(value):
        return NOTHING
    return "wrong" if np.isinf(value) else f"{value:.1e}"


def milliseconds(seconds: float) -> str:
    """Two to three digits."""
    if np.isnan(seconds):
        return NOTHING
    return f"{1e3 * seconds:.2g}" if seconds < 0.0995 else f"{1e3 * seconds:,.0f}"


def count(number: int) -> str:
    """Nothing for 0, so that what is there stands out."""
    return f"{number:,}" if number else ""


def commands(lines: Iterable[str]) -> list[str]:
    """A block of commands."""
    return ["```sh", *lines, "```"]
