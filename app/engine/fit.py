"""The one object that REST, command line and Python call: points in, `Recognition` out."""

from collections.abc import Mapping, Sequence
from typing import Any, cast

from numpy.typing import ArrayLike

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidOptionError, InvalidPointCloudError
from primfit.fitting.names import ANSWER_PARTS, CRITERION, KINDS, SEED, AnswerPart, Criterion, KindName
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import UNCONSTRAINED, Constraints
from primfit.fitting.request.guess import guess_of
from primfit.models import load_classifier
from primfit.models.names import CLASSIFIER, CLASSIFIERS, ClassifierName

from ..readers.cloud import Cloud
from .arrays import as_cloud, as_floats

__all__ = ["InvalidOptionError", "InvalidPointCloudError", "Recognition", "fit", "fit_cloud"]


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
) -> Recognition:
    """Say which primitive a cloud is, with its parameters and the trail of attempts.

    Parameters
    ----------
    points : (N, 3), any unit of length: an array, a tensor, a table with columns x, y, z, or a cloud of
        Open3D or trimesh; see `app.engine.arrays.as_cloud`
    kinds : kinds that may be answered; None allows all
    classifier : who ranks the kinds: `network`, `knn`, or `none` to try all of them and select
    criterion : what the parameters minimise: `robust`, `least_squares`, `huber`, `tukey`, `minimum_zone`,
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

    Raises
    ------
    InvalidPointCloudError
        The points are not finite (N, 3), or too few, identical or collinear; or weights are not (N,), out of
        range, or beside a criterion of extreme points, which takes none.
    InvalidOptionError
        An option is unknown or out of range.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> recognition = primfit.fit(points, kinds=["sphere", "cylinder"])
    >>> recognition.status, recognition.primitive.kind, round(recognition.primitive.radius, 9)
    ('fitted', 'sphere', 2.0)
    """
    config = config_of(
        kinds, classifier, criterion, max_error, tolerance, seed, constraints, initial_guess, include
    )
    coordinates, held = as_cloud(points)
    return recognize(
        coordinates,
        config,
        load_classifier(classifier),
        held if normals is None else as_floats(normals, "normals"),
        None if weights is None else as_floats(weights, "weights"),
        None if standard_deviations is None else as_floats(standard_deviations, "standard_deviations"),
    )


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
) -> Config:
    """The options of `fit`, checked before there is a cloud; raises `InvalidOptionError`."""
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
    )


def fit_cloud(cloud: Cloud, options: Mapping[str, Any]) -> Recognition:
    """`fit` of a cloud as it was read, with checked options."""
    return fit(
        cloud.points,
        normals=cloud.normals,
        weights=cloud.weights,
        standard_deviations=cloud.standard_deviations,
        **options,
    )
