"""The one object that REST, command line and Python call: points in, `Recognition` out."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from inspect import signature
from os import PathLike
from typing import Any, cast

from numpy.typing import ArrayLike

from primfit.fitting.answer.result import Recognition, Source
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError
from primfit.fitting.geometry.vectors import bounds
from primfit.fitting.names import (
    ANSWER_PARTS,
    CRITERION,
    KINDS,
    MISSING,
    SEED,
    AnswerPart,
    Criterion,
    KindName,
    Missing,
    Unit,
)
from primfit.fitting.noise.rounding import float32_step
from primfit.fitting.plain import worded
from primfit.fitting.primitives import parameters_of
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import UNCONSTRAINED, Constraints
from primfit.fitting.request.guess import guess_of
from primfit.fitting.request.nominal import Nominal
from primfit.fitting.words import figure
from primfit.models import load_classifier
from primfit.models.names import CLASSIFIER, CLASSIFIERS, ClassifierName

from ..readers import Cloud, Pick, read_file, without_missing
from ..readers.columns import as_columns
from ..readers.missing import warnings_of
from .arrays import as_cloud, as_floats
from .names import base_name

SMALLEST_SIZE, LARGEST_SIZE = 1e-5, 1e6
"""Radii beyond these are doubtful in any unit: whoever measures micrometers does not write meters."""

__all__ = [
    "InvalidOptionError",
    "InvalidPointCloudError",
    "Recognition",
    "fit",
    "fit_cloud",
    "prepared",
    "read",
]


def fit(
    points: Any,
    *,
    kinds: Sequence[KindName] | None = None,
    classifier: ClassifierName = CLASSIFIER,
    criterion: Criterion = CRITERION,
    max_error: float | None = None,
    tolerance: float | None = None,
    seed: int = SEED,
    normals: ArrayLike | None = None,
    weights: ArrayLike | None = None,
    standard_deviations: ArrayLike | None = None,
    constraints: Constraints | Mapping[str, Any] | None = None,
    initial_guess: Primitive | Mapping[str, Any] | None = None,
    include: Sequence[AnswerPart] | None = None,
    nominal: Mapping[str, Any] | None = None,
    form_tolerance: float | None = None,
    columns: str | Sequence[str | int] | None = None,
    missing: Missing = "drop",
    unit: Unit | None = None,
) -> Recognition:
    """Say which primitive a cloud is, with its parameters and the trail of attempts.

    Parameters
    ----------
    points : (N, 3), any unit of length: the path of a file, what `read` gave, an array, a tensor, a table
        with columns x, y, z, or a cloud of Open3D or trimesh; see `app.engine.arrays.as_cloud`
    kinds : kinds that may be answered; None allows all
    classifier : who ranks the kinds: `network`, `knn`, or `none` to try all of them and select
    criterion : what the parameters minimize: `robust`, `least_squares`, `huber`, `tukey`, `minimum_zone`,
        `minimum_circumscribed` or `maximum_inscribed`; see `Config`
    max_error : largest accepted mean absolute distance of the points not rejected as outliers, as a share of
        the bounding-box diagonal; None derives the threshold from the cloud's own noise
    tolerance : what counts as no deviation [length], or None. Kinds that agree within it over the cloud are
        equal, and the simplest is answered; a smooth deviation within it never leads to `no_fit`
    seed : of every random choice; the same seed gives the same answer
    normals : (N, 3) unit normals with arbitrary signs, or None for those that `points` hold, or else to
        estimate them
    weights : (N,) how much each point counts in the last refinement, not negative; 0 leaves it out
    standard_deviations : (N,) of the noise of each point [length], in place of weights
    constraints : parameters that are fixed or bounded: `Constraints`, or what `Constraints.of` takes:
        `{"radius": {"value": 5}}`, `{"radius": {"min": 4, "max": 6}}`, `{"center": [0, 0, 0]}`,
        `{"axis": {"direction": [0, 0, 1], "max_angle": 0.05}}`; each acts on the kinds that have such a
        parameter
    initial_guess : a primitive, or its parameters with `kind`, that joins the starts of its kind
    include : which of the parts `extents` and `uncertainty` are wanted; the others are not computed and stand
        at None. None asks for both
    nominal : what the primitive should be: its `kind`, and any of its parameters, each a value or
        `{"value": 25, "tolerance": 0.05}`; `Recognition.conformance` says how far it deviates
    form_tolerance : largest form error of the inliers allowed [length]; the verdict stands there, too
    columns : of x, y and z in a file, and perhaps of nx, ny and nz: names, or numbers from 1; None finds
        them. A cloud from `read` takes none: there they were chosen
    missing : points that are NaN or infinite, or exact zeros like several others, are dropped (`drop`), with
        a warning; `error` refuses the former and keeps the latter
    unit : of the points, for the words of the answer: `um`, `mm`, `cm`, `m`, `km`, `inch`, `ft` or `us-ft`;
        None takes that of the file, if it has one. Nothing is converted

    Raises
    ------
    InvalidPointCloudError
        The points are not (N, 3), or too few, identical or collinear; or weights are not (N,), out of range,
        or beside a criterion of extreme points, which takes none.
    InvalidOptionError
        An option is unknown or out of range.
    UnreadableFileError
        The file holds no cloud.
    OSError
        The file cannot be opened.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> recognition = primfit.fit(points, kinds=["sphere", "cylinder"])
    >>> recognition.status, recognition.primitive.kind, round(recognition.primitive.radius, 9)
    ('fitted', 'sphere', 2.0)
    """
    options: dict[str, Any] = {
        "kinds": kinds,
        "classifier": classifier,
        "criterion": criterion,
        "max_error": max_error,
        "tolerance": tolerance,
        "seed": seed,
        "constraints": constraints,
        "initial_guess": initial_guess,
        "include": include,
        "nominal": nominal,
        "form_tolerance": form_tolerance,
        "columns": columns,
        "missing": missing,
        "unit": unit,
    }
    config_of(**options)
    given = {"normals": normals, "weights": weights, "standard_deviations": standard_deviations}
    beside: dict[str, Any] = {name: as_floats(each, name) for name, each in given.items() if each is not None}
    cloud = replace(cloud_of(points, columns), **beside)
    # A row for each point that was given: those that are missing have NaN for their residual.
    found = fit_cloud(cloud, _with_options_of(cloud, options)).with_points(cloud.points)
    name = base_name(str(points)) if isinstance(points, str | PathLike) else None
    return replace(found, source=Source(name, cloud.format, cloud.columns))


def read(
    path: str | PathLike[str],
    *,
    columns: str | Sequence[str | int] | None = None,
    labels: str | None = None,
) -> Cloud:
    """The cloud in a file of any format that the service reads, also packed by gzip or zstd.

    Parameters
    ----------
    columns : of x, y and z, and perhaps of nx, ny and nz: names, or numbers from 1; None finds them
    labels : the column that tells segments apart, or `auto` for one of a usual name; None reads none

    Returns
    -------
    Its points as they are, NaN where one is missing; `fit` takes it, and `fit_segments` if it has labels.

    Raises
    ------
    UnreadableFileError
        The file holds no cloud, or no such column.
    InvalidOptionError
        `columns` are neither names nor numbers.
    OSError
        The file cannot be opened.

    Examples
    --------
    >>> import pathlib, tempfile, primfit
    >>> file = pathlib.Path(tempfile.mkdtemp(), "scan.csv")
    >>> _ = file.write_text("X [mm],Y [mm],Z [mm]\\n1,2,3\\n4,5,6\\n")
    >>> cloud = primfit.read(file)
    >>> cloud.points.shape, cloud.unit
    ((2, 3), 'mm')
    """
    return read_file(path, pick=Pick(labels, as_columns(columns)))


def cloud_of(points: Any, columns: str | Sequence[str | int] | None = None) -> Cloud:
    """The cloud in a file, or in what `as_cloud` takes."""
    if isinstance(points, Cloud):
        if columns is not None:
            raise InvalidOptionError(
                "columns choose from a file, and this cloud was read already: give them to primfit.read",
                "columns",
            )
        return points
    if isinstance(points, str | PathLike):
        return read(points, columns=columns)
    return as_cloud(points, Pick(columns=as_columns(columns)))


def _with_options_of(cloud: Cloud, given: Mapping[str, Any]) -> dict[str, Any]:
    """The options given, and those in the file: JSON may hold some."""
    defaults = {name: each.default for name, each in signature(config_of).parameters.items()}
    for name in cloud.options:
        if name not in defaults:
            raise InvalidOptionError(
                f"the file holds an unknown option; allowed are {', '.join(defaults)}", "options"
            )
        if given[name] is not defaults[name] and (defaults[name] is None or given[name] != defaults[name]):
            raise InvalidOptionError(f"{name} is given here and in the file; keep one", name)
    return {**given, **cloud.options}


def config_of(
    kinds: Sequence[KindName] | None = None,
    classifier: ClassifierName = CLASSIFIER,
    criterion: Criterion = CRITERION,
    max_error: float | None = None,
    tolerance: float | None = None,
    seed: int = SEED,
    constraints: Constraints | Mapping[str, Any] | None = None,
    initial_guess: Primitive | Mapping[str, Any] | None = None,
    include: Sequence[AnswerPart] | None = None,
    nominal: Mapping[str, Any] | None = None,
    form_tolerance: float | None = None,
    columns: str | Sequence[str | int] | None = None,
    missing: str = "drop",
    unit: str | None = None,
) -> Config:
    """The options of `fit`, checked before there is a cloud; raises `InvalidOptionError`."""
    as_columns(columns)
    if missing not in MISSING:
        raise InvalidOptionError(f"missing is {missing!r:.40}; allowed are {', '.join(MISSING)}", "missing")
    if classifier not in CLASSIFIERS:
        raise InvalidOptionError(f"classifier must be one of {', '.join(CLASSIFIERS)}", "classifier")
    return Config(
        kinds=KINDS if kinds is None else cast(tuple[str, ...], kinds),
        criterion=criterion,
        max_error=max_error,
        tolerance=tolerance,
        seed=seed,
        constraints=UNCONSTRAINED if constraints is None else Constraints.of(constraints),
        initial_guess=guess_of(initial_guess) if isinstance(initial_guess, Mapping) else initial_guess,
        include=ANSWER_PARTS if include is None else cast(tuple[str, ...], include),
        nominal=None if nominal is None else Nominal.of(nominal),
        form_tolerance=form_tolerance,
        unit=cast(Unit | None, unit),
    )


def fit_cloud(cloud: Cloud, options: Mapping[str, Any]) -> Recognition:
    """`fit` of a cloud as it was read, with checked options."""
    return fit_prepared(prepared(cloud, options), options)


def fit_prepared(cloud: Cloud, options: Mapping[str, Any]) -> Recognition:
    """`fit_cloud` of what `prepared` gave."""
    found = recognize(
        cloud.points,
        config_of(**{**options, "unit": cloud.unit}),
        load_classifier(options.get("classifier", CLASSIFIER)),
        cloud.normals,
        cloud.weights,
        cloud.standard_deviations,
    )
    return replace(found, warnings=(*warnings_of(cloud), *_of_steps(cloud), *_of_sizes(found)))


def _of_steps(cloud: Cloud) -> list[str]:
    """A warning where coordinates were stored as float32 far from the origin."""
    step = float32_step(cloud.points, bounds(cloud.points))
    if step is None:
        return []
    remedy = "store float64, or subtract an offset before writing float32, for a finer answer"
    return [f"The coordinates are float32 numbers in steps of {figure(step, cloud.unit)}: {remedy}."]


def _of_sizes(found: Recognition) -> list[str]:
    """A warning for each radius that nobody measures in the unit that is known: mostly it is another one."""
    if found.unit is None or found.primitive is None:
        return []
    names = [name for name in parameters_of(found.primitive.kind) if name.endswith("radius")]
    radii = [(name, float(getattr(found.primitive, name))) for name in names]
    return [
        f"The {worded(name)} is {value:.3g} {found.unit}: check the unit."
        for name, value in radii
        if not SMALLEST_SIZE < value < LARGEST_SIZE
    ]


def prepared(cloud: Cloud, options: Mapping[str, Any]) -> Cloud:
    """The cloud as it is fitted: without points that are missing, and in the unit that was told.

    Raises `InvalidPointsError` where points are missing and the
    options say that this is an error, or all are.
    """
    cloud = without_missing(cloud, options.get("missing", "drop"))
    unit = options.get("unit")
    if unit is None:
        return cloud
    warnings = cloud.warnings
    if cloud.unit not in (None, unit):
        warnings = (
            *warnings,
            f"The file is in {cloud.unit} by its {cloud.unit_from}, but {unit} was asked for.",
        )
    return replace(cloud, unit=unit, unit_from="option", warnings=warnings)
