"""The wire: options, requests and answers as the OpenAPI document shows them.

What the dataclasses of `fitting` say already is derived from them; a model is written here where the wire
differs, or has what `fitting` does not know. Points are not validated here: a model of 200,000 rows is slow
and repeats the input in its errors. The readers check them; these models describe them.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, WithJsonSchema
from typing_extensions import TypeAliasType

from primfit.fitting import names
from primfit.fitting.answer import conformance as measured
from primfit.fitting.answer import result, values
from primfit.fitting.extents import EXTENTS
from primfit.fitting.extents import values as extents
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import PRIMITIVES, primitive
from primfit.fitting.request import constraints
from primfit.fitting.request.values import LARGEST
from primfit.fitting.uncertainty import values as known
from primfit.fitting.uncertainty.warnings import Warning
from primfit.models import names as classifiers

from ..readers.cloud import UnitSource
from ..readers.encoded import DtypeName
from ..readers.formats import Format
from .derived import CLOSED, Models, Vector, union

KindName = TypeAliasType("KindName", names.KindName)
ClassifierName = TypeAliasType("ClassifierName", classifiers.ClassifierName)
CriterionName = TypeAliasType("CriterionName", names.Criterion)
AnswerPart = TypeAliasType("AnswerPart", names.AnswerPart)
Unit = TypeAliasType("Unit", names.Unit)
Missing = TypeAliasType("Missing", names.Missing)

Upload = Annotated[bytes, WithJsonSchema({"type": "string", "format": "binary"})]
_wire = Models()

_PRIMITIVES = {kind: _wire.model(PRIMITIVES[kind], config=CLOSED) for kind in KINDS}
Primitive = _wire.stands_for(primitive.Primitive, union(_PRIMITIVES.values()))
_EXTENTS = {kind: _wire.model(EXTENTS[kind], config=CLOSED) for kind in KINDS}
Extents = _wire.stands_for(extents.Extents, union(_EXTENTS.values()))


class NumberConstraint(BaseModel):
    """A number that is fixed by `value`, or bounded by `min`, `max` or both."""

    model_config = CLOSED

    value: float | None = Field(None, gt=0)
    min: float | None = Field(None, gt=0)
    max: float | None = Field(None, gt=0)


class DirectionConstraint(BaseModel):
    """An axis or a normal along a direction up to sign, or within `max_angle` radians of it."""

    model_config = CLOSED

    direction: Vector
    max_angle: float = Field(0.0, ge=0, lt=1.5707963267948966)


_wire.stands_for(constraints.Range, NumberConstraint)
_wire.stands_for(constraints.Direction, DirectionConstraint)
Constraints = _wire.model(constraints.Constraints, config=CLOSED, optional=True)


class FitOptions(BaseModel):
    """What may be asked of a fit."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)

    kinds: list[KindName] = Field(
        default=list(KINDS),
        min_length=1,
        max_length=len(KINDS),
        description="kinds that may be answered; all of them by default",
        json_schema_extra={"uniqueItems": True},
    )
    classifier: ClassifierName = Field(
        classifiers.CLASSIFIER,
        description="who ranks the kinds: `network` (the default) or `knn`; `none` tries all and selects",
    )
    criterion: CriterionName = Field(
        names.CRITERION,
        description="what the parameters minimize: `robust` (the default) rejects outliers; `least_squares` "
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
    seed: int = Field(names.SEED, ge=0, le=2**63 - 1, description="seed of every random choice, 0 by default")
    constraints: Constraints | None = Field(  # type: ignore[valid-type]
        None, description="parameters that are fixed or bounded; in JSON only, not in a query"
    )
    initial_guess: Primitive | None = Field(  # type: ignore[valid-type]
        None,
        description="a primitive that joins the starts of its kind; in JSON only, not in a query",
    )
    include: list[AnswerPart] = Field(
        default=list(names.ANSWER_PARTS),
        max_length=len(names.ANSWER_PARTS),
        description="parts of the answer that are wanted, both by default; the others are not computed, and "
        "null, those of alternatives, too. `include=` in a query asks for neither",
        json_schema_extra={"uniqueItems": True},
    )
    nominal: dict[str, Any] | None = Field(
        None,
        description="what the primitive should be: its `kind`, and any of its parameters, each a value or "
        "`{value, tolerance}`, the tolerance of a number also as `[lower, upper]`; in JSON only. The answer "
        "says under `conformance` how far it deviates",
        examples=[{"kind": "cylinder", "radius": {"value": 25.0, "tolerance": 0.05}}],
    )
    form_tolerance: float | None = Field(
        None,
        gt=0,
        le=LARGEST,
        description="largest form error of the inliers allowed, in the unit of the points; the verdict "
        "stands under `conformance`",
    )
    columns: list[str | int] | None = Field(
        None,
        min_length=3,
        max_length=6,
        description="which columns of a file are x, y and z, and perhaps nx, ny and nz: names, or numbers "
        "from 1; by default found by their names, or the first three. In a query `columns=2,3,4`",
        examples=[["2", "3", "4"]],
    )
    missing: Missing = Field(
        "drop",
        description="points that are NaN or infinite, or exact zeros like several others, are dropped and "
        "counted (`drop`, the default); `error` refuses the former and keeps the latter",
    )
    unit: Unit | None = Field(
        None,
        description="of the points, for the words of the answer and for exports; nothing is converted. By "
        "default that of the file, if its header or its format tells it",
    )


class EncodedArray(BaseModel):
    """An array as its bytes, little-endian and row by row: smaller and quicker than numbers in text."""

    model_config = CLOSED

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
    """A cloud as a file of any format that is read, also packed by gzip or zstd, recognized by content."""

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


_wire.model(values.ErrorSummary)
_wire.model(measured.Check)
_wire.model(measured.Conformance)
_wire.model(values.Deviation)
_wire.model(values.NoiseSummary)
_wire.model(known.Interval)
_wire.model(
    known.Spread,
    standard_deviations=Annotated[list[float], Field(min_length=1, max_length=2)],
)
_wire.model(known.CorrelatedNoise, power=Literal[1, 2])
_wire.model(Warning, "UncertaintyWarning")
_wire.model(
    known.Uncertainty,
    parameters=Annotated[
        list[str], Field(examples=[["axis.x", "axis.y", "axis.z", "point.x", "point.y", "point.z", "radius"]])
    ],
)
_wire.model(result.Attempt, kind=KindName)
Alternative = union(
    _wire.model(
        result.Alternative,
        f"{PRIMITIVES[kind].__name__}Alternative",
        without=("primitive", "active_constraints"),
        base=_PRIMITIVES[kind],
        doc=f"A {kind} that explains an ambiguous cloud, too.",
        extents=_EXTENTS[kind] | None,
    )
    for kind in KINDS
)


class UsedOptions(BaseModel):
    """The options as used, defaults filled in."""

    kinds: list[KindName]
    classifier: ClassifierName
    criterion: CriterionName
    max_error: float | None
    tolerance: float | None
    seed: int
    constraints: Constraints | None  # type: ignore[valid-type]
    initial_guess: Primitive | None  # type: ignore[valid-type]
    include: list[AnswerPart] = Field(
        default=list(names.ANSWER_PARTS),
        description="parts that were asked for; not there where all were",
    )
    nominal: dict[str, Any] | None = Field(None, description="as it was given; not there without")
    form_tolerance: float | None = Field(None, description="not there where none was given")


class Versions(BaseModel):
    """Versions that decide the numbers."""

    primfit: str
    weights: str | None = Field(description="SHA-256 of the classifier's weights")
    numpy: str
    scipy: str


class Dropped(BaseModel):
    """How many points are missing, and were left out."""

    not_finite: int = Field(description="with a coordinate that is NaN or infinite, or marked as invalid")
    zero: int = Field(description="exact zeros (0, 0, 0), as depth cameras write them")


class Receipt(BaseModel):
    """What was fitted and how: enough to repeat it."""

    input_sha256: str = Field(
        description="of the points that were fitted, as little-endian float64, row by row"
    )
    weights_sha256: str | None = Field(
        description="of the weights or standard deviations as little-endian float64, if there were any"
    )
    n_points: int
    format: str = Field(description="json, text, npy, ply, stl, obj or glb")
    columns: list[str] = Field(description="columns used, by their name in the file")
    dropped: Dropped
    unit: Unit | None = Field(description="of all lengths; null where it is not known")
    unit_from: UnitSource | None = Field(
        description="what says so: the `option`, the `header` of the file, or its `format`"
    )
    options: UsedOptions
    versions: Versions


FitAnswer = _wire.model(
    result.Recognition,
    "FitAnswer",
    without=("n_points", "inlier_rule", "include", "points", "unit", "source"),
    doc="Which primitive the cloud is, and the evidence.",
    alternatives=list[Alternative],  # type: ignore[valid-type]
    extents=Extents | None,
    active_constraints=Annotated[
        dict[str, str], Field(examples=[{"radius": "at its upper bound 5.0", "axis": "fixed"}])
    ],
    receipt=Receipt,
)


class Live(BaseModel):
    """The process answers."""

    status: Literal["alive"]


class Ready(BaseModel):
    """Workers are warm and the weights are loaded."""

    status: Literal["ready"]
    workers: int


InputFormat = _wire.model(Format, "InputFormat")


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
    points_by_criterion: dict[CriterionName, int] = Field(
        description="most points of a cloud by its criterion: so many are done in `fit_time_limit`"
    )
    fit_time_limit: float = Field(description="seconds for reading and fitting")
    receive_timeout: float = Field(description="seconds over which the rate of a body is averaged")
    queue_size: int = Field(description="requests that may wait for a worker")
    rate_limit: str | None = Field(
        description="most requests of one client in a time", examples=["120/minute"]
    )


class Capabilities(BaseModel):
    """What this service reads, tries and allows."""

    kinds: list[KindName]
    classifiers: list[ClassifierName]
    criteria: list[CriterionName]
    formats: list[InputFormat]  # type: ignore[valid-type]
    artifacts: list[str] = Field(description="what `POST /fit/export` writes")
    content_encodings: list[str] = Field(description="of request bodies")
    options: list[OptionRange]
    limits: ServiceLimits
    jobs: bool = Field(description="whether `POST /jobs` keeps work that takes long")
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

    answer: FitAnswer = Field(description="what `POST /fit` says of these points")  # type: ignore[valid-type]


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
