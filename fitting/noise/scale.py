"""How far points scatter about a surface: the scale of the core of their distances."""

import numpy as np

from ..geometry.vectors import Array
from . import _noise
from .kernels import CUTOFF, Kernel, biweight_deviation
from .rounding import ULPS

CORE = 3.0
"""Distances beyond so many scales have no weight in the scale."""

SCALE_AT_REST = ULPS * float(np.finfo(np.float64).eps)
"""Relative change of a scale that ends its rounds."""


CORE_DEVIATION = biweight_deviation(CORE)
"""Standard deviation of a unit normal variable under the weights of `core_scale`."""


def core_scale(distance: Array) -> float:
    """Standard deviation of the core of absolute distances, shape (N,); outliers hardly reach it.

    From the normalized median absolute distance on, distances x are weighted by (1 - (x / CORE / scale)^2)^2
    until the scale rests, corrected to be consistent for a normal distribution. It changes smoothly with the
    distances, so what is fitted at this scale does not depend on the way there.
    """
    return _noise.core_scale(np.ascontiguousarray(distance), CORE, CORE_DEVIATION, SCALE_AT_REST)


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
