"""The right circular cylinder: an axis line and a radius.

Signed distance, with the unit axis a, a point p of it and the radius r:  d(x) = rho - r, where
h = a . (x - p), q = (x - p) - h a and rho = |q|.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ..geometry.turning import bent_straight
from ..geometry.vectors import (
    TINY,
    Array,
    around_axis,
    basis,
    canonical_direction,
    cylindrical,
    foot_of_origin,
    rows,
    unit,
    vector,
)
from ..guesses import _guesses
from ..guesses.oriented import ROUNDS, Oriented
from .primitive import NO_ROWS, Chart, Known, Limited, Number, Primitive

PLANE_LIKE = 5.0
"""A radius beyond this many extents asks for a look at the plane."""


@dataclass(frozen=True, eq=False)
class Cylinder(Primitive):
    """An endless circular cylinder; signed distances are positive outside.

    Attributes
    ----------
    axis : (3,) unit vector
    point : (3,) on the axis; in an answer the one closest to the centroid of the cloud

    Examples
    --------
    >>> import numpy as np, primfit
    >>> cylinder = primfit.Cylinder(axis=[0, 0, 1], point=[0, 0, 0], radius=2.0)
    >>> cylinder.signed_distance(np.array([[2.5, 0.0, 7.0]]))
    array([0.5])
    """

    axis: Array
    point: Array
    radius: float

    kind: ClassVar[str] = "cylinder"
    dof: ClassVar[int] = 5
    chart: ClassVar[Chart] = Chart(
        tilts=(0, 1), shifts=(2, 3), across=((0, 1), (2, 3)), numbers={"radius": Number(4, 8)}
    )
    form: ClassVar[str] = "cylindricity"
    has_sign: ClassVar[bool] = False

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
    def initial_guesses(cls, oriented: Oriented, rng: np.random.Generator) -> Array:
        return cls.rows_about(oriented.directions, oriented.points)

    @classmethod
    def rows_about(cls, directions: Array, points: Array, rounds: int = ROUNDS) -> Array:
        """For each direction (K, 3) the circle through the points (N, 3) as seen along it."""
        return _guesses.cylinders(np.ascontiguousarray(directions), np.ascontiguousarray(points), rounds)

    @staticmethod
    def impose(row: Array, points: Array, limits: Limited) -> None:
        """Bring a row (9,) within limits, as near to the points (N, 3) as a linear step brings it."""
        row[3:6] = foot_of_origin(row[3:6], row[:3])
        radial, rho, _ = around_axis(points, row[3:6], row[:3])
        if limits.pinned:
            row[8] = np.median(rho)
        grown = limits.clip(row, 8)
        if not limits.pinned:
            row[3:6] -= grown * (radial / (rho + TINY)[:, None]).mean(axis=0)

    def bent_row(self, step: Array) -> Array | None:
        """By its curvature 1 / r."""
        return bent_straight(self.row(), step, is_cone=False)

    def bends(self, feet: Array) -> list[tuple[tuple[str, ...], Array]]:
        """A slender cone leaves it by a taper, a wide torus by a bend of the axis."""
        radial, rho, height = around_axis(feet, self.point, self.axis)
        height -= height.mean()
        around = np.array(basis(self.axis)) @ (radial / (rho + TINY)[:, None]).T
        return [(("cone",), height[:, None]), (("torus",), (height * height * around).T)]

    def coordinates(self, feet: Array, extent: float) -> list[tuple[Array, float]]:
        azimuth, _, height = cylindrical(feet, self.point, self.axis)
        return [(azimuth, 2.0 * np.pi), (height / extent, 0.0)]

    @classmethod
    def guesses_given(cls, known: Known, oriented: Oriented, rng: np.random.Generator) -> Array:
        if known.direction is None:
            return NO_ROWS
        return cls.rows_about(known.direction[None], oriented.points)

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
