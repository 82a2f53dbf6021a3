"""The frame in which everything is estimated: centered at the centroid, scaled to an extent near 1."""

import math
from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np

from ..geometry.vectors import Array, bounds
from ..primitives.primitive import Primitive
from ..words import figure
from . import _passes

P = TypeVar("P", bound=Primitive)


@dataclass(frozen=True)
class Frame:
    r"""x_frame = (x - center) / scale. `scale` is a power of two, so scaling rounds nothing.

    `unit` is the name of the unit of the input, where one was given: words about lengths have it.
    """

    center: Array
    scale: float
    unit: str | None = None

    @classmethod
    def of(cls, points: Array, box: Array | None = None, unit: str | None = None) -> Self:
        """The frame whose origin is the centroid and whose scale is near the rms distance to it.

        The centroid is rounded to a multiple of the coarsest spacing of the coordinates, so that
        subtracting it is exact, too. The box (2, 3) around them is found if it is not known.
        """
        lowest, highest = box = bounds(points) if box is None else box
        middle = lowest / 2.0 + highest / 2.0
        half = float(np.max(highest / 2.0 - lowest / 2.0))
        if half == 0.0:
            return cls(middle, 1.0, unit)
        centroid, mean_square = _passes.moments(np.ascontiguousarray(points, np.float64), middle, half)
        center = middle + half * centroid
        spacing = np.spacing(np.abs(box).max(axis=0))
        exponent = round(math.log2(half * math.sqrt(mean_square)))
        return cls(np.round(center / spacing) * spacing, math.ldexp(1.0, exponent), unit)

    def normalize(self, points: Array) -> Array:
        """Points (..., 3) of the input in this frame."""
        flat = np.ascontiguousarray(points, np.float64).reshape(-1, 3)
        return _passes.normalized(flat, self.center, self.scale).reshape(points.shape)

    def bring(self, primitive: P) -> P:
        """A primitive in the units of the input in this frame."""
        return primitive.transformed(np.eye(3), -self.center / self.scale, 1.0 / self.scale)

    def told(self, length: float) -> str:
        """A length of this frame in words, in the unit of the input."""
        return figure(self.scale * length, self.unit)

    def restore(self, primitive: P) -> P:
        """A primitive of this frame in the units of the input."""
        return primitive.transformed(np.eye(3), self.center, self.scale)
