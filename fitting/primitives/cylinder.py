"""The right circular cylinder: an axis line and a radius.

Signed distance, with the unit axis a, a point p of it and the radius r:  d(x) = rho - r, where
h = a . (x - p), q = (x - p) - h a and rho = |q|.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ..geometry.axes import Seen, axis_directions, circles
from ..geometry.vectors import (
    TINY,
    Array,
    around_axis,
    basis,
    canonical_direction,
    foot_of_origin,
    rows,
    unit,
    vector,
)

PLANE_LIKE = 5.0
"""A radius beyond this many extents asks for a look at the plane."""


@dataclass(frozen=True, eq=False)
class Cylinder:
    """An endless circular cylinder; signed distances are positive outside.

    Attributes
    ----------
    axis : (3,) unit vector
    point : (3,) on the axis; in an answer the one closest to the centroid of the cloud
    """

    axis: Array
    point: Array
    radius: float

    kind: ClassVar[str] = "cylinder"
    dof: ClassVar[int] = 5

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis", unit(self.axis))
        object.__setattr__(self, "point", vector(self.point))
        object.__setattr__(self, "radius", float(self.radius))

    def signed_distance(self, points: Array) -> Array:
        _, rho, _ = around_axis(points, self.point, self.axis)
        return rho - self.radius

    def gradient(self, points: Array) -> Array:
        radial, rho, _ = around_axis(points, self.point, self.axis)
        return radial / (rho + TINY)[:, None]

    def row(self) -> Array:
        return rows(self.axis, foot_of_origin(self.point, self.axis), offset=self.radius)

    @classmethod
    def from_row(cls, row: Array) -> Self:
        return cls(row[:3], row[3:6], row[8])

    def transformed(self, rotation: Array, translation: Array, scale: float) -> Self:
        return type(self)(
            rotation @ self.axis, scale * (rotation @ self.point) + translation, scale * self.radius
        )

    @classmethod
    def initial_guesses(cls, points: Array, normals: Array, rng: np.random.Generator) -> Array:
        return cls.rows_about(Seen.along(axis_directions(points, normals), points, normals))

    @classmethod
    def rows_about(cls, seen: Seen, rounds: int = 4) -> Array:
        """For each direction, the circle through the points seen along it."""
        x, y, radii = circles(seen.x, seen.y, rounds)
        return rows(seen.axes, seen.placed(x, y), offset=radii)

    def canonical(self, center: Array) -> Self:
        """Same cylinder, axis in its canonical sign, point closest to `center`."""
        return type(self)(
            canonical_direction(self.axis),
            center + foot_of_origin(self.point - center, self.axis),
            self.radius,
        )

    def simpler_kinds(self, extent: float) -> tuple[str, ...]:
        return ("plane",) if self.radius > PLANE_LIKE * extent else ()

    def surface(self, u: Array, v: Array) -> Array:
        """Points at azimuth `u` [rad] and signed height `v` from `point`."""
        u, v = np.broadcast_arrays(u, v)
        along_u, along_v = basis(self.axis)
        ring = np.multiply.outer(np.cos(u), along_u) + np.multiply.outer(np.sin(u), along_v)
        return self.point + self.radius * ring + np.multiply.outer(v, self.axis)
