"""How finely a cloud is written down, and how far points scatter about a surface."""

from dataclasses import dataclass
from decimal import Decimal
from itertools import count
from typing import Self

import numpy as np
from scipy.integrate import quad
from scipy.special import xlogy

from fitting import _descent
from fitting.geometry import Array
from fitting.kernels import CUTOFF, Kernel

ULPS = 32
"""Units in the last place of the largest coordinate that rounding may put a point off its surface, twice what
is seen in the clouds of SHREC 2022: to store it takes one, the others come from how it was computed."""

COARSEST_STEPS = 1000
"""A rounding is fine if the cloud is this many times as wide. A coarser one is noise, or the step of a
lattice: a wrong surface may be as near."""

AROUND = 3.0
"""Where many are near a surface, they are held against those between that distance and this many times it."""

CORE = 3.0
"""Distances beyond so many scales have no weight in the scale."""

SCALE_AT_REST = ULPS * float(np.finfo(np.float64).eps)
"""Relative change of a scale that ends its rounds."""

ROUNDING_NOISE = 0.3
"""Standard deviation of a rounded coordinate, in steps: 1 / sqrt 12."""


def _core_deviation() -> float:
    """Standard deviation of a unit normal variable under the weights (1 - (x / CORE)^2)^2."""

    def weight(x: float) -> float:
        return float((1.0 - (x / CORE) ** 2) ** 2 * np.exp(-0.5 * x**2))

    squares, weights = (quad(law, 0.0, CORE)[0] for law in (lambda x: x**2 * weight(x), weight))
    return float(np.sqrt(squares / weights))


CORE_DEVIATION = _core_deviation()
"""Standard deviation of a unit normal variable under the weights of `core_scale`."""


@dataclass(frozen=True)
class Rounding:
    """How finely coordinates are written down, in their unit.

    Attributes
    ----------
    size : no distance below it means anything. The largest that is fine of `ULPS` units in the last place of
        float64, as many of float32 if every coordinate is a float32 number, and the step
    step : the largest that decimal coordinates differ by multiples of, or None
    """

    size: float
    step: float | None


def rounding_of(points: Array) -> Rounding:
    """The rounding of coordinates (N, 3)."""
    double, single = (ULPS * float(np.finfo(each).eps * np.abs(points).max()) for each in (float, np.float32))
    with np.errstate(over="ignore"):
        rounding = single if np.array_equal(points.astype(np.float32), points) else double
    step = _step_of(points, double)
    if step is not None and step <= rounding:
        step = None
    finest = max(float(np.ptp(points, axis=0).max()) / COARSEST_STEPS, double)
    return Rounding(max(size for size in (double, rounding, step or 0.0) if size <= finest), step)


def _step_of(points: Array, rounding: float) -> float | None:
    """The largest step of decimal coordinates (N, 3), the greatest common divisor of their differences.

    They have the fewest decimals that all of them are multiples of, within their rounding.
    """
    for decimals in count():
        exact = Decimal(1).scaleb(-decimals)
        if exact <= 2.0 * rounding:
            return None
        unit = float(exact)
        if _are_multiples(points[:1], unit, rounding) and _are_multiples(points, unit, rounding):
            whole = np.rint(points / unit).astype(np.int64)
            units = int(np.gcd.reduce(whole - whole[0], axis=None))
            return float(units * exact) or None
    return None


def _are_multiples(points: Array, unit: float, rounding: float) -> bool:
    return bool(np.all(np.abs(points - unit * np.rint(points / unit)) <= rounding))


def core_scale(distance: Array) -> float:
    """Standard deviation of the core of absolute distances, shape (N,); outliers hardly reach it.

    From the normalised median absolute distance on, distances x are weighted by (1 - (x / CORE / scale)^2)^2
    until the scale rests, corrected to be consistent for a normal distribution. It changes smoothly with the
    distances, so what is fitted at this scale does not depend on the way there.
    """
    return _descent.core_scale(np.ascontiguousarray(distance), CORE, CORE_DEVIATION, SCALE_AT_REST)


def exact_points(distance: Array, tolerance: float, dof: int) -> np.ndarray:
    """Mask (N,) of the points that lie on the surface as exactly as the coordinates can say.

    Empty where that many could lie there by accident: unless it is all of them, those that the surface was
    not made to pass through must be twice those between one tolerance and two, and two standard deviations
    of chance more.
    """
    mask = distance <= tolerance
    inside = int(np.count_nonzero(mask))
    around = int(np.count_nonzero(distance <= 2.0 * tolerance)) - inside
    if inside == len(mask) or inside - dof > 2.0 * (around + np.sqrt(inside)):
        return mask
    return np.zeros_like(mask)


def is_peaked(distance: Array, dof: int) -> bool:
    """Whether more of the distances (N,) are near 0 than a smooth density has there.

    That is what an exact subset looks like from a surface that is off by the uncertainty of its `dof`
    parameters: more points are within twice that than the density `AROUND` it lets expect, by two standard
    deviations.
    """
    absolute = np.abs(distance)
    near = 2.0 * core_scale(absolute) * float(np.sqrt(dof / len(absolute)))
    inside = int(np.count_nonzero(absolute <= near))
    around = int(np.count_nonzero(absolute <= AROUND * near)) - inside
    share = 1.0 / (AROUND - 1.0)
    return inside - share * around > 2.0 * float(np.sqrt(inside + share**2 * around + 1.0))


def is_normal(distance: Array, largest: float) -> bool:
    """Whether nothing of distances (N,) is to be rejected, as of normal noise.

    So it is where none is beyond the largest, and least squares has no more variance on them than the
    biweight that is cut off there. The variance is the mean square of the pulls over the square of their mean
    slope.
    Source: Huber, "Robust estimation of a location parameter", Annals Math. Stat. 35, 1964, section 4.
    """
    squared = (CUTOFF / largest * distance) ** 2
    mean = float(squared.mean())
    if mean == 0.0 or squared.max() > CUTOFF**2:
        return False
    pulls = Kernel.TUKEY.weight(squared) ** 2 * squared
    slope = float(Kernel.TUKEY.slope(squared).mean())
    return mean * slope**2 <= float(pulls.mean())


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
        """The most likely mixture of distances (N,) of which the k smallest are noise, for some k.

        `smallest` is the least scale, `width` the range over which outliers are uniform.
        Source: Celeux and Govaert, "A classification EM algorithm", Comput. Stat. Data Anal. 14, 1992, the
        criterion C2; outliers so modelled in Torr and Zisserman, "MLESAC", CVIU 78, 2000.
        """
        squared = np.sort(distance**2)
        sums, many = np.cumsum(squared), len(squared)
        noise = np.arange(1, many + 1)
        scales, outliers = np.maximum(np.sqrt(sums / noise), smallest), many - noise
        normal = xlogy(noise, noise / (many * scales * np.sqrt(2.0 * np.pi))) - 0.5 * sums / scales**2
        best = int(np.argmax(normal + xlogy(outliers, outliers / (many * width))))
        scale, share = float(scales[best]), float(outliers[best]) / many
        density = np.exp(-0.5 * squared / scale**2) / (scale * np.sqrt(2.0 * np.pi))
        return cls(scale, share, float(np.log((1.0 - share) * density + share / width).sum()))
