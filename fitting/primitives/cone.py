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

from ..geometry.turning import bent_straight
from ..geometry.vectors import (
    TINY,
    Array,
    around_axis,
    basis,
    cross,
    cylindrical,
    foot_of_origin,
    rows,
    unit,
    vector,
)
from ..guesses import _guesses
from ..guesses.oriented import ROUNDS, Oriented, random_subsets
from .primitive import NO_ROWS, Chart, Known, Limited, Number, Primitive

CYLINDER_LIKE = np.radians(5.0)
PLANE_LIKE = np.radians(80.0)
"""Half-angles outside these ask for a look at the cylinder or the plane."""


APEX_TRIPLES = 24
"""Triples of points that lead from a known apex to a cone."""

BEGIN = 0.05
"""Share of the points of a cone below where they begin."""


@dataclass(frozen=True, eq=False)
class Cone(Primitive):
    """One nappe of a circular cone; signed distances are positive outside.

    Attributes
    ----------
    apex : (3,)
    axis : (3,) unit vector from the apex into the nappe that holds the points
    half_angle : radians, between 0 and pi/2

    Examples
    --------
    >>> import numpy as np, primfit
    >>> cone = primfit.Cone(apex=[0, 0, 0], axis=[0, 0, 1], half_angle=np.radians(45))
    >>> cone.signed_distance(np.array([[3.0, 0.0, 1.0]])).round(6)
    array([1.414214])
    """

    apex: Array
    axis: Array
    half_angle: float

    kind: ClassVar[str] = "cone"
    dof: ClassVar[int] = 6
    chart: ClassVar[Chart] = Chart(
        tilts=(0, 1), shifts=(2, 3, 5), across=((0, 1), (2, 3)), numbers={"half_angle": Number(4, 6)}
    )
    """The offset is the apex's position along the axis."""
    form: ClassVar[str] = "conicity"

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
    def initial_guesses(cls, oriented: Oriented, rng: np.random.Generator) -> Array:
        return cls.rows_about(oriented.directions, oriented.points)

    @classmethod
    def rows_about(cls, directions: Array, points: Array, rounds: int = ROUNDS) -> Array:
        """For each direction (K, 3) the quadric  x^2 + y^2 = a x + b y + m h^2 + e h + f,  m = tan^2 t."""
        return _guesses.cones(np.ascontiguousarray(directions), np.ascontiguousarray(points), rounds)

    @staticmethod
    def impose(row: Array, points: Array, limits: Limited) -> None:
        """Bring a row (9,) within limits, as near to the points (N, 3) as a linear step brings it."""
        if limits.pinned:
            row[8] = 0.0
        row[3:6] = foot_of_origin(row[3:6], row[:3])
        radial, rho, height = around_axis(points, row[3:6], row[:3])
        if limits.pinned:
            if np.median(height) < 0.0:
                row[:3], height = -row[:3], -height
            row[6] = np.median(np.arctan2(rho, height))
        apex = row[3:6] - row[8] / np.sin(row[6]) * row[:3]
        grown = limits.clip(row, 6)
        if not limits.pinned:
            if limits.reference is None:
                lean = (radial / (rho + TINY)[:, None]).mean(axis=0)
                row[:3] = unit(np.cos(grown) * row[:3] - np.sin(grown) * lean)
                row[3:6] = foot_of_origin(apex, row[:3])
                _, rho, height = around_axis(points, row[3:6], row[:3])
            row[8] = np.median(rho * np.cos(row[6]) - height * np.sin(row[6]))

    def bent_row(self, step: Array) -> Array | None:
        """By its curvatures across and along the generators' turn."""
        return bent_straight(self.row(), step, is_cone=True)

    def coordinates(self, feet: Array, extent: float) -> list[tuple[Array, float]]:
        azimuth, _, height = cylindrical(feet, self.apex, self.axis)
        return [(azimuth, 2.0 * np.pi), (height / extent, 0.0)]

    def most_curved(self, feet: Array) -> tuple[Array, float]:
        """The apex along the axis, beside the height at which the points begin."""
        begin = np.quantile(np.abs((feet - self.apex) @ self.axis), BEGIN)
        return np.concatenate([self.axis, np.zeros(4)]), float(begin)

    @classmethod
    def guesses_given(cls, known: Known, oriented: Oriented, rng: np.random.Generator) -> Array:
        found = [NO_ROWS]
        if known.direction is not None:
            found.append(cls.rows_about(known.direction[None], oriented.points))
        if known.position is not None:
            found.append(cls.rows_from(known.position, oriented.points, rng))
        return np.vstack(found)

    @classmethod
    def rows_from(cls, apex: Array, points: Array, rng: np.random.Generator) -> Array:
        """Cones (K, 9) of an apex through three random points each.

        Directions from it make one angle with the axis, so their tips lie in a plane across it. The angle is
        left to the points.
        """
        directions = points - apex
        directions /= np.linalg.norm(directions, axis=1, keepdims=True) + TINY
        tips = directions[random_subsets(len(points), 3, APEX_TRIPLES, rng)]
        axes = cross(tips[:, 1] - tips[:, 0], tips[:, 2] - tips[:, 0])
        lengths = np.linalg.norm(axes, axis=1)
        axes = axes[lengths > 1e-9] / lengths[lengths > 1e-9, None]
        feet = np.array([foot_of_origin(apex, axis) for axis in axes]).reshape(-1, 3)
        return rows(axes, feet, np.pi / 4, offset=-(axes @ apex) * np.sin(np.pi / 4))

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
