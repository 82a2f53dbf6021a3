"""How finely a cloud is written down, and how far points scatter about a surface."""

import numpy as np

from fitting.geometry import Array

DECIMALS = range(0, 10)
"""Coordinates that are multiples of 10^-k for such a k are taken for quantised."""

COARSEST_STEPS = 64
"""A decimal step is a rounding if the cloud is at least this many steps wide; else it is a lattice."""

LEAST_EXACT = 0.03
"""Smallest share of a cloud that counts as an exact subset."""

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
