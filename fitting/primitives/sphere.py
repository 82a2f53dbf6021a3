"""The sphere: a center and a radius.

Signed distance, with the center c and the radius r:  d(x) = |x - c| - r.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ..geometry.turning import NEARER, inverse, turned
from ..geometry.vectors import TINY, Z_AXIS, Array, basis, rows, vector
from ..guesses import _guesses
from ..guesses.oriented import ROUNDS, Oriented, random_subsets
from .primitive import Chart, Limited, Number, Primitive

PLANE_LIKE = 5.0
"""A radius beyond this many extents asks for a look at the plane."""

RANDOM_SPHERES = 24


@dataclass(frozen=True, eq=False)
class Sphere(Primitive):
    """A sphere; signed distances are positive outside.

    Attributes
    ----------
    center : (3,)

    Examples
    --------
    >>> import numpy as np, primfit
    >>> sphere = primfit.Sphere(center=[0, 0, 0], radius=2.0)
    >>> sphere.signed_distance(np.array([[2.5, 0.0, 0.0], [0.0, 1.0, 0.0]]))
    array([ 0.5, -1. ])
    >>> sphere == primfit.Sphere(center=(0, 0, 0), radius=2)
    True
    """

    center: Array
    radius: float

    kind: ClassVar[str] = "sphere"
    dof: ClassVar[int] = 4
    chart: ClassVar[Chart] = Chart(tilts=(), shifts=(0, 1, 2), across=(), numbers={"radius": Number(3, 8)})
    form: ClassVar[str] = "sphericity"

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", vector(self.center))
        object.__setattr__(self, "radius", float(self.radius))

    def signed_distance(self, points: Array) -> Array:
        relative = points - self.center
        return np.sqrt(np.einsum("...j,...j->...", relative, relative)) - self.radius

    def gradient(self, points: Array) -> Array:
        relative = points - self.center
        return relative / (np.linalg.norm(relative, axis=1) + TINY)[:, None]

    def row(self) -> Array:
        return rows(Z_AXIS, self.center, offset=self.radius)

    @classmethod
    def from_row(cls, row: Array) -> Self:
        return cls(row[3:6], row[8])

    def transformed(self, rotation: Array, translation: Array, scale: float) -> Self:
        return type(self)(scale * (rotation @ self.center) + translation, scale * self.radius)

    @classmethod
    def initial_guesses(cls, oriented: Oriented, rng: np.random.Generator) -> Array:
        """The algebraic sphere of all points, reweighted, and those of random fours."""
        points = oriented.points
        fours = points[random_subsets(len(points), 4, RANDOM_SPHERES, rng)]
        return np.vstack([cls.rows_through(points[None]), cls.rows_through(fours, rounds=1)])

    @classmethod
    def rows_through(cls, groups: Array, rounds: int = ROUNDS) -> Array:
        """The algebraic sphere  |x|^2 = 2 c.x + b  of each of K groups of points (K, N, 3)."""
        return _guesses.spheres(np.ascontiguousarray(groups), rounds)

    @staticmethod
    def impose(row: Array, points: Array, limits: Limited) -> None:
        """Bring a row (9,) within limits, as near to the points (N, 3) as a linear step brings it."""
        relative = points - row[3:6]
        distance = np.linalg.norm(relative, axis=1)
        if limits.pinned:
            row[8] = np.median(distance)
        grown = limits.clip(row, 8)
        if not limits.pinned:
            row[3:6] -= grown * (relative / (distance + TINY)[:, None]).mean(axis=0)

    def bent_row(self, step: Array) -> Array | None:
        """By its curvature 1 / r."""
        row = self.row()
        center, radius = row[3:6], row[8]
        away = float(np.linalg.norm(center))
        distance = away - radius
        if abs(distance) > NEARER * radius or radius == 0.0:
            return None
        normal = -center / away
        frame = np.stack([normal, *basis(normal)])
        shift = frame @ step[:3]
        frame = turned(frame, np.array([0.0, shift[2], -shift[1]]) / away)
        radius = inverse((1.0 - step[3] / radius) / radius)
        distance -= shift[0] + step[3]
        return rows(row[:3], -(distance + radius) * frame[0], offset=abs(radius))

    def bends(self, feet: Array) -> list[tuple[tuple[str, ...], Array]]:
        """A torus of a small major radius leaves it by the sine of the angle from its axis, which is even:
        about by harmonics of second degree."""
        x, y, z = (feet - self.center).T / self.radius
        return [(("torus",), np.stack([x * y, y * z, z * x, x * x - y * y, y * y - z * z], axis=1))]

    def canonical(self, center: Array) -> Self:
        return self

    def simpler_kinds(self, extent: float) -> tuple[str, ...]:
        return ("plane",) if self.radius > PLANE_LIKE * extent else ()

    def surface(self, u: Array, v: Array) -> Array:
        """Points at azimuth `u` and polar angle `v` [rad]."""
        u, v = np.broadcast_arrays(u, v)
        ring = np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)], axis=-1)
        return self.center + self.radius * ring
