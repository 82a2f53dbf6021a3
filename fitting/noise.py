"""How finely a cloud is written down, and how far points scatter about a surface."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fitting import _descent
from fitting.geometry import TINY, Array

DECIMALS = range(0, 16)
"""Coordinates that are multiples of 10^-k for such a k are taken for quantised."""

COARSEST_STEPS = 64
"""A step is a rounding if the cloud is at least this many steps wide; else it is a lattice."""

COARSER = 10.0
"""A step is more than so many times the rounding of the number format."""

SEEN_POINTS = 256
"""Points that a step is found from."""

LEAST_EXACT = 0.03
"""Smallest share of a cloud that counts as an exact subset."""

COARSEST_EXACT = 1e-3
"""Rounding, in the normalised frame, beyond which points near a surface do not count as exact: a wrong one
may be as near."""

MIXTURE_POINTS = 1024
"""Distances that a mixture is found from, at most."""

MIXTURE_ROUNDS = 40
"""Rounds of expectation maximisation, at most."""

MIXTURE_STARTS = {0.2: 0.2533, 0.5: 0.6745}
"""Shares of the distances that the scale is started from, with what a unit normal variable has there.

From the median alone, more than half of outliers pass for wide noise."""

LEAST_OUTLIERS, MOST_OUTLIERS = 1e-4, 0.7
"""Bounds of the share of outliers in a mixture: at 0 a single outlier would have no likelihood at all."""

HEAVY = 2.0
"""Standard errors by which the kurtosis of noise with heavy tails is above that of normal noise."""

PEAK = 2.0
"""Standard deviations by which a peak must stand out."""

CORE = 3.0
"""Distances beyond so many scales have no weight in the scale."""

CORE_DEVIATION = 0.7952401018
"""Standard deviation of a unit normal variable under the weights (1 - (x / CORE)^2)^2."""

FEWEST_PARAMETERS = 3
"""Those of a plane: where chance is reckoned with, kinds most of whose parameters are fixed have as many."""

SCALE_AT_REST = 1e-14
"""Relative change of a scale that ends its rounds."""


ROUNDING_NOISE = 0.3
"""Standard deviation of a rounded coordinate, in steps: 1 / sqrt 12."""


@dataclass(frozen=True)
class Rounding:
    """How finely coordinates are written down, in their unit.

    Attributes
    ----------
    size : no distance below it means anything. The largest of: 64 units in the last place of float64, 4 of
        float32 if every coordinate of a sample is a float32 number, and the step
    step : the largest that the decimal coordinates of a sample differ by multiples of, or None
    """

    size: float
    step: float | None


def rounding_of(points: Array) -> Rounding:
    """The rounding of coordinates (N, 3)."""
    largest = float(np.max(np.abs(points)))
    extent = float(np.max(np.ptp(points, axis=0)))
    sample = points[_spread_out(len(points))]
    double = rounding = 64.0 * float(np.finfo(np.float64).eps) * largest
    with np.errstate(over="ignore"):
        if np.array_equal(sample.astype(np.float32).astype(np.float64), sample):
            rounding = max(rounding, 4.0 * float(np.finfo(np.float32).eps) * largest)
    step = _step_of(sample, double)
    if step is None or step <= COARSER * rounding or extent < COARSEST_STEPS * step:
        return Rounding(rounding, None)
    return Rounding(step, step)


def _spread_out(n: int) -> np.ndarray:
    """Indices of at most `SEEN_POINTS` of n points, in golden sections: no grid has their period."""
    if n <= SEEN_POINTS:
        return np.arange(n)
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    return (np.arange(SEEN_POINTS) * golden % 1.0 * n).astype(np.intp)


def _step_of(sample: Array, rounding: float) -> float | None:
    """The largest step of decimal coordinates (N, 3), the greatest common divisor of their differences."""
    for decimals in DECIMALS:
        unit = 10.0**-decimals
        if unit <= COARSER * rounding:
            break
        multiples = sample / unit
        whole = np.round(multiples)
        if np.all(np.abs(multiples - whole) <= 1e-6 + rounding / unit):
            units = int(np.gcd.reduce((whole - whole[0]).astype(np.int64), axis=None))
            return units / 10**decimals or None
    return None


def core_scale(distance: Array) -> float:
    """Standard deviation of the core of absolute distances, shape (N,); outliers hardly reach it.

    From the normalised median absolute distance on, distances x are weighted by (1 - (x / CORE / scale)^2)^2
    until the scale rests, corrected to be consistent for a normal distribution. It changes smoothly with the
    distances, so what is fitted at this scale does not depend on the way there.
    """
    return _descent.core_scale(np.ascontiguousarray(distance), CORE, CORE_DEVIATION, SCALE_AT_REST)


def exact_points(distance: Array, tolerance: float, dof: int) -> np.ndarray:
    """Mask (N,) of the points that lie on the surface as exactly as the coordinates can say.

    Empty where that many could lie there by accident: unless it is all of them, there must be at least
    four times the points that determine the surface, `LEAST_EXACT` of the cloud, and five times what the
    density of points between one and ten tolerances lets expect. Empty, too, where the tolerance is coarse.
    """
    mask, dof = distance <= tolerance, max(dof, FEWEST_PARAMETERS)
    if tolerance > COARSEST_EXACT:
        return np.zeros_like(mask)
    if mask.all():
        return mask
    count = int(mask.sum())
    nearby = int((distance <= 10.0 * tolerance).sum()) - count
    if count >= max(4 * dof, LEAST_EXACT * len(distance)) and count > 5.0 * nearby / 9.0:
        return mask
    return np.zeros_like(mask)


def is_peaked(distance: Array, dof: int) -> bool:
    """Whether more of the distances (N,) are near 0 than a smooth density has there.

    That is what an exact subset looks like from a surface that is off by the uncertainty of its `dof`
    parameters: compared are the points within twice that and those within three times as much.
    """
    absolute = np.abs(distance)
    near = 2.0 * core_scale(absolute) * float(np.sqrt(dof / len(absolute)))
    inside = int(np.count_nonzero(absolute <= near))
    around = int(np.count_nonzero(absolute <= 3.0 * near)) - inside
    return inside - around / 2.0 > PEAK * np.sqrt(inside + around / 4.0 + 1.0)


def is_normal(distance: Array, largest: float) -> bool:
    """Whether the tails of distances (N,) are no heavier than normal ones, and none is beyond the largest.

    Heavier is a kurtosis that is `HEAVY` standard errors, each sqrt(24 / N), above 3, as that of noise whose
    scale differs from point to point.
    Source: Fisher, "The moments of the distribution for normal samples", Proc. R. Soc. A 130, 1930.
    """
    squared = distance**2
    mean = float(squared.mean())
    if mean == 0.0 or squared.max() > largest**2:
        return False
    kurtosis = float(np.mean(squared**2)) / mean**2
    return kurtosis <= 3.0 + HEAVY * float(np.sqrt(24.0 / len(squared)))


@dataclass(frozen=True)
class NoiseModel:
    """Distances as a mixture: normal with mean 0 and `scale`, but an `outlier_share` uniform in the cloud.

    `log_likelihood` is that of all distances.
    """

    scale: float
    outlier_share: float
    log_likelihood: float

    @classmethod
    def of(cls, distance: Array, smallest: float, width: float) -> Self:
        """The most likely mixture, by expectation maximisation on distances (N,).

        Of more than `MIXTURE_POINTS` distances every k-th is taken, at least half as many.
        `smallest` is the least scale, `width` the range over which outliers are uniform.
        Source: Dempster, Laird and Rubin, JRSS B 39, 1977; outliers so modelled in Torr and Zisserman,
        "MLESAC", CVIU 78, 2000.
        """
        few = distance[:: -(-len(distance) // MIXTURE_POINTS)] ** 2
        starts = [
            float(np.sqrt(np.quantile(few, share, method="lower"))) / size
            for share, size in MIXTURE_STARTS.items()
        ]
        mixtures = [_maximized(few, max(start, smallest), smallest, width) for start in starts]
        scale, share = max(mixtures, key=lambda mixture: _log_likelihood(few, mixture, width))
        return cls(scale, share, _log_likelihood(distance**2, (scale, share), width))


def _maximized(squared: Array, scale: float, smallest: float, width: float) -> tuple[float, float]:
    """The scale and the share of outliers of the mixture that expectation maximisation comes to."""
    share = 0.05
    for _ in range(MIXTURE_ROUNDS):
        surface = (1.0 - share) * _normal(squared, scale)
        belongs = surface / (surface + share / width)
        total, before = float(belongs.sum()), scale
        scale = max(float(np.sqrt(belongs @ squared / max(total, TINY))), smallest)
        share = min(max(1.0 - total / len(squared), LEAST_OUTLIERS), MOST_OUTLIERS)
        if abs(scale - before) <= 1e-3 * scale:
            break
    return scale, share


def _log_likelihood(squared: Array, mixture: tuple[float, float], width: float) -> float:
    scale, share = mixture
    return float(np.log((1.0 - share) * _normal(squared, scale) + share / width).sum())


def _normal(squared: Array, scale: float) -> Array:
    density: Array = np.exp(-0.5 * squared / scale**2) / (scale * np.sqrt(2.0 * np.pi))
    return density
