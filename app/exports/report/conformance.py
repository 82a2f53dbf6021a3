"""The verdict on what was asked for: form and parameters beside their tolerances."""

import math
from collections.abc import Sequence

from primfit.fitting.answer.conformance import Check, Conformance
from primfit.fitting.answer.summary import VERDICTS
from primfit.fitting.plain import worded
from primfit.fitting.primitives import is_length

from .markup import Markup, element, table
from .numbers import Unit, rounded
from .tables import cell, column

_CLASSES = {"within": "accepted", "beyond": "failed", "undecided": "refused"}


def in_words(found: Conformance) -> str:
    """The verdict."""
    if found.kind is None:
        return "another shape than asked for"
    return "no tolerance was given" if found.verdict is None else VERDICTS[found.verdict]


def checks_table(checks: Sequence[Check], unit: str | None) -> Markup:
    """A row for each quantity, whose lengths are in one unit."""
    header = ("", *map(column, ("nominal", "deviation", "95% interval", "allowed")), "")
    return table((_row(check, unit) for check in checks), header)


def _row(check: Check, unit: str | None) -> tuple[object, ...]:
    limits = [limit for limit in (check.lower, check.upper) if limit is not None]
    ends = [end for end in (check.low, check.high) if end is not None]
    of = Unit("\u00b0", math.degrees(1.0))
    if check.name == "form" or is_length(check.name):
        of = Unit.of(max(map(abs, (check.deviation, *limits, *ends))), unit)
    deviation, interval = of.short(check.deviation), ""
    if len(ends) == 2 and ends[0] != ends[1]:
        known = (ends[1] - ends[0]) / 2.0 * of.factor
        deviation, *shown = (rounded(value * of.factor, known) for value in (check.deviation, *ends))
        interval = " to ".join(shown)
    allowed = " to ".join(f"{limit * of.factor:.6g}" for limit in limits)
    texts = (_nominal(check, unit), _with(deviation, of), _with(interval, of), _with(allowed, of))
    verdict = element("span", check.verdict or "", class_=_CLASSES.get(check.verdict or "", ""))
    return (worded(check.name), *map(cell, texts), element("td", verdict))


def _with(text: str, of: Unit) -> str:
    """A text of numbers and their unit."""
    if not text:
        return ""
    return f"{text}{of.name}" if of.name == "\u00b0" else f"{text} {of.name}".rstrip()


def _nominal(check: Check, unit: str | None) -> str:
    """As it was given."""
    if check.name == "form":
        return ""
    if isinstance(check.nominal, tuple):
        return ", ".join(f"{number:.9g}" for number in check.nominal)
    if is_length(check.name):
        return f"{check.nominal:.9g} {unit or ''}".rstrip()
    return f"{math.degrees(check.nominal):.9g}\u00b0"
