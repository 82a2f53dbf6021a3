"""What tools answer: short enough for the context of a model, in the names of the answer of `POST /fit`."""

from collections.abc import Mapping
from typing import Any, Literal

from pydantic import BaseModel, Field

from primfit.fitting.primitives import SIZES

Status = Literal["fitted", "ambiguous", "no_fit"]
Values = dict[str, Any]
LABEL_LENGTH = 80

_FIRST = ("status", "message", "warnings", "primitive", "error", "noise", "active_constraints", "conformance")
_KNOWN = ("intervals", "direction", "position", "warnings")
_TRIED = ("kind", "outcome", "reason", "probability", "evidence")


class Attempt(BaseModel):
    """A kind that was tried."""

    kind: str
    outcome: str = Field(description="accepted, refused or failed")
    reason: str
    probability: float | None = Field(description="that the classifier gave it")
    evidence: float | None = Field(description="logarithm: how likely it is compared with the best kind")


class Alternative(BaseModel):
    """Another kind that explains an ambiguous cloud about as well."""

    primitive: Values
    rms: float = Field(description="of the distances [unit of the points]")
    evidence: float | None


class Fit(BaseModel):
    """Which primitive a cloud is. Lengths are in the unit of the points, angles in radians."""

    status: Status
    message: str = Field(description="the status in a sentence")
    warnings: list[str]
    n_points: int
    unit: str | None = Field(description="of all lengths; null where it is not known")
    primitive: Values | None = Field(description="kind and parameters; of no_fit the best try")
    alternatives: list[Alternative] = Field(description="the other kinds of an ambiguous answer")
    extents: Values | None = Field(description="where the primitive ends, without outlines")
    uncertainty: Values | None = Field(description="95% intervals of the parameters, without the covariance")
    error: Values | None = Field(
        description="rms, mean, p95, max, zone (form error) and those of the inliers"
    )
    noise: Values | None
    active_constraints: dict[str, str]
    conformance: Values | None = Field(description="within the tolerances asked for, or not")
    attempts: list[Attempt]
    input_sha256: str = Field(description="of the points that were fitted")


class Row(BaseModel):
    """A segment; `problem` says why it has no answer."""

    label: int | str
    n_points: int
    status: Status | None = None
    kind: str | None = None
    sizes: dict[str, float] = Field({}, description="radius, major_radius, minor_radius, half_angle")
    rms: float | None = None
    inlier_share: float | None = None
    warnings: list[str] = []
    problem: str | None = None


class Segments(BaseModel):
    """A page of the segments of a scan, and how many there are of each sort."""

    n_segments: int
    counts: dict[str, int] = Field(
        description="segments by kind; those that are ambiguous, no_fit or problems"
    )
    unit: str | None
    offset: int
    rows: list[Row]
    next_offset: int | None = Field(description="to ask for the next page with; null after the last one")


class File(BaseModel):
    """A file that was written."""

    artifact: str
    path: str
    n_bytes: int
    warning: str | None = None


class Unwritten(BaseModel):
    """An artifact that could not be made."""

    artifact: str
    problem: str


class Export(BaseModel):
    """What was written of the trimmed primitive."""

    status: Status
    message: str
    primitive: Values | None
    files: list[File]
    problems: list[Unwritten]


class Explanation(BaseModel):
    """The figures behind the words and the picture."""

    status: Status
    message: str
    kind: str | None
    alternatives: list[str]
    warnings: list[str]
    attempts: list[Attempt]
    n_inliers: int | None
    n_outliers: int | None


class Ticket(BaseModel):
    """Where to send a file to."""

    ticket: str = Field(description="stands in place of a path in the other tools")
    url: str = Field(description="PUT the bytes of the file to it, once; it is a secret")
    command: str = Field(description="that does so; FILE is yours")
    max_bytes: int
    expires_in_seconds: float = Field(description="from the last use")


def fit_result(answer: Mapping[str, Any]) -> dict[str, Any]:
    """What `Fit` holds of an answer."""
    known, receipt = answer["uncertainty"], answer["receipt"]
    return {
        **{name: answer[name] for name in _FIRST},
        "n_points": receipt["n_points"],
        "unit": receipt["unit"],
        "alternatives": [_alternative(each) for each in answer["alternatives"]],
        "extents": _without_outlines(answer["extents"]),
        "uncertainty": known and {name: known[name] for name in _KNOWN},
        "attempts": attempts(answer),
        "input_sha256": receipt["input_sha256"],
    }


def attempts(answer: Mapping[str, Any]) -> list[dict[str, Any]]:
    """What `Attempt` holds of each kind that was tried."""
    return [{name: each[name] for name in _TRIED} for each in answer["attempts"]]


def row(label: int | str, answer: Mapping[str, Any]) -> dict[str, Any]:
    """What `Row` holds of the answer for a segment."""
    primitive, error = answer["primitive"] or {}, answer["error"] or {}
    return {
        "label": shown(label),
        "n_points": answer["receipt"]["n_points"],
        "status": answer["status"],
        "kind": primitive.get("kind"),
        "sizes": {name: primitive[name] for name in SIZES if name in primitive},
        "rms": error.get("rms"),
        "inlier_share": error.get("inlier_share"),
        "warnings": list(answer["warnings"]),
    }


def shown(label: int | str) -> int | str:
    """A label as an agent sees it: it is text from a file."""
    if isinstance(label, int):
        return label
    return "".join(letter if letter.isprintable() else "?" for letter in label[:LABEL_LENGTH])


def _alternative(given: Mapping[str, Any]) -> dict[str, Any]:
    rest = ("error", "extents", "uncertainty", "evidence")
    primitive = {name: value for name, value in given.items() if name not in rest}
    return {"primitive": primitive, "rms": given["error"]["rms"], "evidence": given["evidence"]}


def _without_outlines(extents: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """Numbers and directions: an outline has hundreds of points."""
    if extents is None:
        return None
    return {name: value for name, value in extents.items() if not _is_outline(value)}


def _is_outline(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], list)
