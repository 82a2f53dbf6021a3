"""How finely a cloud is written down: the rounding of its coordinates, and their decimal step."""

import sys
from dataclasses import dataclass
from decimal import Decimal

import numpy as np

from ..geometry.vectors import Array, bounds
from . import _noise

ULPS = 32
"""Units in the last place of the largest coordinate that rounding may put a point off its surface, twice what
is seen in the clouds of SHREC 2022: to store it takes one, the others come from how it was computed."""

COARSEST_STEPS = 1000
"""A rounding is fine if the cloud is this many times as wide. A coarser one is noise, or the step of a
lattice: a wrong surface may be as near."""

FEWEST_STEPS = 30
"""A cloud is refused that is fewer steps of its float32 coordinates wide: below, parts of cones are taken for
cylinders."""

EPS = tuple(float(np.finfo(each).eps) for each in (np.float64, np.float32))
"""Relative spacing of numbers of both sizes."""

UNITS = np.array(
    [float(f"1e-{decimals}") for decimals in range(sys.float_info.dig - sys.float_info.min_10_exp)]
)
"""Steps of coordinates of so many decimals."""

ROUNDING_NOISE = 0.3
"""Standard deviation of a rounded coordinate, in steps: 1 / sqrt 12."""


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


def rounding_of(points: Array, box: Array | None = None) -> Rounding:
    """The rounding of coordinates (N, 3); the box (2, 3) around them is found if it is not known."""
    points = np.ascontiguousarray(points, np.float64)
    box = bounds(points) if box is None else box
    double, single = (ULPS * eps * float(np.abs(box).max()) for eps in EPS)
    rounding = single if _noise.are_float32(points) else double
    step = _step_of(points, double)
    if step is not None and step <= rounding:
        step = None
    finest = max(float((box[1] - box[0]).max()) / COARSEST_STEPS, double)
    return Rounding(max(size for size in (double, rounding, step or 0.0) if size <= finest), step)


def float32_step(points: Array, box: Array) -> float | None:
    """The step of float32 numbers at the largest of the coordinates (N, 3), if that is coarse for the cloud.

    It is where all coordinates along an axis are such numbers, and the cloud is less than `COARSEST_STEPS` of
    them wide: it was stored as float32 far from the origin. The others may be no such numbers, where they
    were printed in few decimals since, but must be where this one is the same in all points. A grid of larger
    steps was not. `box` (2, 3) is that around the points.
    """
    sizes = np.abs(box).max(axis=0)
    width = float((box[1] - box[0]).max())
    for axis in np.argsort(-sizes, kind="stable"):
        if width >= COARSEST_STEPS * EPS[1] * sizes[axis]:
            break
        constant = box[0, axis] == box[1, axis]
        told = points if constant else points[:, [axis, axis, axis]]
        if not _noise.are_float32(np.ascontiguousarray(told)):
            continue
        step = float(np.spacing(np.float32(sizes[axis])))
        is_grid = not constant and not (told / step % 2.0).any()
        if not is_grid and width < COARSEST_STEPS * step:
            return step
    return None


def _step_of(points: Array, rounding: float) -> float | None:
    """The largest step of decimal coordinates (N, 3), the greatest common divisor of their differences.

    They have the fewest decimals that all of them are multiples of, within their rounding.
    """
    units = UNITS[UNITS > 2.0 * rounding]
    decimals = _noise.common_unit(points, units, rounding)
    if decimals == len(units):
        return None
    steps = _noise.common_divisor(points, float(units[decimals]))
    return float(steps * Decimal(1).scaleb(-decimals)) or None
