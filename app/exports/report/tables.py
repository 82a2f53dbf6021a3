"""What an answer says, as tables."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from primfit.fitting.answer.form import Form, Reference
from primfit.fitting.answer.residuals import Deviations
from primfit.fitting.answer.result import Recognition
from primfit.fitting.answer.values import Deviation, ErrorSummary
from primfit.fitting.errors import FailedFit
from primfit.fitting.extents.values import Extents
from primfit.fitting.plain import worded
from primfit.fitting.primitives import DIRECTIONS, is_angle, is_length, names_of, values_of
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.uncertainty.values import Uncertainty

from ...engine.answer import receipt, versions
from ..fitted import Fitted
from .markup import Markup, element, table
from .numbers import between, known_to, short


def cell(content: object) -> Markup:
    """A number in a column of numbers."""
    return element("td", content, class_="number")


def column(title: str) -> Markup:
    return element("th", title, class_="number", scope="col")


def parameters_table(primitive: Primitive, known: Uncertainty | None, unit: str) -> Markup:
    """Each number with its interval of 95 % where it is known."""
    rows: list[tuple[object, ...]] = []
    for name, value in zip(names_of(primitive.kind), values_of(primitive).tolist(), strict=True):
        deviation, told = _known(name, known)
        length = is_length(name)
        of = unit if length else "rad" if is_angle(name) else ""
        rows.append((worded(name), cell(known_to(value, deviation)), of, told))
        if is_angle(name):
            degrees = known_to(math.degrees(value), deviation and math.degrees(deviation))
            rows.append(("", cell(degrees), "degrees", ""))
    if known is None:
        return table((row[:-1] for row in rows), ("", column("value"), ""))
    return table(rows, ("", column("value"), "", "95 % interval"))


def _known(name: str, known: Uncertainty | None) -> tuple[float | None, str]:
    """The standard deviation of a number where it is known, and its interval in words."""
    interval = known.intervals.get(name) if known else None
    if interval is None:
        return _direction(name, known)
    if interval.method == "held":
        return interval.standard_deviation, "held by a constraint"
    return interval.standard_deviation, between(interval.low, interval.high, interval.standard_deviation)


def _direction(name: str, known: Uncertainty | None) -> tuple[float | None, str]:
    """The deviation of a component of a direction, and what is told beside the first."""
    first, _, component = name.partition(".")
    if first not in DIRECTIONS or known is None or known.direction is None:
        return None, ""
    told = (
        f"direction within {math.degrees(known.direction.radius_95):.3g} degrees" if component == "x" else ""
    )
    return known.direction.standard_deviations[0], told


def extents_table(extents: Extents, unit: str) -> Markup:
    """Where the primitive begins and ends; angles in degrees."""
    values = extents.values()
    size = math.sqrt(values["area"])
    rows = [row for name, value in values.items() for row in _extent(name, value, unit, size)]
    return table(rows, ("", column("value"), ""))


def _extent(name: str, value: Any, unit: str, size: float) -> Iterator[tuple[object, ...]]:
    """Rows for a field; places in six digits of the size, however far from the origin they are."""
    if name == "kind":
        return
    if isinstance(value, list):
        yield from _several(name, value, unit, size)
    elif isinstance(value, bool):
        yield worded(name), cell("yes" if value else "no"), ""
    elif name == "coverage":
        yield "of which near points", cell(f"{value:.0%}"), ""
    elif name.endswith("area"):
        yield worded(name), cell(short(value)), f"{unit}\u00b2"
    elif "angle" in name or name.endswith("span"):
        yield worded(name), cell(f"{math.degrees(value):.6g}"), "degrees"
    else:
        yield worded(name), cell(f"{value:.6g}"), unit


def _several(name: str, value: list[Any], unit: str, size: float) -> Iterator[tuple[object, ...]]:
    """Rows for a direction, a place, or an outline, of which there are many."""
    if name == "outline":
        yield "outline", cell(f"{len(value)} corners"), ""
    elif name == "concave_outline":
        pieces, holes = len(value), sum(len(rings) - 1 for rings in value)
        yield "concave outline", cell(f"pieces {pieces}, holes {holes}"), ""
    elif "direction" in name or name == "axis":
        yield worded(name), cell(", ".join(f"{number:.6g}" for number in value)), ""
    else:
        for axis, number in zip("xyz", value, strict=True):
            yield worded(f"{name}.{axis}"), cell(known_to(number, 1e-4 * size)), unit


def error_table(recognition: Recognition, unit: str) -> Markup:
    """Distances of all points, and what the noise is like."""
    error, noise = recognition.error, recognition.noise
    assert error and noise
    step = noise.quantisation_step
    return table(
        [
            *_distances(error, unit),
            ("noise, one standard deviation", cell(short(noise.scale)), unit),
            ("exact points", cell(f"{noise.exact_share:.1%}"), ""),
            ("outliers", cell(f"{noise.outlier_share:.1%}"), ""),
            ("coordinates in steps of", cell("-" if step is None else f"{step:g}"), unit if step else ""),
            ("deviation that neighbouring points share", *_deviation(noise.correlated, unit)),
            ("smooth deviation from the surface", *_deviation(noise.smooth, unit)),
        ]
    )


def distances_table(error: ErrorSummary, unit: str) -> Markup:
    """Distances of all points, and of the inliers."""
    return table(_distances(error, unit))


def _distances(error: ErrorSummary, unit: str) -> list[tuple[object, ...]]:
    return [
        ("rms of all points", cell(short(error.rms)), unit),
        ("mean distance", cell(short(error.mean)), unit),
        ("95 % of the distances below", cell(short(error.p95)), unit),
        ("largest distance", cell(short(error.max)), unit),
        ("mean over the diagonal", cell(short(error.relative_mean)), ""),
        ("inliers", cell(f"{error.inlier_share:.2%}"), ""),
        ("rms of the inliers", cell(short(error.inlier_rms)), unit),
    ]


def _deviation(found: Deviation | None, unit: str) -> tuple[Markup, str]:
    """Its size and the distance over which points share it."""
    if found is None:
        return cell("-"), ""
    return cell(f"{short(found.size)} over {short(found.range)}"), unit


def form_table(form: Form, unit: str) -> Markup:
    """The form error from either reference feature."""
    features = (("least squares", form.least_squares), ("minimum zone", form.minimum_zone))
    header = ("reference feature", *map(column, (f"{form.name} [{unit}]", "peak", "valley", "rms")))
    return table([(name, *_reference(found)) for name, found in features], header)


def _reference(found: Reference | FailedFit) -> tuple[object, ...]:
    if isinstance(found, FailedFit):
        return (element("td", found.reason, colspan=4),)
    strong = element("strong", short(found.form_error))
    return (cell(strong), *(cell(short(value)) for value in (found.peak, found.valley, found.rms)))


def percentiles_table(every: Deviations, inliers: Deviations, unit: str) -> Markup:
    """Signed residuals of all points and of the inliers."""
    rows: list[tuple[object, ...]] = [("points", cell(f"{every.n_points:,}"), cell(f"{inliers.n_points:,}"))]
    for name in ("mean", "mean_absolute", "rms", "min", "max"):
        rows.append((worded(name), *(cell(short(getattr(each, name))) for each in (every, inliers))))
    for percent in every.percentiles:
        title = "median" if percent == 50.0 else f"{percent:g} %"
        rows.append((title, *(cell(short(each.percentiles[percent])) for each in (every, inliers))))
    return table(rows, (f"signed [{unit}]", column("all points"), column("inliers")))


def attempts_table(recognition: Recognition) -> Markup:
    """Every kind that was tried."""
    rows = [
        (
            attempt.kind,
            cell("-" if attempt.probability is None else f"{attempt.probability:.3f}"),
            cell("-" if attempt.evidence is None else f"{attempt.evidence:z.1f}"),
            cell("-" if attempt.error is None else short(attempt.error.mean)),
            element("td", element("span", attempt.outcome, class_=attempt.outcome)),
            attempt.reason,
        )
        for attempt in recognition.attempts
    ]
    header = ("kind", *map(column, ("probability", "evidence", "mean error")), "outcome", "why")
    return table(rows, header)


def receipt_table(fitted: Fitted) -> Markup:
    """What was fitted and how; the options where they are known."""
    return table((name, element("code", value)) for name, value in _receipt(fitted))


def _receipt(fitted: Fitted) -> Iterator[tuple[str, str]]:
    of = receipt(fitted.given, fitted.options or {})
    yield "points", f"{of['n_points']:,}"
    yield "read from", f"{of['format']}: {' '.join(of['columns'])}"
    yield "SHA-256 of the points", of["input_sha256"]
    if of["weights_sha256"]:
        yield "SHA-256 of the weights", of["weights_sha256"]
    used: Mapping[str, Any] = of["versions"]
    if fitted.options is None:
        yield "options", "not known: the report was made from the answer alone"
        used = {name: version for name, version in versions("none").items() if name != "weights"}
    else:
        for name, value in of["options"].items():
            yield worded(name), _plain(value)
    for name, version in used.items():
        if version is not None:
            yield f"SHA-256 of the {name}" if name == "weights" else f"version of {name}", version


def _plain(value: Any) -> str:
    if value is None:
        return "-"
    return " ".join(value) if isinstance(value, list) else str(value)
