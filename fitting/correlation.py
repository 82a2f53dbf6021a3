"""How the noise of neighbours on a surface agrees: a variogram, and a correlation function fitted to it.

Differences between close points keep what a fit took up of smooth noise out of the variogram
gamma(h) = 1/2 E (z_i - z_j)^2,  which correlations of residuals do not.
Source: Cressie, "Statistics for spatial data", 1993, sections 2.4 and 2.6.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import pdist

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
CLOSEST = 20
"""Bins of the variogram, each as much wider as it is farther, and how many pairs are in the first."""

BLOCK = 8192
"""Pairs that are put into them at a time: fresh memory for all would take longer than the arithmetic."""

LENGTHS = 24
POWERS = (1, 2)
REACH = 0.35
"""Distances, in sizes of the cloud, up to which the variogram is taken and correlation lengths are tried."""

VANISHED = 700.0
"""Beyond it exp(-x) is denormal, which takes a processor long."""


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
        result = distance / self.length
        result **= self.power
        np.minimum(result, VANISHED, out=result)
        np.exp(np.negative(result, out=result), out=result)
        result *= self.variance * self.share
        return result


def correlation_of(feet: Array, values: Array, order: np.ndarray) -> tuple[Correlation, Array] | None:
    """The correlation of values (N,) at points (N, 3) of a surface, or None where it is not significant.

    `order` (S,) holds indices of the points in random order. Beside the correlation are the distances between
    all pairs of the first `PAIRED` of them, in the order of `pdist`.
    """
    tree = cKDTree(feet, leafsize=32, balanced_tree=False, compact_nodes=False)
    anchors = order[:ANCHORS]
    anchors = anchors[np.argsort(feet[anchors, 0])]  # queries that follow on near ones are faster
    most = min(NEIGHBOURS[-1] + 1, len(feet))
    distance, other = tree.query(feet[anchors], k=most)
    distance, other = distance[:, 1:], other[:, 1:]
    products = values[anchors, None] * values[other]
    if not any(_stands_out(products[:, :count]) for count in NEIGHBOURS):
        return None
    chosen = order[:PAIRED]
    near, far = other.size, len(chosen) * (len(chosen) - 1) // 2
    pairs = np.empty((2, near + far))
    pairs[0, :near], pairs[1, :near] = (
        distance.ravel(),
        ((values[anchors, None] - values[other]) ** 2).ravel(),
    )
    apart = pdist(feet[chosen], out=pairs[0, near:])
    pdist(values[chosen, None], "sqeuclidean", out=pairs[1, near:])
    found = _fitted(pairs)
    return None if found is None else (found, apart)


def _stands_out(products: Array) -> bool:
    """Whether products of neighbours are positive on the average by more than chance."""
    error = float(np.sqrt(np.sum(products**2)))
    return float(products.sum()) > SIGNIFICANT * error


def _fitted(pairs: Array) -> Correlation | None:
    """Weighted least squares of  nugget + sill (1 - exp(-(h / L)^p))  over lengths L and powers p.

    `pairs` (2, N) holds distances and squared differences.
    """
    reach = REACH * float(pairs[0].max())
    pairs = pairs.take(np.flatnonzero((pairs[0] > 0.0) & (pairs[0] < reach)), axis=1)
    if pairs.shape[1] <= CLOSEST:
        return None
    below, above = np.partition(pairs[0], (CLOSEST - 1, CLOSEST))[CLOSEST - 1 : CLOSEST + 1]
    shortest = float(above - (above - below) * CLOSEST / pairs.shape[1])
    count, height, gamma = _binned(pairs, shortest, reach)
    weight = np.sqrt(count)
    lengths = np.geomspace(shortest, reach, LENGTHS)
    ratio = height / lengths[:, None]
    model = 1.0 - np.exp(-np.concatenate([ratio**power for power in POWERS]))
    nugget, sill = _two_positive(model, gamma, weight)
    cost = (nugget[:, None] + sill[:, None] * model - gamma) ** 2 @ weight
    best = int(np.argmin(np.where(sill > 0.0, cost, np.inf)))
    if not sill[best] > 0.0:
        return None
    power, length = divmod(best, LENGTHS)
    variance = float(nugget[best] + sill[best])
    return Correlation(float(lengths[length]), float(sill[best]) / variance, POWERS[power], variance)


def _binned(pairs: Array, shortest: float, reach: float) -> Array:
    """Of the bins with pairs in them their number, mean distance and half the mean square, (3, B)."""
    sums, steps = np.zeros((3, BINS)), (BINS - 1) / np.log(reach / shortest)
    for first in range(0, pairs.shape[1], BLOCK):
        distance, square = pairs[:, first : first + BLOCK]
        place = np.clip(np.ceil(steps * np.log(distance / shortest)), 0, BINS - 1).astype(np.intp)
        sums += [np.bincount(place, weights, BINS) for weights in (None, distance, square)]
    count, height, gamma = sums[:, sums[0] > 0.0]
    return np.array([count, height / count, gamma / (2.0 * count)])


def _two_positive(models: Array, target: Array, weight: Array) -> tuple[Array, Array]:
    """Weighted least squares of  a + b model = target  for models (K, B), with a and b (K,) not negative."""
    total, mean = weight.sum(), models @ weight
    square, moment, product = models**2 @ weight, weight @ target, models @ (weight * target)
    determinant = total * square - mean**2 + TINY
    a = (square * moment - mean * product) / determinant
    b = (total * product - mean * moment) / determinant
    through_zero = np.maximum(product / (square + TINY), 0.0)
    level = np.where(b > 0.0, a, moment / total)
    return np.where(a < 0.0, 0.0, level), np.where(a < 0.0, through_zero, np.maximum(b, 0.0))
