"""The wire: options, requests and answers as the OpenAPI document shows them.

Points are not validated here: a model of 200,000 rows is slow and repeats the input in its errors. The
readers check them; these models describe them.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, WithJsonSchema
from typing_extensions import TypeAliasType

from primfit.fitting.names import Criterion
from primfit.fitting.request.values import LARGEST
from primfit.fitting.uncertainty.values import Method, NoiseModelName
from primfit.fitting.uncertainty.warnings import WarningCode

from ..readers.encoded import DtypeName

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


class Bounds(BaseModel):
    """What the extents of all kinds have in common."""

    model_config = _CLOSED

    area: float = Field(description="of the trimmed surface")
    coverage: float = Field(description="share of that area near which there are points")


class Arc(BaseModel):
    """An arc about the axis."""

    reference_direction: Vector = Field(
        description="unit vector across the axis at which angles are 0; they grow towards axis x this"
    )
    start_angle: float = Field(description="where the arc begins, radians in [0, 2 pi)")
    span: float = Field(description="radians from there on, up to 2 pi")
    full_turn: bool


class PlaneExtents(Bounds):
    """The outlines of the points on a plane, and the rectangle of least area about them.

    `area` and `coverage` are those of the convex outline.
    """

    kind: Literal["plane"]
    outline: list[Vector] = Field(
        description="corners of the convex outline, counter-clockwise about the normal"
    )
    concave_outline: list[list[list[Vector]]] = Field(
        description="the pieces that points fill, the largest first; of each the outer ring, "
        "counter-clockwise about the normal, then the rings of its holes, clockwise; at most 1000 corners. "
        "The convex outline where the points fill that"
    )
    concave_area: float = Field(description="inside the concave outline, without the holes")
    center: Vector = Field(description="of the rectangle")
    length: float
    width: float = Field(description="the shorter side")
    length_direction: Vector
    width_direction: Vector


class SphereExtents(Bounds):
    """The smallest cap about the points on a sphere; of a zone without a smaller one about its pole."""

    kind: Literal["sphere"]
    axis: Vector = Field(description="from the centre to the middle of the cap; z of a full sphere")
    half_angle: float = Field(description="between axis and rim, seen from the centre, radians, up to pi")
    start_half_angle: float = Field(description="of a zone, between axis and inner rim, radians; 0 of a cap")
    full_sphere: bool
    height: float = Field(description="of the cap or zone along its axis")
    rim_center: Vector
    rim_radius: float
    start_rim_center: Vector = Field(description="of the circle where a zone begins; the pole of a cap")
    start_rim_radius: float


class CylinderExtents(Bounds, Arc):
    """The piece of a cylinder between two heights and two angles."""

    kind: Literal["cylinder"]
    start: Vector = Field(description="end point of the axis")
    end: Vector
    length: float


class ConeExtents(Bounds, Arc):
    """The piece of a cone between two heights from the apex and two angles."""

    kind: Literal["cone"]
    start_height: float = Field(description="along the axis from the apex to the nearer end")
    end_height: float
    start_radius: float
    end_radius: float
    start: Vector = Field(description="centre of the nearer end, on the axis")
    end: Vector
    apex_inside: bool = Field(description="the surface reaches the apex; the start is the apex then")


class TorusExtents(Bounds, Arc):
    """The piece of a torus between two angles about the axis and two around the tube."""

    kind: Literal["torus"]
    tube_start_angle: float = Field(
        description="radians; 0 where the tube is farthest from the axis, growing to where the axis points"
    )
    tube_span: float
    tube_full_turn: bool


Extents = Annotated[
    PlaneExtents | SphereExtents | CylinderExtents | ConeExtents | TorusExtents, Field(discriminator="kind")
]


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
    tolerance: float | None = Field(
        None,
        gt=0,
        le=LARGEST,
        description="what counts as no deviation, in the unit of the points: kinds that agree within it over "
        "the cloud are equal, and the simplest is answered; a smooth deviation within it never leads to "
        "`no_fit`. By default none",
    )
    seed: int = Field(0, ge=0, le=2**63 - 1, description="seed of every random choice, 0 by default")
    constraints: Constraints | None = Field(
        None, description="parameters that are fixed or bounded; in JSON only, not in a query"
    )
    initial_guess: Primitive | None = Field(
        None,
        description="a primitive that joins the starts of its kind; in JSON only, not in a query",
    )


class EncodedArray(BaseModel):
    """An array as its bytes, little-endian and row by row: smaller and quicker than numbers in text."""

    model_config = _CLOSED

    dtype: DtypeName
    shape: list[int] = Field(
        min_length=1, max_length=2, description="[N, 3] of vectors, [N] of numbers", examples=[[3000, 3]]
    )
    base64: str = Field(
        description="RFC 4648, section 4: padded, without line breaks",
        json_schema_extra={"contentEncoding": "base64"},
    )


class FitRequest(BaseModel):
    """A cloud in JSON; arrays in base64 do not count towards the limit of points in JSON."""

    points: Annotated[list[Vector], Field(min_length=3)] | EncodedArray = Field(
        description="points [x, y, z], finite numbers in any unit of length"
    )
    normals: list[Vector] | EncodedArray | None = Field(
        None, description="one a point, of any length and sign, not zero; by default they are estimated"
    )
    labels: list[int] | list[str] | EncodedArray | None = Field(
        None,
        description="one a point, integers or strings: its segment; a fit does not use them",
    )
    weights: list[Annotated[float, Field(ge=0)]] | EncodedArray | None = Field(
        None,
        description="one a point, not negative: how much it counts in the last refinement; 0 leaves it out",
    )
    standard_deviations: list[Annotated[float, Field(gt=0)]] | EncodedArray | None = Field(
        None, description="of the noise of each point, in the unit of the points; in place of weights"
    )
    options: FitOptions | None = None


class FitUpload(BaseModel):
    """A cloud as a file of any format that is read, also packed by gzip or zstd, recognised by content."""

    file: Upload = Field(description="the file")
    options: FitOptions | None = Field(None, description="options as JSON text")


class BatchUpload(BaseModel):
    """Clouds as files of any format that is read."""

    file: list[Upload] = Field(min_length=1, description="the files, a part `file` each")
    options: FitOptions | None = Field(None, description="options of all of them as JSON text")
    labels: str | None = Field(
        None,
        description="the column of labels by which a file is cut into its segments; by default one of the "
        "usual names, where there is one; empty cuts none",
    )


class ErrorSummary(BaseModel):
    """Orthogonal distances of all points to the primitive, in the unit of the input."""

    rms: float
    mean: float
    p95: float
    max: float
    zone: float = Field(description="largest less smallest signed distance: the form error")
    relative_mean: float = Field(description="mean over the diagonal of the bounding box")
    inlier_rms: float = Field(description="rms of the points not rejected as outliers")
    inlier_share: float = Field(description="share of the points not rejected as outliers")


class Deviation(BaseModel):
    """A deviation that neighbouring points share, in the unit of the input."""

    size: float = Field(description="rms of the deviation")
    range: float = Field(description="distance over which points share it")


class NoiseSummary(BaseModel):
    """How the points scatter about the primitive: some exactly on it, most with noise, some anywhere."""

    scale: float = Field(description="standard deviation of the noise, in the unit of the input")
    exact_share: float = Field(description="share of the points that lie on the surface to the last digits")
    outlier_share: float = Field(description="share of the points that do not belong to the surface")
    quantisation_step: float | None = Field(
        description="step that the decimal coordinates differ by multiples of; null if there is none"
    )
    correlated: Deviation | None = Field(
        description="the part of the noise that neighbouring points share, rough as sensors make it; null if "
        "none was found"
    )
    smooth: Deviation | None = Field(
        description="a smooth deviation of the points from the surface, as a bent part or a wrong shape has; "
        "null if none was found"
    )


class Interval(BaseModel):
    """A 95 % interval of one number, in the unit of the input or in radians."""

    low: float | None = Field(description="null where the points do not bound it")
    high: float | None = Field(description="null where the points do not bound it")
    standard_deviation: float = Field(description="by linearisation")
    method: Method = Field(
        description="`linear`: symmetric; `profile`: how far a number may go, the others following, before "
        "the points object; `held`: by constraints; `bound`: from an active bound to where the points would "
        "go"
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


Evidence = Annotated[
    float | None,
    Field(
        description="natural logarithm of the kind's probability over that of the best kind: 0 for that one, "
        "negative for the others, but for those refused by themselves or equal within `tolerance`; null if "
        "the kind was not weighed"
    ),
]
_ITS_EXTENTS = "where it begins and ends; null if its points span no surface"


class Attempt(BaseModel):
    """One kind that was tried."""

    kind: KindName
    probability: float | None = Field(description="what the classifier gave it")
    outcome: Literal["accepted", "refused", "failed"]
    reason: str
    primitive: Primitive | None
    error: ErrorSummary | None
    noise: NoiseSummary | None
    evidence: Evidence


class AlternativeBase(BaseModel):
    """What an alternative says beside its parameters, as the answer does of `primitive`."""

    error: ErrorSummary
    uncertainty: Uncertainty | None = Field(description="how well its parameters are known")
    evidence: Evidence


class PlaneAlternative(AlternativeBase, Plane):
    """A plane that explains an ambiguous cloud, too."""

    extents: PlaneExtents | None = Field(description=_ITS_EXTENTS)


class SphereAlternative(AlternativeBase, Sphere):
    """A sphere that explains an ambiguous cloud, too."""

    extents: SphereExtents | None = Field(description=_ITS_EXTENTS)


class CylinderAlternative(AlternativeBase, Cylinder):
    """A cylinder that explains an ambiguous cloud, too."""

    extents: CylinderExtents | None = Field(description=_ITS_EXTENTS)


class ConeAlternative(AlternativeBase, Cone):
    """A cone that explains an ambiguous cloud, too."""

    extents: ConeExtents | None = Field(description=_ITS_EXTENTS)


class TorusAlternative(AlternativeBase, Torus):
    """A torus that explains an ambiguous cloud, too."""

    extents: TorusExtents | None = Field(description=_ITS_EXTENTS)


Alternative = Annotated[
    PlaneAlternative | SphereAlternative | CylinderAlternative | ConeAlternative | TorusAlternative,
    Field(discriminator="kind"),
]


class UsedOptions(BaseModel):
    """The options as used, defaults filled in."""

    kinds: list[KindName]
    classifier: ClassifierName
    criterion: CriterionName
    max_error: float | None
    tolerance: float | None
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
    format: str = Field(description="json, text, npy, ply, stl, obj or glb")
    columns: list[str] = Field(description="columns used, by their name in the file")
    options: UsedOptions
    versions: Versions


class FitAnswer(BaseModel):
    """Which primitive the cloud is, and the evidence."""

    status: Literal["fitted", "ambiguous", "no_fit"] = Field(
        description="`ambiguous`: `alternatives` explain it as well; `no_fit`: nothing is good enough"
    )
    primitive: Primitive | None
    alternatives: list[Alternative] = Field(
        description="the other kinds that explain an `ambiguous` cloud, the likelier first: of each its "
        "parameters, error, extents, uncertainty and evidence"
    )
    message: str
    extents: Extents | None = Field(
        description="where `primitive` begins and ends; null without one, or if its points span no surface"
    )
    uncertainty: Uncertainty | None = Field(
        description="how well `primitive` is known; null with `no_fit`, and with `minimum_zone`, "
        "`minimum_circumscribed` and `maximum_inscribed`"
    )
    error: ErrorSummary | None
    noise: NoiseSummary | None
    active_constraints: dict[str, str] = Field(
        description="how each constraint acts on `primitive`, by its name; `not applicable: ...` where its "
        "kind has no such parameter",
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


class InputFormat(BaseModel):
    """A format that clouds are read from."""

    name: str = Field(description="as `receipt.format` has it")
    how: str = Field(description="what is read of it")
    extensions: list[str]
    media_types: list[str]


class OptionRange(BaseModel):
    """What one option of a fit may be."""

    name: str
    description: str
    type: str = Field(description="array, string, number, integer or object")
    default: Any = Field(description="null where there is none")
    values: list[str] | None = Field(
        description="those that there are, of a name or of the names in an array"
    )
    minimum: int | float | None
    exclusive_minimum: int | float | None
    maximum: int | float | None


class ServiceLimits(BaseModel):
    """How much this service takes."""

    max_body_bytes: int
    max_points: int
    max_json_points: int
    fit_time_limit: float = Field(description="seconds for reading and fitting")
    receive_timeout: float = Field(description="seconds to wait for the next piece of a body")
    queue_size: int = Field(description="requests that may wait for a worker")
    rate_limit: str | None = Field(
        description="most requests of one client in a time", examples=["120/minute"]
    )


class Capabilities(BaseModel):
    """What this service reads, tries and allows."""

    kinds: list[KindName]
    classifiers: list[ClassifierName]
    criteria: list[CriterionName]
    formats: list[InputFormat]
    artifacts: list[str] = Field(description="what `POST /fit/export` writes")
    content_encodings: list[str] = Field(description="of request bodies")
    options: list[OptionRange]
    limits: ServiceLimits
    extras: dict[str, bool] = Field(description="optional parts, and whether they are installed")
    versions: Versions


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


class BatchItem(BaseModel):
    """What a line of a batch is about: a file, or a segment of it."""

    id: str = Field(
        max_length=80,
        description="unique in the answer: the file name, and the label",
        examples=["segments.csv#3"],
    )
    file: str | None = Field(max_length=80, description="last component of the file name; null without one")
    label: int | str | None = Field(description="of the segment; null for a file that was not cut")


class BatchAnswer(BatchItem):
    """A cloud that was fitted."""

    answer: FitAnswer = Field(description="what `POST /fit` says of these points")


class BatchProblem(BatchItem):
    """A file that cannot be read, or a cloud that cannot be fitted."""

    problem: Problem


class BatchCounts(BaseModel):
    """How many lines of each sort there were."""

    items: int
    fitted: int
    ambiguous: int
    no_fit: int
    problems: int


class BatchSummary(BaseModel):
    """The last line: without it the answer was cut off."""

    summary: BatchCounts
