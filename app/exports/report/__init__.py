"""One HTML file about one answer, with its pictures in it: it needs nothing else, and no network."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from primfit.fitting.answer.residuals import Deviations
from primfit.fitting.answer.result import Alternative
from primfit.fitting.errors import FailedFit
from primfit.fitting.plain import worded
from primfit.fitting.primitives import SIZES, is_angle

from ..colors import color_limit
from ..drawing import DRAWINGS
from ..fitted import Fitted, NothingToExportError
from ..options import ExportOptions
from . import tables
from .histogram import histogram
from .markup import Markup, element, joined, table
from .numbers import known_to, short
from .scene import SHOWN_POINTS, Scene, shape_in
from .svg import PICTURE_STYLE
from .unrolled import unrolled_map
from .views import lone_view, views

_STYLE = Path(__file__).with_name("style.css")
_UNKNOWN = {
    True: "Nothing is known of their uncertainty under this criterion.",
    False: "Their uncertainty was not asked for.",
}
"""What stands in place of an uncertainty, by whether it was asked for."""
_SAID = {"fitted": "fitted", "ambiguous": "ambiguous", "no_fit": "no fit"}


def html_report(fitted: Fitted, options: ExportOptions) -> bytes:
    """The page in UTF-8; the same answer and points give the same bytes.

    An answer without a fit gets one, too: it shows the points and says why there is none.

    Raises
    ------
    NothingToExportError
        None of the points belongs to the primitive: they are not those that were fitted.
    """
    recognition, points = fitted.recognition, fitted.points
    if recognition.status != "no_fit" and not fitted.residuals.inlier.any():
        raise NothingToExportError(f"none of the {len(points)} points lies near the {fitted.primitive.kind}")
    kind = fitted.primitive.kind if recognition.status != "no_fit" else "point cloud"
    title = f"{kind.capitalize()}, {len(points):,} points"
    head = joined(
        [
            Markup('<meta charset="utf-8">'),
            Markup('<meta name="viewport" content="width=device-width, initial-scale=1">'),
            element("title", title),
            element("style", PICTURE_STYLE, Markup(_STYLE.read_text(encoding="utf-8"))),
        ]
    )
    chip = element("small", _SAID[recognition.status], class_=recognition.status)
    header = element("header", element("h1", kind.capitalize(), chip), element("p", recognition.message))
    parts = _fit_parts if recognition.status != "no_fit" else _no_fit_parts
    foot = element("footer", "Made by primfit. Lengths are in the unit of the input.")
    body = element("body", header, *parts(fitted, options.unit), *_trail(fitted), foot)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>{body}</html>\n'.encode()


def scene_svg(fitted: Fitted, unit: str = "") -> str:
    """The isometric view of the points and the trimmed primitive as one SVG, which brings its own style.

    A notebook may show it, or a file hold it; under `no_fit` it shows the points alone. Raises
    `InvalidOptionError` where there are no points.
    """
    is_fit = fitted.recognition.status != "no_fit"
    return lone_view(Scene.of(fitted), color_limit(fitted.residuals) if is_fit else 0.0, unit)


def _fit_parts(fitted: Fitted, unit: str) -> Iterator[Markup]:
    residuals, recognition = fitted.residuals, fitted.recognition
    inlying = residuals.distance[residuals.inlier]
    every, inliers = Deviations.of(residuals.distance), Deviations.of(inlying)
    limit = color_limit(residuals)
    yield _key_figures(fitted, inliers, unit)
    if recognition.uncertainty and recognition.uncertainty.warnings:
        items = (element("li", warning.message) for warning in recognition.uncertainty.warnings)
        yield element("ul", *items, class_="warnings")
    yield _views(fitted, limit, unit)
    if shape_in(fitted) is not None:
        told = "Of the inliers: each of them, or means of cells where they are many. Grey is where none are."
        figure = element("figure", unrolled_map(fitted, limit, unit))
        yield _section("Residuals on the unrolled surface", told, figure)
    told = f"Signed distances of the inliers: positive {DRAWINGS[fitted.primitive.kind].POSITIVE}."
    yield _section("Residuals", told, element("figure", histogram(inliers, limit, unit)))
    told = (
        "Peak to valley of the inliers: the width of the zone between two offsets of the reference feature "
        "that holds them. All numbers of either feature are free."
    )
    yield _section("Form error", told, tables.form_table(fitted.form, unit))
    percentiles = tables.percentiles_table(every, inliers, unit)
    pair = (
        _section("Error and noise", "", tables.error_table(recognition, unit)),
        _section("Percentiles", "", percentiles),
    )
    yield element("div", *pair, class_="pair")
    yield from _numbers(fitted, unit)


def _numbers(fitted: Fitted, unit: str) -> Iterator[Markup]:
    recognition = fitted.recognition
    told = "" if recognition.uncertainty else _UNKNOWN["uncertainty" in recognition.include]
    parameters = tables.parameters_table(fitted.primitive, recognition.uncertainty, unit)
    parts = [_section(f"Parameters of the {fitted.primitive.kind}", told, parameters)]
    if recognition.extents:
        parts.append(_section("Extents", "", tables.extents_table(recognition.extents, unit)))
    yield element("div", *parts, class_="pair")
    for other in recognition.alternatives:
        yield from _alternative(other, fitted.primitive.kind, unit)
    if recognition.active_constraints:
        effects = recognition.active_constraints.items()
        rows = table((worded(name), effect) for name, effect in effects)
        yield _section("Constraints", "", rows)


def _alternative(other: Alternative, shown: str, unit: str) -> Iterator[Markup]:
    """Its parameters with their intervals, its error, what to beware of, and where it ends."""
    told = f"The points do not tell it from the {shown}, which the pictures show."
    known, kind = other.uncertainty, other.primitive.kind
    parts = [tables.parameters_table(other.primitive, known, unit), tables.distances_table(other.error, unit)]
    if known and known.warnings:
        items = (element("li", warning.message) for warning in known.warnings)
        parts.insert(0, element("ul", *items, class_="warnings"))
    sections = [_section(f"Or a {kind}", told, *parts)]
    if other.extents:
        sections.append(_section(f"Extents of the {kind}", "", tables.extents_table(other.extents, unit)))
    yield element("div", *sections, class_="pair")


def _no_fit_parts(fitted: Fitted, unit: str) -> Iterator[Markup]:
    yield _views(fitted, 0.0, unit)
    best = fitted.recognition.primitive
    if best is not None:
        told = "The best of what was tried. It does not explain the points, so it is not drawn."
        yield _section(f"Best try: a {best.kind}", told, tables.parameters_table(best, None, unit))


def _trail(fitted: Fitted) -> Iterator[Markup]:
    yield _section("What was tried", "", tables.attempts_table(fitted.recognition))
    yield _section("Receipt", "", tables.receipt_table(fitted))


def _section(title: str, told: str, *content: Markup) -> Markup:
    return element("section", element("h2", title), *([element("p", told)] if told else []), *content)


def _key_figures(fitted: Fitted, inliers: Deviations, unit: str) -> Markup:
    """Sizes, error and form error, large."""
    recognition, form = fitted.recognition, fitted.form
    known = recognition.uncertainty.intervals if recognition.uncertainty else {}
    figures = []
    for name in SIZES:
        if (value := getattr(fitted.primitive, name, None)) is not None:
            deviation = known[name].standard_deviation if name in known else None
            if is_angle(name):
                figures.append(("half-angle", f"{np.degrees(value):.6g}\u00b0"))
            else:
                figures.append((worded(name), f"{_at_most_eight(value, deviation)} {unit}"))
    figures.append(("rms of the inliers", f"{short(inliers.rms)} {unit}"))
    if not isinstance(form.minimum_zone, FailedFit):
        figures.append((f"{form.name}, minimum zone", f"{short(form.minimum_zone.form_error)} {unit}"))
    figures.append(("inliers", f"{inliers.n_points:,} of {len(fitted.points):,}"))
    pairs = (element("div", element("dt", name), element("dd", value)) for name, value in figures)
    return element("dl", *pairs)


def _at_most_eight(value: float, deviation: float | None) -> str:
    return min(known_to(value, deviation), f"{value:.8g}", key=len)


def _views(fitted: Fitted, limit: float, unit: str) -> Markup:
    n_points = len(fitted.points)
    told = (
        "All points"
        if n_points <= SHOWN_POINTS
        else f"{SHOWN_POINTS:,} of {n_points:,} points, drawn by chance,"
    )
    if fitted.recognition.status == "no_fit":
        told += " without a primitive: none explains them. z points up."
    elif fitted.recognition.extents is None:
        asked = "extents" in fitted.recognition.include
        why = "they do not say where it ends" if asked else "where it ends was not asked for"
        told += f" without the {fitted.primitive.kind}: {why}. z points up."
    else:
        kind = fitted.primitive.kind
        told += f" and the {kind}, trimmed to where they are. Its {DRAWINGS[kind].UPRIGHT} is upright."
    figures = element("div", views(Scene.of(fitted), limit, unit), class_="views")
    return _section("The points", told, figures)
