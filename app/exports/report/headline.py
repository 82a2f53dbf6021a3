"""What people look for first: the kind, its sizes with their intervals, form error, inliers."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from primfit.fitting.answer.residuals import Deviations
from primfit.fitting.errors import FailedFit
from primfit.fitting.extents.values import Extents
from primfit.fitting.plain import worded
from primfit.fitting.primitives import SIZES, is_angle
from primfit.fitting.uncertainty.values import Interval

from ..fitted import Fitted
from .conformance import in_words
from .markup import Markup, element
from .numbers import Unit, measured, said
from .ranges import above

Row = tuple[str, str, str]
"""A name, what is found, and how well it is known."""

FULL_TURN = 359.999
"""Degrees from which an arc is no news."""


def figures(fitted: Fitted, inliers: Deviations, unit: str | None) -> Markup:
    """The rows as large figures."""
    return element("dl", *(_figure(*row) for row in headline(fitted, inliers, unit)), class_="figures")


def _figure(name: str, found: str, known: str) -> Markup:
    beside = [element("dd", known, class_="known")] if known else []
    return element("div", element("dt", name), element("dd", found), *beside)


def headline(fitted: Fitted, inliers: Deviations, unit: str | None) -> Iterator[Row]:
    """The leading rows of an answer with a fit, whose inliers have these deviations."""
    recognition, form = fitted.recognition, fitted.form
    yield "kind", _kinds(fitted), ""
    asked = recognition.conformance
    if asked is not None:
        verdict, _, why = in_words(asked, recognition.status, fitted.primitive.kind).partition(": ")
        yield "verdict", verdict, why
    yield from _sizes(fitted, unit)
    if recognition.extents is not None:
        yield from _reach(recognition.extents, unit)
    if not isinstance(form.minimum_zone, FailedFit):
        yield form.name, said(above(form.minimum_zone.form_error, fitted.rounding), unit), "minimum zone"
    yield "rms of inliers", said(above(inliers.rms, fitted.rounding), unit), ""
    yield "inliers", f"{inliers.n_points:,}", f"of {len(fitted.points):,} points"


def _kinds(fitted: Fitted) -> str:
    """All that an ambiguous answer names, the one that is shown first."""
    *kinds, last = (
        fitted.primitive.kind,
        *(other.primitive.kind for other in fitted.recognition.alternatives),
    )
    return f"{', '.join(kinds)} or {last}" if kinds else last


def _sizes(fitted: Fitted, unit: str | None) -> Iterator[Row]:
    known = fitted.recognition.uncertainty
    intervals = {} if known is None else known.intervals
    for name in SIZES:
        value = getattr(fitted.primitive, name, None)
        if value is None:
            continue
        interval = intervals.get(name)
        if is_angle(name):
            found, within = measured(value, interval, 1.0, math.degrees(1.0))
            yield worded(name), f"{found}\u00b0", f"{within}\u00b0" if within.startswith("±") else within
            continue
        of = Unit.of(value, unit)
        if name == "radius":
            yield "diameter", *_size(2.0 * value, _doubled(interval), fitted.size, of)
        yield worded(name), *_size(value, interval, fitted.size, of)


def _doubled(interval: Interval | None) -> Interval | None:
    if interval is None:
        return None
    low, high = (end if end is None else 2.0 * end for end in (interval.low, interval.high))
    return replace(interval, low=low, high=high, standard_deviation=2.0 * interval.standard_deviation)


def _size(value: float, interval: Interval | None, size: float, unit: Unit) -> tuple[str, str]:
    found, within = measured(value, interval, size, unit.factor)
    return f"{found} {unit.name}".rstrip(), within


def _reach(extents: Extents, unit: str | None) -> Iterator[Row]:
    """How long and wide it is, and how far around points are where that is no full turn."""
    start, end = (getattr(extents, name, None) for name in ("start", "end"))
    length = getattr(extents, "length", None)
    if length is None and start is not None and end is not None:
        length = float(np.linalg.norm(end - start))
    sides = (("length", length), *((name, getattr(extents, name, None)) for name in ("width", "height")))
    for name, side in sides:
        if side is not None:
            yield name, said(side, unit), ""
    for where, degrees in extents.arcs.items():
        if degrees < FULL_TURN:
            yield f"arc {where}" if where != "cap" else "cap", f"{degrees:.4g}\u00b0", ""
