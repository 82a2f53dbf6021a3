"""Points seen about an axis: angle, distance and height."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..geometry.vectors import TINY, Array, around_axis, basis, vector

NEAR_AXIS = 0.25
"""Points nearer to the axis than this share of the farthest say little about angles."""


@dataclass(frozen=True)
class Around:
    """Cylindrical coordinates: `angle` counts from `reference` towards axis x reference, as in `surface`."""

    reference: Array
    angle: Array
    rho: Array
    height: Array

    @classmethod
    def of(cls, points: Array, origin: Array, axis: Array) -> Self:
        radial, rho, height = around_axis(points, origin, axis)
        first, second = basis(axis)
        return cls(vector(first), np.arctan2(radial @ second, radial @ first), rho, height)

    @property
    def steady(self) -> np.ndarray:
        """Mask of the points whose angles count."""
        return self.rho >= NEAR_AXIS * self.rho.max()

    def share(self, start: float, span: float) -> Array:
        """How far round the arc each point is: 0 at its start, 1 at its end; others near one of them."""
        middle = start + span / 2.0
        off = np.mod(self.angle - middle + np.pi, 2.0 * np.pi) - np.pi
        return 0.5 + off / max(span, TINY)
