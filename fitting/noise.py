"""How finely a cloud is written down, and how far points scatter about a surface."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fitting.geometry import TINY, Array

DECIMALS = range(0, 10)
"""Coordinates that are multiples of 10^-k for such a k are taken for quantised."""

COARSEST_STEPS = 64
"""A decimal step is a rounding if the cloud is at least this many steps wide; else it is a lattice."""

LEAST_EXACT = 0.03
"""Smallest share of a cloud that counts as an exact subset."""

MIXTURE_POINTS = 2048
MIXTURE_ROUNDS = 20
"""Distances that a mixture is found from, and the rounds of doing so."""

LEAST_OUTLIERS, MOST_OUTLIERS = 1e-4, 0.7
"""Bounds of the share of outliers in a mixture: at 0 a single outlier would have no likelihood at all."""

TRIM = 2.5
TRIMMED_DEVIATION = 0.9545975
"""Standard deviation of a unit normal variable cut at +-TRIM."""


def resolution(points: Array) -> float:
    """Size of the rounding in the coordinates, in their unit: no distance below it means anything.

    The largest of: 64 units in the last place of float64, 4 of float32 if every coordinate of a sample
    is a float32 number, and the decimal step if every coordinate of a sample is a multiple of one.
    """
    largest = float(np.max(np.abs(points)))
    extent = float(np.max(np.ptp(points, axis=0)))
    sample = points[:: max(1, len(points) // 256)]
    rounding = 64.0 * float(np.finfo(np.float64).eps) * largest
    with np.errstate(over="ignore"):
        if np.array_equal(sample.astype(np.float32).astype(np.float64), sample):
            rounding = max(rounding, 4.0 * float(np.finfo(np.float32).eps) * largest)
    for decimals in DECIMALS:
        step = 10.0**-decimals
        if step <= 10.0 * rounding:
            break
        multiples = sample / step
        if np.all(np.abs(multiples - np.round(multiples)) <= 1e-6 + rounding / step):
            return max(rounding, step) if extent >= COARSEST_STEPS * step else rounding
    return rounding


def trimmed_scale(distance: Array) -> float:
    """Standard deviation of the core of absolute distances, shape (N,); outliers do not reach it.

    Starts at the normalised median absolute distance and trims at `TRIM` standard deviations until that
    changes nothing, corrected to be consistent for a normal distribution.
    """
    scale = 1.4826 * float(np.median(distance))
    for _ in range(20):
        core = distance[distance <= TRIM * scale]
        if len(core) == 0 or scale == 0.0:
            return scale
        new_scale = float(np.sqrt(np.mean(core**2))) / TRIMMED_DEVIATION
        if abs(new_scale - scale) <= 1e-3 * scale:
            return new_scale
        scale = new_scale
    return scale


def exact_points(distance: Array, tolerance: float, dof: int) -> np.ndarray:
    """Mask (N,) of the points that lie on the surface as exactly as the coordinates can say.

    Empty where that many could lie there by accident: unless it is all of them, there must be at least
    four times the points that determine the surface, `LEAST_EXACT` of the cloud, and five times what the
    density of points between one and ten tolerances lets expect.
    """
    mask = distance <= tolerance
    if mask.all():
        return mask
    count = int(mask.sum())
    nearby = int((distance <= 10.0 * tolerance).sum()) - count
    if count >= max(4 * dof, LEAST_EXACT * len(distance)) and count > 5.0 * nearby / 9.0:
        return mask
    return np.zeros_like(mask)


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

        Of many distances every k-th is taken, at least `MIXTURE_POINTS` and fewer than twice as many.
        `smallest` is the least scale, `width` the range over which outliers are uniform.
        Source: Dempster, Laird and Rubin, JRSS B 39, 1977; outliers so modelled in Torr and Zisserman,
        "MLESAC", CVIU 78, 2000.
        """
        few = distance[:: -(-len(distance) // MIXTURE_POINTS)] ** 2
        scale = max(1.4826 * float(np.sqrt(np.median(few))), smallest)
        share = 0.05
        for _ in range(MIXTURE_ROUNDS):
            surface = (1.0 - share) * _normal(few, scale)
            belongs = surface / (surface + share / width)
            total = float(belongs.sum())
            scale = max(float(np.sqrt(belongs @ few / max(total, TINY))), smallest)
            share = min(max(1.0 - total / len(few), LEAST_OUTLIERS), MOST_OUTLIERS)
        likelihood = np.log((1.0 - share) * _normal(distance**2, scale) + share / width)
        return cls(scale, share, float(likelihood.sum()))


def _normal(squared: Array, scale: float) -> Array:
    density: Array = np.exp(-0.5 * squared / scale**2) / (scale * np.sqrt(2.0 * np.pi))
    return density
