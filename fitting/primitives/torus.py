"""The torus: a centre, an axis, the radius of the tube's centre circle and the radius of the tube.

Signed distance, with the centre c, the unit axis a, h = a . (x - c), rho = distance to the axis, the
radii R (major) and r (minor):  d(x) = w - r  with  w = hypot(rho - R, h).
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from fitting.axes import axis_directions, circles, in_bases, revolution_axis, robust_linear_solve
from fitting.geometry import TINY, Array, around_axis, basis, canonical_direction, rows, unit, vector

CYLINDER_LIKE = 5.0
"""A major radius beyond this many extents asks for a look at the cylinder."""

SPHERE_LIKE = 0.1
"""A major radius below this share of the minor one asks for a look at the sphere."""

SMALLEST_MAJOR = 0.05
"""Guesses start with at least this major radius, in extents: at 0 the axis has no meaning."""


@dataclass(frozen=True, eq=False)
class Torus:
    """A torus; positive outside the tube.

    With `major_radius` below `minor_radius` it is a spindle torus, of which the outer sheet counts
    (`surface` gives the inner one, too).
    """

    center: Array
    axis: Array
    major_radius: float
    minor_radius: float

    kind: ClassVar[str] = "torus"
    dof: ClassVar[int] = 7

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", vector(self.center))
        object.__setattr__(self, "axis", unit(self.axis))
        object.__setattr__(self, "major_radius", float(self.major_radius))
        object.__setattr__(self, "minor_radius", float(self.minor_radius))

    def signed_distance(self, points: Array) -> Array:
        _, rho, height = around_axis(points, self.center, self.axis)
        return np.hypot(rho - self.major_radius, height) - self.minor_radius

    def gradient(self, points: Array) -> Array:
        radial, rho, height = around_axis(points, self.center, self.axis)
        tube = np.hypot(rho - self.major_radius, height) + TINY
        outward = ((rho - self.major_radius) / tube / (rho + TINY))[:, None] * radial
        return outward + (height / tube)[:, None] * self.axis

    def row(self) -> Array:
        return rows(self.axis, self.center, major=self.major_radius, offset=self.minor_radius)

    @classmethod
    def from_row(cls, row: Array) -> Self:
        return cls(row[3:6], row[:3], row[7], row[8])

    def transformed(self, rotation: Array, translation: Array, scale: float) -> Self:
        return type(self)(
            scale * (rotation @ self.center) + translation,
            rotation @ self.axis,
            scale * self.major_radius,
            scale * self.minor_radius,
        )

    @classmethod
    def initial_guesses(cls, points: Array, normals: Array, rng: np.random.Generator) -> Array:
        directions = axis_directions(points, normals)
        return cls.rows_about(directions, revolution_axis(points, normals), points, normals)

    @classmethod
    def rows_about(
        cls, directions: Array, line: tuple[Array, Array], points: Array, normals: Array, rounds: int = 4
    ) -> Array:
        """For each candidate axis the circle through the profile (rho, h) of the points about it.

        The candidates are the given line (direction, point), and two for each direction: one passes where
        the normal lines meet it,  (n x a) . (x - p) = 0,  the other through the centre of the circle that
        the points describe when seen along it.
        """
        bases, x, y, _ = in_bases(points, directions)
        _, normal_x, normal_y, _ = in_bases(normals, directions)
        across = np.stack([normal_y, -normal_x], axis=-1)
        met = robust_linear_solve(across, across[..., 0] * x + across[..., 1] * y, rounds)
        seen_x, seen_y, _ = circles(x, y, rounds)
        axes = np.vstack([directions, directions, line[0]])
        feet = np.vstack(
            [
                met[:, :1] * bases[:, 0] + met[:, 1:] * bases[:, 1],
                seen_x[:, None] * bases[:, 0] + seen_y[:, None] * bases[:, 1],
                line[1],
            ]
        )
        relative = points - feet[:, None]
        height = np.einsum("kni,ki->kn", relative, axes)
        rho = np.linalg.norm(relative - height[..., None] * axes[:, None], axis=2)
        major, level, minor = circles(rho, height, rounds)
        return rows(
            axes, feet + level[:, None] * axes, major=np.maximum(np.abs(major), SMALLEST_MAJOR), offset=minor
        )

    def canonical(self, center: Array) -> Self:
        return type(self)(self.center, canonical_direction(self.axis), self.major_radius, self.minor_radius)

    def simpler_kinds(self, extent: float) -> tuple[str, ...]:
        if self.major_radius < SPHERE_LIKE * self.minor_radius:
            return ("sphere",)
        return ("cylinder",) if self.major_radius > CYLINDER_LIKE * extent else ()

    def surface(self, u: Array, v: Array) -> Array:
        """Points at azimuth `u` around the axis and `v` around the tube [rad], 0 at the outer equator."""
        u, v = np.broadcast_arrays(u, v)
        along_u, along_v = basis(self.axis)
        ring = np.multiply.outer(np.cos(u), along_u) + np.multiply.outer(np.sin(u), along_v)
        rho = self.major_radius + self.minor_radius * np.cos(v)
        return (
            self.center + rho[..., None] * ring + np.multiply.outer(self.minor_radius * np.sin(v), self.axis)
        )
