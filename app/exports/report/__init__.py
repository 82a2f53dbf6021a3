"""One HTML file about one answer, with its pictures in it: it needs nothing else, and no network."""

from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path

from primfit.fitting.answer.residuals import Deviations
from primfit.fitting.answer.result import Alternative
from primfit.fitting.plain import worded
from primfit.fitting.uncertainty.values import Uncertainty

from ..drawing import DRAWINGS
from ..fitted import Fitted, NothingToExportError
from ..options import ExportOptions
from . import tables
from .conformance import checks_table, in_words
from .headline import figures
from .histogram import histogram
from .markup import Markup, element, joined, table
from .ranges import color_reach
from .scene import SHOWN_POINTS, Scene, shape_in
from .svg import PICTURE_STYLE
from .unrolled import unrolled_map
from .views import lone_view, views

_STYLE = Path(__file__).with_name("style.css")
_UNKNOWN = {True: "This criterion gives no uncertainty.", False: "The uncertainty was not requested."}
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
    title = options.title or kind.capitalize()
    head = joined(
        [
            Markup('<meta charset="utf-8">'),
            Markup('<meta name="viewport" content="width=device-width, initial-scale=1">'),
            element("title", title),
            element("style", PICTURE_STYLE, Markup(_STYLE.read_text(encoding="utf-8"))),
        ]
    )
    parts = _fit_parts if recognition.status != "no_fit" else _no_fit_parts
    foot = element("footer", f"Made by primfit {version('primfit')}.")
    body = element("body", _header(fitted, options, title), *parts(fitted, options.unit), foot)
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>{body}</html>\n'.encode()


def scene_svg(fitted: Fitted, unit: str | None = None) -> str:
    """The isometric view of the points and the trimmed primitive as one SVG, which brings its own style.

    A notebook may show it, or a file hold it; under `no_fit` it shows the points alone. Raises
    `InvalidOptionError` where there are no points.
    """
    is_fit = fitted.recognition.status != "no_fit"
    return lone_view(Scene.of(fitted), _limit(fitted) if is_fit else 0.0, unit)


def _limit(fitted: Fitted) -> float:
    """The residual at which the colors end; 0 where all there is is rounding."""
    return color_reach(fitted.residuals, fitted.rounding)


def _header(fitted: Fitted, options: ExportOptions, title: str) -> Markup:
    """The title, what was given of the report, and the verdict in words."""
    status = fitted.recognition.status
    given = {
        "file": fitted.name,
        "date": options.date,
        "operator": options.operator,
        "points": f"{len(fitted.points):,}",
        "unit": _named(options.unit),
    }
    about = (
        element("div", element("dt", name), element("dd", value)) for name, value in given.items() if value
    )
    return element(
        "header",
        element("h1", title, element("small", _SAID[status], class_=status)),
        element("dl", *about, class_="about"),
        element("p", fitted.recognition.message),
    )


def _named(unit: str | None) -> str:
    return unit or "not given"


def _fit_parts(fitted: Fitted, unit: str | None) -> Iterator[Markup]:
    residuals, recognition = fitted.residuals, fitted.recognition
    inlying = residuals.distance[residuals.inlier]
    every, inliers = Deviations.of(residuals.distance), Deviations.of(inlying)
    limit = _limit(fitted)
    yield figures(fitted, inliers, unit)
    yield from _warnings(recognition.warnings, recognition.uncertainty)
    yield from _tolerances(fitted, unit)
    yield from _numbers(fitted, unit)
    yield _views(fitted, limit, unit)
    told = "Peak-to-valley deviation of the inliers from each reference. All parameters are refitted."
    yield _section("Form error", told, tables.form_table(fitted.form, fitted.rounding, unit))
    yield element("div", *_pictures(fitted, limit, unit), class_="pair plots")
    errors = _section("Error and noise", "", tables.error_table(recognition, fitted.rounding, unit))
    percentiles = tables.percentiles_table(every, inliers, fitted.rounding, unit)
    yield element("div", errors, _section("Percentiles", "", percentiles), class_="pair")
    for other in recognition.alternatives:
        yield _alternative(fitted, other, unit)
    yield _tried(fitted, unit)
    yield element("div", _receipt(fitted), class_="receipt")


def _warnings(about_points: Sequence[str], known: Uncertainty | None) -> Iterator[Markup]:
    """What to know of the points, and of the parameters."""
    told = [*about_points, *(warning.message for warning in (known.warnings if known else ()))]
    if told:
        yield element("ul", *(element("li", text) for text in told), class_="warnings")


def _tolerances(fitted: Fitted, unit: str | None) -> Iterator[Markup]:
    """What was asked for beside what was found, where anything was."""
    found = fitted.recognition.conformance
    if found is not None:
        rows = [checks_table(found.checks, unit)] if found.checks else []
        verdict = in_words(found, fitted.recognition.status, fitted.primitive.kind)
        yield _section("Tolerances", f"{verdict.capitalize()}.", *rows)


def _numbers(fitted: Fitted, unit: str | None) -> Iterator[Markup]:
    """The parameters with their intervals, where the primitive ends, and the constraints."""
    recognition = fitted.recognition
    told = "" if recognition.uncertainty else _UNKNOWN["uncertainty" in recognition.include]
    parameters = tables.parameters_table(fitted.primitive, recognition.uncertainty, fitted.size, unit)
    parts = [_section(f"Parameters of the {fitted.primitive.kind}", told, parameters)]
    if recognition.active_constraints:
        effects = recognition.active_constraints.items()
        rows = table((worded(name), effect) for name, effect in effects)
        parts.append(_section("Constraints", "", rows))
    beside = []
    if recognition.extents:
        beside = [_section("Extents", "", tables.extents_table(recognition.extents, fitted.size, unit))]
    yield element("div", element("div", *parts), *beside, class_="pair")


def _pictures(fitted: Fitted, limit: float, unit: str | None) -> Iterator[Markup]:
    """The map and the histogram; of residuals that are all rounding there is nothing to see."""
    residuals = fitted.residuals
    distance = residuals.distance[residuals.inlier]
    if limit == 0.0:
        told = "All inliers lie on the surface, to the rounding of their coordinates."
        yield _section("Residuals", told)
        return
    if shape_in(fitted) is not None:
        are_few = len(distance) <= SHOWN_POINTS
        what = "Of each inlier" if are_few else "Mean of the inliers in each cell; gray cells hold none"
        figure = element("figure", unrolled_map(fitted, limit, unit))
        yield _section("Residuals on the unrolled surface", f"{what}.", figure)
    told = f"Signed distances of the inliers, positive {DRAWINGS[fitted.primitive.kind].POSITIVE}."
    yield _section("Residuals", told, element("figure", histogram(distance, limit, unit)))


def _alternative(fitted: Fitted, other: Alternative, unit: str | None) -> Markup:
    """Its parameters with their intervals, its error, what to beware of, and where it ends."""
    known, kind = other.uncertainty, other.primitive.kind
    told = f"It explains the points as well as the {fitted.primitive.kind}, which the pictures show."
    parameters = tables.parameters_table(other.primitive, known, fitted.size, unit)
    distances = tables.distances_table(other.error, fitted.rounding, unit)
    parts = [_section(f"Alternative: {kind}", told, *_warnings((), known), parameters, distances)]
    if other.extents:
        parts.append(
            _section(f"Extents of the {kind}", "", tables.extents_table(other.extents, fitted.size, unit))
        )
    return element("div", *parts, class_="pair")


def _no_fit_parts(fitted: Fitted, unit: str | None) -> Iterator[Markup]:
    yield from _warnings(fitted.recognition.warnings, None)
    yield from _tolerances(fitted, unit)
    yield _views(fitted, 0.0, unit)
    yield _tried(fitted, unit)
    best, parts = fitted.recognition.primitive, [_receipt(fitted)]
    if best is not None:
        told = "The best attempt. It does not explain the points, so the pictures do not show it."
        rows = tables.parameters_table(best, None, fitted.size, unit)
        parts.insert(0, _section(f"Best try: {best.kind}", told, rows))
    yield element("div", *parts, class_="pair")


def _tried(fitted: Fitted, unit: str | None) -> Markup:
    return _section("Kinds tried", "", tables.attempts_table(fitted.recognition, fitted.rounding, unit))


def _receipt(fitted: Fitted) -> Markup:
    return _section("Receipt", "", tables.receipt_table(fitted))


def _section(title: str, told: str, *content: Markup) -> Markup:
    return element("section", element("h2", title), *([element("p", told)] if told else []), *content)


def _views(fitted: Fitted, limit: float, unit: str | None) -> Markup:
    n_points, recognition = len(fitted.points), fitted.recognition
    drawn = (
        "All points"
        if n_points <= SHOWN_POINTS
        else f"Random sample of {SHOWN_POINTS:,} of {n_points:,} points"
    )
    if recognition.status == "no_fit":
        told = f"{drawn}. No primitive explains them. The z axis points up."
    elif recognition.extents is None:
        asked = "extents" in recognition.include
        why = "the points span no surface" if asked else "extents were not requested"
        told = f"{drawn}. The {fitted.primitive.kind} is not drawn: {why}. The z axis points up."
    else:
        kind = fitted.primitive.kind
        told = f"{drawn} and the {kind} within its extents. Its {DRAWINGS[kind].UPRIGHT} points up."
    pictures = element("div", views(Scene.of(fitted), limit, unit), class_="views")
    return _section("The points", told, pictures)
