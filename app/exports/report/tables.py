"""What an answer says, as tables."""

import math
from collections.abc import Iterable, Iterator, Mapping
from json import dumps
from typing import Any

from primfit.fitting.answer.form import Form, Reference
from primfit.fitting.answer.residuals import Deviations
from primfit.fitting.answer.result import Recognition
from primfit.fitting.answer.values import Deviation, ErrorSummary
from primfit.fitting.errors import FailedFit
from primfit.fitting.extents.values import Extents
from primfit.fitting.plain import worded
from primfit.fitting.primitives import direction_of, is_angle, is_length, names_of, values_of
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.uncertainty.values import Uncertainty

from ...engine.answer import receipt, versions
from ..fitted import Fitted
from .markup import Markup, element, table
from .numbers import KNOWN, Unit, count, length, measured, plus_minus, rounded, said, short
from .numbers import column as in_column
from .ranges import above

UNKNOWN = 45.0
"""Degrees from which a direction is not determined."""


def cell(content: object) -> Markup:
    """A number in a column of numbers."""
    return element("td", content, class_="number")


def column(title: str) -> Markup:
    return element("th", title, class_="number", scope="col")


def parameters_table(
    primitive: Primitive, known: Uncertainty | None, size: float, unit: str | None
) -> Markup:
    """Each number with its interval of 95% where it is known; `size` is that of the cloud."""
    rows: list[tuple[object, ...]] = []
    for name, value in zip(names_of(primitive.kind), values_of(primitive).tolist(), strict=True):
        rows += _parameter(name, value, known, size, unit)
    if known is not None and known.position is not None:
        of = Unit.of(known.position.radius_95, unit)
        of_what = "axis" if direction_of(primitive.kind) == "axis" else primitive.kind
        rows.append((f"{of_what} position", cell(""), plus_minus(of.two(known.position.radius_95)), of.name))
    if known is None:
        return table(((name, value, of) for name, value, _, of in rows), ("", column("value"), ""))
    return table(rows, ("", column("value"), "95% interval", ""))


def _parameter(
    name: str, value: float, known: Uncertainty | None, size: float, unit: str | None
) -> Iterator[tuple[object, ...]]:
    """Its name, its value, its interval and its unit; an angle in degrees and in radians."""
    interval = known.intervals.get(name) if known else None
    if is_length(name):
        # Coordinates of a point in one unit, that of the cloud.
        of = Unit.of(size if "." in name else value, unit)
        found, within = measured(value, interval, size, of.factor)
        yield worded(name), cell(found), within, of.name
    elif is_angle(name):
        for title, of_angle, factor in ((worded(name), "\u00b0", math.degrees(1.0)), ("", "rad", 1.0)):
            found, within = measured(value, interval, 1.0, factor)
            yield title, cell(found), within, of_angle
    else:
        deviation, within = _direction(name, known)
        yield worded(name), cell(rounded(value, max(deviation, KNOWN))), within, ""


def _direction(name: str, known: Uncertainty | None) -> tuple[float, str]:
    """How well a component of a direction is known, and what is told beside the first."""
    if known is None or known.direction is None:
        return 0.0, ""
    degrees = math.degrees(known.direction.radius_95)
    told = plus_minus(f"{rounded(degrees, degrees)}\u00b0") if degrees < UNKNOWN else "not determined"
    told = told if degrees > KNOWN else plus_minus("rounding")
    return known.direction.standard_deviations[0], told if name.endswith(".x") else ""


def extents_table(extents: Extents, size: float, unit: str | None) -> Markup:
    """Where the primitive begins and ends; angles in degrees. `size` is that of the cloud."""
    rows = [row for name, value in extents.values().items() for row in _extent(name, value, unit, size)]
    return table(rows)


def _extent(name: str, value: Any, unit: str | None, size: float) -> Iterator[tuple[object, ...]]:
    """Rows for a field; places in six digits of the size, however far from the origin they are."""
    if name == "kind":
        return
    if isinstance(value, list):
        yield _several(name, value, unit, size)
    elif isinstance(value, bool):
        yield worded(name), cell("yes" if value else "no"), ""
    elif name == "coverage":
        yield "coverage", cell(f"{value:.0%}"), ""
    elif name.endswith("area"):
        of = Unit.of(math.sqrt(value), unit)
        yield worded(name), cell(short(value * of.factor**2)), f"{of.name}\u00b2" if of.name else ""
    elif "angle" in name or name.endswith("span"):
        yield worded(name), cell(f"{math.degrees(value):.6g}"), "\u00b0"
    else:
        of = Unit.of(value, unit)
        yield worded(name), cell(f"{value * of.factor:.6g}"), of.name


def _several(name: str, value: list[Any], unit: str | None, size: float) -> tuple[object, ...]:
    """A row for a direction, a place, or an outline, of which there are many."""
    if name == "outline":
        return "outline", cell(f"{len(value)} corners"), ""
    if name == "concave_outline":
        holes = sum(len(rings) - 1 for rings in value)
        return "concave outline", cell(f"{count(len(value), 'piece')}, {count(holes, 'hole')}"), ""
    if "direction" in name or name == "axis":
        return worded(name), _vector([rounded(number, 1e-4) for number in value]), ""
    of = Unit.of(size, unit)
    known = 1e-4 * size * of.factor
    return worded(name), _vector([rounded(number * of.factor, known) for number in value]), of.name


def _vector(numbers: list[str]) -> Markup:
    """Three numbers in one cell, each of which stays in one line."""
    parts = [element("span", number + ("," if i < 2 else "")) for i, number in enumerate(numbers)]
    return element("td", *parts, class_="number vector")


def error_table(recognition: Recognition, least: float, unit: str | None) -> Markup:
    """Distances of all points, and what the noise is like; deviations up to the least one are none."""
    error, noise = recognition.error, recognition.noise
    assert error and noise
    rows: list[tuple[object, ...]] = [
        *_distances(error, least, unit),
        ("noise (std. dev.)", *_cells(length(above(noise.scale, least), unit))),
        ("exactly on the surface", cell(f"{noise.exact_share:.1%}"), ""),
        ("outliers", cell(f"{noise.outlier_share:.1%}"), ""),
    ]
    if noise.quantisation_step is not None:
        of = Unit.of(noise.quantisation_step, unit)
        rows.append(("coordinate step", cell(f"{noise.quantisation_step * of.factor:g}"), of.name))
    shared = (("shared by neighbors", noise.correlated), ("smooth deviation", noise.smooth))
    rows += [(name, *_deviation(found, unit)) for name, found in shared if found and found.size > least]
    return table(rows)


def distances_table(error: ErrorSummary, least: float, unit: str | None) -> Markup:
    """Distances of all points, and of the inliers."""
    return table(_distances(error, least, unit))


def _distances(error: ErrorSummary, least: float, unit: str | None) -> list[tuple[object, ...]]:
    relative = error.relative_mean if error.mean > least else 0.0
    return [
        ("rms of inliers", *_cells(length(above(error.inlier_rms, least), unit))),
        ("rms of all points", *_cells(length(above(error.rms, least), unit))),
        ("mean distance", *_cells(length(above(error.mean, least), unit))),
        ("95th percentile", *_cells(length(above(error.p95, least), unit))),
        ("largest distance", *_cells(length(above(error.max, least), unit))),
        ("mean / box diagonal", cell(short(relative)), ""),
        ("inliers", cell(f"{error.inlier_share:.2%}"), ""),
    ]


def _cells(found: tuple[str, str]) -> tuple[Markup, str]:
    return cell(found[0]), found[1]


def _deviation(found: Deviation, unit: str | None) -> tuple[Markup, str]:
    """Its size and the distance over which points share it."""
    shown = f"{said(found.size, unit)} over {said(found.range, unit)}"
    return element("td", shown, class_="number vector"), ""


def form_table(form: Form, least: float, unit: str | None) -> Markup:
    """The form error from either reference feature; values up to the least one are 0."""
    features = (("least squares", form.least_squares), ("minimum zone", form.minimum_zone))
    errors = [found.form_error for _, found in features if not isinstance(found, FailedFit)]
    of = Unit.of(max(errors, default=0.0), unit)
    header = ("", *map(column, (form.name + of.bracketed, "peak", "valley", "rms")))
    return table([(name, *_reference(found, least, of)) for name, found in features], header)


def _reference(found: Reference | FailedFit, least: float, unit: Unit) -> tuple[object, ...]:
    if isinstance(found, FailedFit):
        return (element("td", found.reason, colspan=4),)
    values = (found.form_error, found.peak, found.valley, found.rms)
    whole, *parts = (unit.short(above(value, least)) for value in values)
    return (cell(element("strong", whole)), *map(cell, parts))


def percentiles_table(every: Deviations, inliers: Deviations, least: float, unit: str | None) -> Markup:
    """Signed residuals of all points and of the inliers, in the unit that suits the inliers.

    Those that are no more than the least one are 0.
    """
    of = Unit.of(inliers.rms, unit)

    def row(title: str, values: Iterable[float]) -> tuple[object, ...]:
        return title, *(
            cell(in_column(above(value, least) * of.factor, inliers.rms * of.factor)) for value in values
        )

    rows = []
    for name in ("mean", "mean_absolute", "rms", "min", "max"):
        rows.append(row(worded(name), (getattr(each, name) for each in (every, inliers))))
    for percent in every.percentiles:
        title = "median" if percent == 50.0 else f"{percent:g}%"
        rows.append(row(title, (each.percentiles[percent] for each in (every, inliers))))
    return table(rows, (f"signed{of.bracketed}", column("all points"), column("inliers")))


def attempts_table(recognition: Recognition, least: float, unit: str | None) -> Markup:
    """Every kind that was tried."""
    rows = [
        (
            attempt.kind,
            cell("-" if attempt.probability is None else f"{attempt.probability:.3f}"),
            cell("-" if attempt.evidence is None else f"{attempt.evidence:z.1f}"),
            cell("-" if attempt.error is None else said(above(attempt.error.mean, least), unit)),
            element("td", element("span", attempt.outcome, class_=attempt.outcome)),
            element("td", attempt.reason, class_="reason"),
        )
        for attempt in recognition.attempts
    ]
    header = ("kind", *map(column, ("probability", "evidence", "mean error")), "outcome", "reason")
    return element("div", table(rows, header), class_="tried")


def receipt_table(fitted: Fitted) -> Markup:
    """What was fitted and how; the options where they are known."""
    return table((name, element("code", value)) for name, value in _receipt(fitted))


def _receipt(fitted: Fitted) -> Iterator[tuple[str, str]]:
    of = receipt(fitted.given, fitted.options or {})
    yield "format and columns", f"{of['format']}: {' '.join(of['columns'])}"
    yield "SHA-256 of the points", of["input_sha256"]
    if of["weights_sha256"]:
        yield "SHA-256 of the weights", of["weights_sha256"]
    used: Mapping[str, Any] = of["versions"]
    if fitted.options is None:
        yield "options", "not known: the report was made without them"
        used = {name: version for name, version in versions("none").items() if name != "weights"}
    else:
        yield from _options(of["options"])
    if used.get("weights") is not None:
        yield "SHA-256 of the classifier", used["weights"]
    yield "versions", ", ".join(f"{name} {of_it}" for name, of_it in used.items() if name != "weights")


def _options(options: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """The options as used; those without a value in one row."""
    yield from ((worded(name), _plain(value)) for name, value in options.items() if value is not None)
    if without := [worded(name) for name, value in options.items() if value is None]:
        yield "not given", ", ".join(without)


def _plain(value: Any) -> str:
    return " ".join(value) if isinstance(value, list) else value if isinstance(value, str) else dumps(value)
