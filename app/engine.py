"""The one object that REST, command line and Python call: points in, `Recognition` out."""

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from fitting.config import Config, Criterion
from fitting.errors import InvalidOptionError, InvalidPointCloudError
from fitting.geometry import Array
from fitting.primitives import KINDS
from fitting.recognize import recognize
from fitting.result import Recognition
from models import CLASSIFIERS, load_classifier

__all__ = ["InvalidOptionError", "InvalidPointCloudError", "Recognition", "fit"]


def fit(
    points: ArrayLike,
    *,
    kinds: Sequence[str] | None = None,
    classifier: str = "network",
    criterion: str = "robust",
    max_error: float | None = None,
    seed: int = 0,
    normals: ArrayLike | None = None,
) -> Recognition:
    """Say which primitive a cloud is, with its parameters and the trail of attempts.

    Parameters
    ----------
    points : (N, 3), any unit of length
    kinds : kinds that may be answered; None allows all
    classifier : who ranks the kinds: `network`, `knn`, or `none` to try all of them and select
    criterion : what the parameters minimise: `robust`, `least_squares`, `huber`, `tukey`, `minimum_zone`,
        `minimum_circumscribed` or `maximum_inscribed`; see `Config`
    max_error : largest accepted mean absolute distance of the points not rejected as outliers, as a share of
        the bounding-box diagonal; None derives the threshold from the cloud's own noise
    seed : of every random choice; the same seed gives the same answer
    normals : (N, 3) unit normals with arbitrary signs, or None to estimate them

    Raises
    ------
    InvalidPointCloudError
        The points are not finite (N, 3), or too few, identical or collinear.
    InvalidOptionError
        An option is unknown or out of range.
    """
    if classifier not in CLASSIFIERS:
        raise InvalidOptionError(f"classifier must be one of {', '.join(CLASSIFIERS)}", "classifier")
    config = Config(
        kinds=KINDS if kinds is None else cast(tuple[str, ...], kinds),
        criterion=cast(Criterion, criterion),
        max_error=max_error,
        seed=seed,
    )
    given = None if normals is None else _array(normals, "normals")
    return recognize(_array(points, "points"), config, load_classifier(classifier), given)


def _array(values: ArrayLike, field: str) -> Array:
    try:
        return np.asarray(values, np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidPointCloudError(f"{field} are not an array of numbers of shape (N, 3)", field) from error
