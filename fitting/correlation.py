"""How the noise of neighbours on a surface agrees: a variogram, and a correlation function fitted to it.

Differences between close points keep what a fit took up of smooth noise out of the variogram
gamma(h) = 1/2 E (z_i - z_j)^2,  which correlations of residuals do not.
Source: Cressie, "Statistics for spatial data", 1993, sections 2.4 and 2.6.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist, squareform

from fitting.geometry import TINY, Array

ANCHORS = 192
NEIGHBOURS = (4, 12)
"""So many points are compared with so many next to each: few see short correlations, many see weak ones."""

SIGNIFICANT = 3.5
"""Standard errors from which the products of neighbours are no accident. Pairs that are counted from both
ends make them 1.4 times as wide as they look."""

PAIRED = 512
"""Points of which all pairs are looked at, where noise is correlated."""

BINS = 20
LENGTHS = 24
REACH = 0.35
"""Distances, in sizes of the cloud, up to which the variogram is taken and correlation lengths are tried."""


@dataclass(frozen=True)
class Correlation:
    """Correlation  share * exp(-(h / length)^power)  of the noise of two points at distance h.

    Attributes
    ----------
    length : distance at which it has fallen to 1 / e of its share
    share : of the variance that is correlated; the rest is each point's own
    power : 1, exponential, or 2, Gaussian
    variance : of the noise, in the squared unit of the values that it was estimated from
    """

    length: float
    share: float
    power: int
    variance: float

    def covariance(self, distance: Array) -> Array:
        """Of two different points so far apart."""
        return self.variance * self.share * np.exp(-((distance / self.length) ** self.power))


def correlation_of(feet: Array, values: Array, order: np.ndarray) -> Correlation | None:
    """The correlation of values (N,) at points (N, 3) of a surface, or None where it is not significant.

    `order` (S,) holds indices of the points in random order.
    """
    tree = cKDTree(feet, leafsize=32, balanced_tree=False, compact_nodes=False)
    anchors = order[:ANCHORS]
    most = min(NEIGHBOURS[-1] + 1, len(feet))
    distance, other = tree.query(feet[anchors], k=most)
    distance, other = distance[:, 1:], other[:, 1:]
    products = values[anchors, None] * values[other]
    if not any(_stands_out(products[:, :count]) for count in NEIGHBOURS):
        return None
    chosen = order[:PAIRED]
    near = (values[anchors, None] - values[other]) ** 2 / 2.0
    far = pdist(values[chosen, None], "sqeuclidean") / 2.0
    distances = np.concatenate([distance.ravel(), pdist(feet[chosen])])
    return _fitted(distances, np.concatenate([near.ravel(), far]))


def distances_between(points: Array) -> Array:
    """(N, N) of points (N, 3)."""
    return squareform(pdist(points))


def _stands_out(products: Array) -> bool:
    """Whether products of neighbours are positive on the average by more than chance."""
    error = float(np.sqrt(np.sum(products**2)))
    return float(products.sum()) > SIGNIFICANT * error


def _fitted(distance: Array, half_square: Array) -> Correlation | None:
    """Weighted least squares of  nugget + sill (1 - exp(-(h / L)^p))  over lengths L and powers p."""
    reach = REACH * float(distance.max())
    inside = (distance > 0.0) & (distance < reach)
    distance, half_square = distance[inside], half_square[inside]
    shortest = float(np.quantile(distance, 20.0 / len(distance))) if len(distance) > 20 else reach
    edges = np.geomspace(shortest, reach, BINS)
    place = np.searchsorted(edges, distance)
    count = np.bincount(place, minlength=BINS + 1)[:BINS]
    some = count > 0
    height = np.bincount(place, distance, BINS + 1)[:BINS][some] / count[some]
    gamma = np.bincount(place, half_square, BINS + 1)[:BINS][some] / count[some]
    weight = np.sqrt(count[some])
    best: Correlation | None = None
    least = np.inf
    for power in (1, 2):
        for length in np.geomspace(shortest, reach, LENGTHS):
            model = 1.0 - np.exp(-((height / length) ** power))
            nugget, sill = _two_positive(model, gamma, weight)
            cost = float(weight @ (nugget + sill * model - gamma) ** 2)
            if cost < least and sill > 0.0:
                variance = nugget + sill
                best, least = Correlation(float(length), sill / variance, power, variance), cost
    return best


def _two_positive(model: Array, target: Array, weight: Array) -> tuple[float, float]:
    """Weighted least squares of  a + b model = target  with a and b not negative."""
    total, mean = weight.sum(), weight @ model
    square, moment, product = weight @ model**2, weight @ target, weight @ (model * target)
    determinant = total * square - mean**2
    a = (square * moment - mean * product) / (determinant + TINY)
    b = (total * product - mean * moment) / (determinant + TINY)
    if a < 0.0:
        return 0.0, max(float(product / (square + TINY)), 0.0)
    return (float(a), float(b)) if b > 0.0 else (float(moment / total), 0.0)
