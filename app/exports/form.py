"""Form errors and what the residuals are like, as JSON."""

from dataclasses import asdict
from typing import Any

import orjson

from primfit.fitting.answer.form import Reference
from primfit.fitting.answer.residuals import Deviations
from primfit.fitting.errors import FailedFit
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives import parameters

from .fitted import Fitted
from .options import ExportOptions


def form_json(fitted: Fitted, options: ExportOptions) -> bytes:
    """One JSON object, indented."""
    return orjson.dumps(form_values(fitted), option=orjson.OPT_INDENT_2 | orjson.OPT_APPEND_NEWLINE)


def form_values(fitted: Fitted) -> dict[str, Any]:
    """Plain values: the residuals of all points and of the inliers, and the form error of the inliers."""
    distance, inlier = fitted.residuals.distance, fitted.residuals.inlier
    form = fitted.form
    return {
        "status": fitted.recognition.status,
        "kind": fitted.primitive.kind,
        "form": form.name,
        "n_inliers": form.n_points,
        "least_squares": _reference(form.least_squares),
        "minimum_zone": _reference(form.minimum_zone),
        "residuals": {"all": _deviations(distance), "inliers": _deviations(distance[inlier])},
    }


def _reference(found: Reference | FailedFit) -> dict[str, Any]:
    if isinstance(found, FailedFit):
        return {"failed": found.reason}
    return asdict(found) | {"primitive": parameters(found.primitive)}


def _deviations(distance: Array) -> dict[str, Any] | None:
    """Null where there are none: another cloud may lie far away."""
    if not len(distance):
        return None
    found = Deviations.of(distance)
    histogram = {"edges": found.histogram.edges.tolist(), "counts": found.histogram.counts.tolist()}
    percentiles = {f"{percent:g}": value for percent, value in found.percentiles.items()}
    return asdict(found) | {"percentiles": percentiles, "histogram": histogram}
