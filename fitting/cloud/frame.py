"""The frame in which everything is estimated: centred at the centroid, scaled to an extent near 1."""

from dataclasses import dataclass
from typing import Self, TypeVar

import numpy as np

from ..geometry.vectors import Array
from ..primitives.primitive import Primitive

P = TypeVar("P", bound=Primitive)


@dataclass(frozen=True)
class Frame:
    r"""x_frame = (x - center) / scale. `scale` is a power of two, so scaling rounds nothing."""

    center: Array
    scale: float

    @classmethod
    def of(cls, points: Array) -> Self:
        """The frame whose origin is the centroid and whose scale is near the rms distance to it.

        The centroid is rounded to a multiple of the coarsest spacing of the coordinates, so that
        subtracting it is exact, too.
        """
        lowest, highest = points.min(axis=0), points.max(axis=0)
        middle = lowest / 2.0 + highest / 2.0
        half = float(np.max(highest / 2.0 - lowest / 2.0))
        if half == 0.0:
            return cls(middle, 1.0)
        unit_offsets = (points - middle) / half
        centroid = unit_offsets.mean(axis=0)
        rms = half * float(np.sqrt(np.mean(np.sum((unit_offsets - centroid) ** 2, axis=1))))
        center = middle + half * centroid
        spacing = np.spacing(np.max(np.abs([lowest, highest]), axis=0))
        return cls(np.round(center / spacing) * spacing, float(2.0 ** np.round(np.log2(rms))))

    def normalize(self, points: Array) -> Array:
        return (points - self.center) / self.scale

    def bring(self, primitive: P) -> P:
        """A primitive in the units of the input in this frame."""
        return primitive.transformed(np.eye(3), -self.center / self.scale, 1.0 / self.scale)

    def restore(self, primitive: P) -> P:
        """A primitive of this frame in the units of the input."""
        return primitive.transformed(np.eye(3), self.center, self.scale)
