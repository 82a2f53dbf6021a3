"""How finely a cloud is written down: the rounding of its coordinates, and their decimal step."""

from dataclasses import dataclass
from decimal import Decimal
from itertools import count

import numpy as np

from ..geometry.vectors import Array

ULPS = 32
"""Units in the last place of the largest coordinate that rounding may put a point off its surface, twice what
is seen in the clouds of SHREC 2022: to store it takes one, the others come from how it was computed."""

COARSEST_STEPS = 1000
"""A rounding is fine if the cloud is this many times as wide. A coarser one is noise, or the step of a
lattice: a wrong surface may be as near."""

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
