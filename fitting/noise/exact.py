"""Points that lie on a surface as exactly as their coordinates can say: that many by no accident."""

import math

import numpy as np

from ..geometry.vectors import Array
from .scale import core_scale

AROUND = 3.0
"""Where many are near a surface, they are held against those between that distance and this many times it."""


def exact_points(distance: Array, tolerance: float, dof: int) -> np.ndarray:
    """Mask (N,) of the points that lie on the surface as exactly as the coordinates can say.

    Empty where that many could lie there by accident: unless it is all of them, those that the surface was
    not made to pass through must be twice those between one tolerance and two, and two standard deviations
    of chance more.
    """
    mask = distance <= tolerance
    inside = int(np.count_nonzero(mask))
    if inside == len(mask):
        return mask
    chance = 2.0 * math.sqrt(inside)
    if inside - dof > chance:  # most often it is not, and nothing else is counted
        around = int(np.count_nonzero(distance <= 2.0 * tolerance)) - inside
        if inside - dof > 2.0 * around + chance:
            return mask
    return np.zeros(len(mask), bool)


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
