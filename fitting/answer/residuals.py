"""How far points are from an answer, which of them belong to it, and what their distances are like."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..equality import ByValue
from ..geometry.vectors import Array
from ..primitives.primitive import Primitive

PERCENTILES = (0.1, 1.0, 5.0, 25.0, 50.0, 75.0, 95.0, 99.0, 99.9)
BINS = 40

SMALLEST = 1e-300
"""Where no distance is beyond this the edges are those from -1 to 1."""


@dataclass(frozen=True, eq=False)
class InlierRule(ByValue):
    """Which points belong to an answer: those near the robust fit of its kind.

    Attributes
    ----------
    surface : the robust fit, which every criterion starts from and every kind is judged by
    reach : points farther from it are rejected as outliers [length]; infinite where points are few
    """

    surface: Primitive
    reach: float

    def among(self, points: Array) -> NDArray[np.bool_]:
        """Mask (N,) of points (N, 3)."""
        return np.abs(self.surface.signed_distance(points)) <= self.reach


@dataclass(frozen=True, eq=False)
class Residuals(ByValue):
    """Of all points, in their order.

    Attributes
    ----------
    distance : (N,) signed orthogonal distances [length], positive on the outer side of a sphere, cylinder,
        cone or tube of a torus, and on the side of a plane that its normal points to
    inlier : (N,) mask of the points that were not rejected as outliers

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> found = primfit.residuals(primfit.fit(points), [[0, 0, 2], [0, 0, 3]])
    >>> found.distance.round(9), found.inlier
    (array([0., 1.]), array([ True, False]))
    """

    distance: Array
    inlier: NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Histogram(ByValue):
    """Counts (K,) between edges (K + 1,) [length], evenly spaced about 0; every value is counted."""

    edges: Array
    counts: NDArray[np.intp]

    @classmethod
    def of(cls, distance: Array) -> "Histogram":
        largest = float(np.abs(distance).max())
        edges = np.linspace(-1.0, 1.0, BINS + 1) * (largest if largest > SMALLEST else 1.0)
        return cls(edges, np.histogram(distance, edges)[0])


@dataclass(frozen=True, eq=False)
class Deviations(ByValue):
    """What signed distances are like [length].

    Attributes
    ----------
    n_points : how many there are
    mean, rms, mean_absolute, min, max : of the signed distances
    percentiles : of the signed distances, by percent
    """

    n_points: int
    mean: float
    rms: float
    mean_absolute: float
    min: float
    max: float
    percentiles: dict[float, float]
    histogram: Histogram

    @classmethod
    def of(cls, distance: Array) -> "Deviations":
        """Of distances (N,) of which there is one at least."""
        percentiles = np.percentile(distance, PERCENTILES).tolist()
        largest = float(np.abs(distance).max()) or 1.0
        return cls(
            n_points=len(distance),
            mean=float(distance.mean()),
            rms=largest * float(np.sqrt(np.mean((distance / largest) ** 2))),
            mean_absolute=float(np.abs(distance).mean()),
            min=float(distance.min()),
            max=float(distance.max()),
            percentiles=dict(zip(PERCENTILES, percentiles, strict=True)),
            histogram=Histogram.of(distance),
        )
