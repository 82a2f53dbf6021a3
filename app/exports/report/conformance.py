"""The verdict on what was asked for: form and parameters beside their tolerances."""

import math
from collections.abc import Sequence

from primfit.fitting.answer.conformance import Check, Conformance
from primfit.fitting.answer.summary import verdict_in_words
from primfit.fitting.plain import worded
from primfit.fitting.primitives import is_length

from .markup import Markup, element, table
from .numbers import Unit, rounded
from .tables import cell, column

_CLASSES = {"within": "accepted", "beyond": "failed", "undecided": "refused"}


def in_words(found: Conformance, status: str, kind: str) -> str:
    """The verdict on an answer of this status that shows this kind."""
    if found.verdict is None:
        return "no tolerance was given"
    return verdict_in_words(found.verdict, found.kind, status, kind)


def checks_table(checks: Sequence[Check], unit: str | None) -> Markup:
    """A row for each quantity, whose lengths are in one unit; on a phone the first columns are seen."""
    header = ("", "", *map(column, ("deviation", "allowed", "95% interval", "nominal")))
    return table((_row(check, unit) for check in checks), header)


def _row(check: Check, unit: str | None) -> tuple[object, ...]:
    limits = [limit for limit in (check.lower, check.upper) if limit is not None]
    ends = [end for end in (check.low, check.high) if end is not None]
    of = Unit("\u00b0", math.degrees(1.0))
    if check.name == "form" or is_length(check.name):
        of = Unit.of(max(map(abs, (check.deviation, *limits, *ends))), unit)
    deviation, interval = of.short(check.deviation), ""
    known = max((abs(end - check.deviation) for end in ends), default=0.0) * of.factor
    if known:
        deviation = rounded(check.deviation * of.factor, known)
        low, high = (end and rounded(end * of.factor, known) for end in (check.low, check.high))
        interval = (
            f"{low} to {high}" if len(ends) == 2 else f"at least {low}" if high is None else f"at most {high}"
        )
    allowed = " to ".join(f"{limit * of.factor:.6g}" for limit in limits)
    texts = (_with(deviation, of), _with(allowed, of), _with(interval, of), _nominal(check, unit))
    verdict = element("span", check.verdict or "", class_=_CLASSES.get(check.verdict or "", ""))
    return (worded(check.name), element("td", verdict), *map(cell, texts))


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
