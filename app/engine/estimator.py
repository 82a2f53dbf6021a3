"""The fit as an estimator of scikit-learn: a primitive is learned from a cloud, points are held to it."""

from collections.abc import Mapping, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, OutlierMixin
from sklearn.utils.validation import check_is_fitted, validate_data

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.rounding import rounding_of
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.verdict.evidence import OUTLIER

from .fit import fit


class PrimitiveFitter(OutlierMixin, BaseEstimator):
    """The primitive of a cloud, and which points lie on it: `primfit.fit` in the manner of scikit-learn.

    Samples are points, their three features the coordinates, in this order whatever their names. The
    parameters are checked when `fit` is called, as everywhere in scikit-learn.

    Parameters
    ----------
    kinds, classifier, criterion, max_error, tolerance, seed, constraints, initial_guess, include : as in
        `primfit.fit`

    Attributes
    ----------
    recognition_ : the whole answer. Its status may be `ambiguous` or `no_fit`: then the first kind, or the
        best try, is taken
    primitive_ : its primitive
    inlier_threshold_ : largest distance of an inlier [length]: four times the noise, and at least that of the
        farthest point of the cloud that the fit did not reject
    offset_ : its negative, the score at which a point becomes an outlier
    inlier_mask_ : (N,) which points of the cloud are inliers
    n_features_in_ : 3
    feature_names_in_ : names of the columns, where the cloud has some

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 500)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere(np.zeros(3), 2.0).surface(azimuth, polar)
    >>> fitter = primfit.PrimitiveFitter(kinds=["sphere", "cylinder"]).fit(points)
    >>> fitter.primitive_.kind
    'sphere'
    >>> fitter.predict([[2.0, 0.0, 0.0], [0.0, 0.0, 2.5]])
    array([ 1, -1])
    """

    def __init__(
        self,
        *,
        kinds: Sequence[str] | None = None,
        classifier: str = "network",
        criterion: str = "robust",
        max_error: float | None = None,
        tolerance: float | None = None,
        seed: int = 0,
        constraints: Constraints | Mapping[str, Any] | None = None,
        initial_guess: Primitive | Mapping[str, Any] | None = None,
        include: Sequence[str] | None = None,
    ) -> None:
        self.kinds = kinds
        self.classifier = classifier
        self.criterion = criterion
        self.max_error = max_error
        self.tolerance = tolerance
        self.seed = seed
        self.constraints = constraints
        self.initial_guess = initial_guess
        self.include = include

    def fit(
        self,
        X: ArrayLike,
        y: object = None,
        *,
        sample_weight: ArrayLike | None = None,
        normals: ArrayLike | None = None,
        standard_deviations: ArrayLike | None = None,
    ) -> Self:
        """Learn the primitive of a cloud.

        Parameters
        ----------
        X : (N, 3) points, any unit of length
        y : not used
        sample_weight : (N,), the `weights` of `primfit.fit`
        normals, standard_deviations : as there

        Raises
        ------
        ValueError
            No primitive could be had of the points, or as `primfit.fit` does.
        """
        points = self._points(X, reset=True)
        recognition = fit(
            points,
            normals=normals,
            weights=sample_weight,
            standard_deviations=standard_deviations,
            **self.get_params(deep=False),
        )
        found, noise = recognition.primitive, recognition.noise
        if found is None or noise is None:
            raise InvalidPointCloudError(f"no primitive was found: {recognition.message}", "X")
        self.recognition_: Recognition = recognition
        self.primitive_: Primitive = found
        distance = np.abs(found.signed_distance(points))
        farthest = float(distance[recognition.inliers].max(initial=0.0))
        self.inlier_threshold_ = max(OUTLIER * noise.scale, farthest, rounding_of(points).size)
        self.offset_ = -self.inlier_threshold_
        self.inlier_mask_: NDArray[np.bool_] = distance <= self.inlier_threshold_
        return self

    def score_samples(self, X: ArrayLike) -> Array:
        """(N,) minus the orthogonal distances of points (N, 3) from the primitive [length]."""
        check_is_fitted(self)
        return -np.abs(self.primitive_.signed_distance(self._points(X, reset=False)))

    def decision_function(self, X: ArrayLike) -> Array:
        """(N,) by how much points (N, 3) are closer than the threshold [length]; negative for outliers."""
        return self.score_samples(X) - self.offset_

    def predict(self, X: ArrayLike) -> NDArray[np.int_]:
        """(N,) 1 for each of the points (N, 3) that lies on the primitive, -1 for outliers."""
        return np.where(self.decision_function(X) >= 0.0, 1, -1)

    def score(self, X: ArrayLike, y: object = None) -> float:
        """Minus the mean distance of points (N, 3) from the primitive [length]: larger is better."""
        return float(self.score_samples(X).mean())

    def _points(self, X: ArrayLike, *, reset: bool) -> Array:
        least = 3 if reset else 1
        points: Array = validate_data(self, X, reset=reset, dtype=np.float64, ensure_min_samples=least)
        if points.shape[1] != 3:
            raise InvalidPointCloudError(
                f"X has n_features = {points.shape[1]}; a point has 3 coordinates", "X"
            )
        return points
