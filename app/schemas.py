"""The wire: options, requests and answers as the OpenAPI document shows them.

Points are not validated here: a model of 200,000 rows is slow and repeats the input in its errors. The
readers check them; these models describe them.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, WithJsonSchema
from typing_extensions import TypeAliasType

from fitting.config import Criterion
from fitting.uncertainty import Method, NoiseModelName
from fitting.warnings import WarningCode

KindName = TypeAliasType("KindName", Literal["plane", "sphere", "cylinder", "cone", "torus"])
ClassifierName = TypeAliasType("ClassifierName", Literal["network", "knn", "none"])
CriterionName = TypeAliasType("CriterionName", Criterion)

Vector = Annotated[
    list[float], Field(min_length=3, max_length=3, description="[x, y, z]", examples=[[0.0, 0.0, 1.0]])
]
_CLOSED = ConfigDict(extra="forbid")
Upload = Annotated[bytes, WithJsonSchema({"type": "string", "format": "binary"})]


class Plane(BaseModel):
    """A plane; `point` is the one closest to the centroid of the cloud."""

    model_config = _CLOSED

    kind: Literal["plane"]
    normal: Vector
    point: Vector


class Sphere(BaseModel):
    """A sphere."""

    model_config = _CLOSED

    kind: Literal["sphere"]
    center: Vector
    radius: float


class Cylinder(BaseModel):
    """An endless circular cylinder; `point` is the point of the axis closest to the centroid."""

    model_config = _CLOSED

    kind: Literal["cylinder"]
    axis: Vector
    point: Vector
    radius: float


class Cone(BaseModel):
    """A circular cone; the axis points from the apex into the nappe that holds the points."""

    model_config = _CLOSED

    kind: Literal["cone"]
    apex: Vector
    axis: Vector
    half_angle: float = Field(description="radians, between 0 and pi/2")


class Torus(BaseModel):
    """A circular torus."""

    model_config = _CLOSED

    kind: Literal["torus"]
    center: Vector
    axis: Vector
    major_radius: float
    minor_radius: float


Primitive = Annotated[Plane | Sphere | Cylinder | Cone | Torus, Field(discriminator="kind")]


class NumberConstraint(BaseModel):
    """A number that is fixed by `value`, or bounded by `min`, `max` or both."""

    model_config = _CLOSED

    value: float | None = Field(None, gt=0)
    min: float | None = Field(None, gt=0)
    max: float | None = Field(None, gt=0)


class DirectionConstraint(BaseModel):
    """An axis or a normal along a direction up to sign, or within `max_angle` radians of it."""

    model_config = _CLOSED

    direction: Vector
    max_angle: float = Field(0.0, ge=0, lt=1.5707963267948966)


class Constraints(BaseModel):
    """What is known of the primitive, in the unit of the input and in radians.

    Each acts on the kinds that have a parameter of its name, and leaves the others free.
    """

    model_config = _CLOSED

    radius: NumberConstraint | None = Field(None, description="of a sphere or cylinder")
    major_radius: NumberConstraint | None = Field(None, description="of a torus")
    minor_radius: NumberConstraint | None = Field(None, description="of a torus")
    half_angle: NumberConstraint | None = Field(None, description="of a cone")
    axis: DirectionConstraint | None = Field(None, description="of a cylinder, cone or torus")
    normal: DirectionConstraint | None = Field(None, description="of a plane")
    center: Vector | None = Field(None, description="of a sphere or torus")
    apex: Vector | None = Field(None, description="of a cone")
    point: Vector | None = Field(None, description="that a plane, or the axis of a cylinder, passes through")


class FitOptions(BaseModel):
    """What may be asked of a fit."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    kinds: list[KindName] = Field(
        default=["plane", "sphere", "cylinder", "cone", "torus"],
        min_length=1,
        max_length=5,
        description="kinds that may be answered; all of them by default",
        json_schema_extra={"uniqueItems": True},
    )
    classifier: ClassifierName = Field(
        "network",
        description="who ranks the kinds: `network` (the default) or `knn`; `none` tries all and selects",
    )
    criterion: CriterionName = Field(
        "robust",
        description="what the parameters minimise: `robust` (the default) rejects outliers; `least_squares` "
        "counts every point alike; `huber` and `tukey` are M-estimators; `minimum_zone` makes the largest "
        "distance small; `minimum_circumscribed` and `maximum_inscribed`, of spheres and cylinders only, "
        "have all points inside or outside. The kind is judged by its robust fit",
    )
    max_error: float | None = Field(
        None,
        gt=0,
        le=1,
        description="largest accepted mean distance of the points not rejected as outliers, as a share of "
        "the bounding-box diagonal; by default it follows from the noise of the cloud",
    )
    seed: int = Field(0, ge=0, le=2**63 - 1, description="seed of every random choice, 0 by default")
    constraints: Constraints | None = Field(
        None, description="parameters that are fixed or bounded; in JSON only, not in a query"
    )
    initial_guess: Primitive | None = Field(
        None,
        description="a primitive that joins the starts of its kind; in JSON only, not in a query",
    )


class FitRequest(BaseModel):
    """A cloud in JSON."""

    points: list[Vector] = Field(description="points [x, y, z], finite numbers in any unit of length")
    weights: list[float] | None = Field(
        None,
        description="one a point, not negative: how much it counts in the last refinement; 0 leaves it out",
    )
    standard_deviations: list[float] | None = Field(
        None, description="of the noise of each point, in the unit of the points; in place of weights"
    )
    options: FitOptions | None = None


class FitUpload(BaseModel):
    """A cloud as a file: CSV, XYZ, TXT, NPY, PLY or JSON, recognised by content."""

    file: Upload = Field(description="the file")
    options: FitOptions | None = Field(None, description="options as JSON text")


class ErrorSummary(BaseModel):
    """Orthogonal distances of all points to the primitive, in the unit of the input."""

    rms: float
    mean: float
    p95: float
    max: float
    zone: float = Field(description="largest less smallest signed distance: the form error")
    relative_mean: float = Field(description="mean over the diagonal of the bounding box")
    inlier_share: float = Field(description="share of the points not rejected as outliers")


class NoiseSummary(BaseModel):
    """How the points scatter about the primitive: some exactly on it, most with noise, some anywhere."""

    scale: float = Field(description="standard deviation of the noise, in the unit of the input")
    exact_share: float = Field(description="share of the points that lie on the surface to the last digits")
    outlier_share: float = Field(description="share of the points that do not belong to the surface")
    quantisation_step: float | None = Field(
        description="decimal step that all coordinates are multiples of; null if there is none"
    )


class Interval(BaseModel):
    """A 95 % interval of one number, in the unit of the input or in radians."""

    low: float | None = Field(description="null where the points do not bound it")
    high: float | None = Field(description="null where the points do not bound it")
    standard_deviation: float = Field(description="by linearisation")
    method: Method = Field(
        description="`linear`: symmetric; `profile`: how far a size may go, the others following, before the "
        "points object; `held`: by constraints; `bound`: from an active bound to where the points would go"
    )


class Spread(BaseModel):
    """How far off a direction (radians) or a position (length) may be."""

    radius_95: float = Field(description="in 95 of 100 cases at most so far")
    standard_deviations: list[float] = Field(
        min_length=1, max_length=2, description="in its principal directions, the larger first"
    )


class CorrelatedNoise(BaseModel):
    """Noise whose correlation at distance h is `share` times exp(-(h / length)^power)."""

    length: float
    share: float = Field(description="of the variance; the rest is each point's own")
    power: Literal[1, 2]
    effective_points: float = Field(description="points with independent noise that would tell as much")


class UncertaintyWarning(BaseModel):
    """One thing to beware of."""

    code: WarningCode
    message: str


class Uncertainty(BaseModel):
    """How well the numbers of the primitive are known, in the unit of the input and in radians."""

    noise_model: NoiseModelName = Field(
        description="`exact`: the rounding of the coordinates is all there is; `independent` or `correlated` "
        "between neighbours; `unknown`: no points are left to estimate it from"
    )
    correlation: CorrelatedNoise | None
    parameters: list[str] = Field(
        description="names of the numbers, vectors by component",
        examples=[["axis.x", "axis.y", "axis.z", "point.x", "point.y", "point.z", "radius"]],
    )
    covariance: list[list[float]] | None = Field(
        description="of `parameters`; singular, as a direction has length 1 and a `point` is the one closest "
        "to the centroid. Null where the noise is unknown"
    )
    intervals: dict[str, Interval] = Field(description="by name; `direction` stands for an axis or normal")
    direction: Spread | None = Field(description="of the axis or normal")
    position: Spread | None = Field(
        description="of the axis of a cylinder, or of a plane, across it at its `point`"
    )
    warnings: list[UncertaintyWarning]


class Attempt(BaseModel):
    """One kind that was tried."""

    kind: KindName
    probability: float | None = Field(description="what the classifier gave it")
    outcome: Literal["accepted", "refused", "failed"]
    reason: str
    primitive: Primitive | None
    error: ErrorSummary | None
    noise: NoiseSummary | None


class UsedOptions(BaseModel):
    """The options as used, defaults filled in."""

    kinds: list[KindName]
    classifier: ClassifierName
    criterion: CriterionName
    max_error: float | None
    seed: int
    constraints: Constraints | None
    initial_guess: Primitive | None


class Versions(BaseModel):
    """Versions that decide the numbers."""

    primfit: str
    weights: str | None = Field(description="SHA-256 of the classifier's weights")
    numpy: str
    scipy: str


class Receipt(BaseModel):
    """What was fitted and how: enough to repeat it."""

    input_sha256: str = Field(description="of the points as little-endian float64, row by row")
    weights_sha256: str | None = Field(
        description="of the weights or standard deviations as little-endian float64, if there were any"
    )
    n_points: int
    format: str = Field(description="json, text, npy or ply")
    columns: list[str] = Field(description="columns used, by their name in the file")
    options: UsedOptions
    versions: Versions


class FitAnswer(BaseModel):
    """Which primitive the cloud is, and the evidence."""

    status: Literal["fitted", "ambiguous", "no_fit"] = Field(
        description="`ambiguous`: `alternatives` explain it as well; `no_fit`: nothing is good enough"
    )
    primitive: Primitive | None
    alternatives: list[Primitive]
    message: str
    extents: dict[str, Any] | None = Field(description="null in this version")
    uncertainty: Uncertainty | None = Field(
        description="how well `primitive` is known; null with `no_fit`, and with `minimum_zone`, "
        "`minimum_circumscribed` and `maximum_inscribed`"
    )
    error: ErrorSummary | None
    noise: NoiseSummary | None
    active_constraints: dict[str, str] = Field(
        description="how each constraint that acts on the kind of `primitive` acts on it, by its name",
        examples=[{"radius": "at its upper bound 5.0", "axis": "fixed"}],
    )
    attempts: list[Attempt] = Field(description="every kind that was tried, in order")
    receipt: Receipt


class Live(BaseModel):
    """The process answers."""

    status: Literal["alive"]


class Ready(BaseModel):
    """Workers are warm and the weights are loaded."""

    status: Literal["ready"]
    workers: int


class ProblemField(BaseModel):
    """One bad field."""

    field: str = Field(examples=["points[17][2]"])
    message: str
    value: str | None = Field(None, description="class of the value found, never the value")


class Problem(BaseModel):
    """A problem document (RFC 9457)."""

    type: str
    title: str
    status: int
    detail: str
    instance: str
    errors: list[ProblemField] = Field(max_length=20)
