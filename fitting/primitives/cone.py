"""The right circular cone with one nappe: apex, axis into the nappe, half-angle.

With the apex c, the unit axis a, h = a . (x - c), rho = distance to the axis and the half-angle t, the
signed distance is  d(x) = rho cos t - h sin t, and |x - c| where the apex is the closest point, that is
where  h cos t + rho sin t < 0.

Its row holds the foot f of the origin on the axis, the angle t and the offset
s = (apex distance below f) * sin t, for which d = rho cos t - h_f sin t - s: as t goes to 0 that is a
cylinder of radius s, not an apex at infinity.
"""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ..geometry.axes import Seen, axis_directions, robust_linear_solve
from ..geometry.vectors import TINY, Array, around_axis, basis, foot_of_origin, rows, unit, vector

CYLINDER_LIKE = np.radians(5.0)
PLANE_LIKE = np.radians(80.0)
"""Half-angles outside these ask for a look at the cylinder or the plane."""


@dataclass(frozen=True, eq=False)
class Cone:
    """One nappe of a circular cone; signed distances are positive outside.

    Attributes
    ----------
    apex : (3,)
    axis : (3,) unit vector from the apex into the nappe that holds the points
    half_angle : radians, between 0 and pi/2
    """

    apex: Array
    axis: Array
    half_angle: float

    kind: ClassVar[str] = "cone"
    dof: ClassVar[int] = 6

    def __post_init__(self) -> None:
        object.__setattr__(self, "apex", vector(self.apex))
        object.__setattr__(self, "axis", unit(self.axis))
        object.__setattr__(self, "half_angle", float(self.half_angle))

    def signed_distance(self, points: Array) -> Array:
        _, rho, height = around_axis(points, self.apex, self.axis)
        sine, cosine = np.sin(self.half_angle), np.cos(self.half_angle)
        lateral = rho * cosine - height * sine
        return np.where(height * cosine + rho * sine < 0.0, np.hypot(rho, height), lateral)

    def gradient(self, points: Array) -> Array:
        radial, rho, height = around_axis(points, self.apex, self.axis)
        sine, cosine = np.sin(self.half_angle), np.cos(self.half_angle)
        lateral = cosine * radial / (rho + TINY)[:, None] - sine * self.axis
        from_apex = (points - self.apex) / (np.hypot(rho, height) + TINY)[:, None]
        return np.where((height * cosine + rho * sine < 0.0)[:, None], from_apex, lateral)

    def row(self) -> Array:
        offset = -(self.apex @ self.axis) * np.sin(self.half_angle)
        return rows(self.axis, foot_of_origin(self.apex, self.axis), self.half_angle, offset=offset)

    @classmethod
    def from_row(cls, row: Array) -> Self:
        return cls(row[3:6] - row[8] / np.sin(row[6]) * row[:3], row[:3], row[6])

    def transformed(self, rotation: Array, translation: Array, scale: float) -> Self:
        return type(self)(scale * (rotation @ self.apex) + translation, rotation @ self.axis, self.half_angle)

    @classmethod
    def initial_guesses(cls, points: Array, normals: Array, rng: np.random.Generator) -> Array:
        return cls.rows_about(Seen.along(axis_directions(points, normals), points, normals))

    @classmethod
    def rows_about(cls, seen: Seen, rounds: int = 4) -> Array:
        """For each direction the quadric  x^2 + y^2 = a x + b y + m h^2 + e h + f,  m = tan^2 t."""
        x, y, height = seen.x, seen.y, seen.height
        design = np.empty((*x.shape, 5))
        design[..., 0], design[..., 1], design[..., 2] = x, y, height**2
        design[..., 3], design[..., 4] = height, 1.0
        a, b, m, e, _ = robust_linear_solve(design, x**2 + y**2, rounds).T
        m = np.clip(m, 0.01, 100.0)
        apex = -e / (2.0 * m)
        side = np.where(np.median(height, axis=1) > apex, 1.0, -1.0)
        angles = np.arctan(np.sqrt(m))
        feet = seen.placed(a / 2.0, b / 2.0)
        return rows(side[:, None] * seen.axes, feet, angles, offset=-side * apex * np.sin(angles))

    def canonical(self, center: Array) -> Self:
        return self

    def simpler_kinds(self, extent: float) -> tuple[str, ...]:
        if self.half_angle < CYLINDER_LIKE:
            return ("cylinder",)
        return ("plane",) if self.half_angle > PLANE_LIKE else ()

    def surface(self, u: Array, v: Array) -> Array:
        """Points at azimuth `u` [rad] and height `v` >= 0 from the apex along the axis."""
        u, v = np.broadcast_arrays(u, v)
        along_u, along_v = basis(self.axis)
        ring = np.multiply.outer(np.cos(u), along_u) + np.multiply.outer(np.sin(u), along_v)
        return self.apex + (v * np.tan(self.half_angle))[..., None] * ring + np.multiply.outer(v, self.axis)
