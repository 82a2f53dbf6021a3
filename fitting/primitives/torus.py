"""The torus: a center, an axis, the radius of the tube's center circle and the radius of the tube.

Signed distance, with the center c, the unit axis a, h = a . (x - c), rho = distance to the axis, the
radii R (major) and r (minor):  d(x) = w - r  with  w = hypot(rho - R, h).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from ..geometry.turning import NEARER, inverse, turned
from ..geometry.vectors import (
    TINY,
    Array,
    around_axis,
    basis,
    canonical_direction,
    cross,
    cylindrical,
    rows,
    unit,
    vector,
)
from ..guesses import _guesses
from ..guesses.oriented import ROUNDS, Oriented, RevolutionAxis
from .cylinder import Cylinder
from .primitive import NO_ROWS, Chart, Known, Limited, Number, Primitive

CYLINDER_LIKE = 5.0
"""A major radius beyond this many extents asks for a look at the cylinder."""

SPHERE_LIKE = 0.1
"""A major radius below this share of the minor one asks for a look at the sphere."""

SMALLEST_MAJOR = 0.05
"""Guesses start with at least this major radius, in extents: at 0 the axis has no meaning."""

BENT_CYLINDERS = 3
"""So many cylinders are bent for starts of tori."""

LEAST_CURVATURE = 0.01
"""Bent cylinders start with at least this curvature, over extents: at 0 they have no center."""


@dataclass(frozen=True, eq=False)
class Torus(Primitive):
    """A circular torus; signed distances are positive outside the tube.

    With `major_radius` below `minor_radius` it is a spindle torus, of which the outer sheet counts.

    Attributes
    ----------
    center : (3,)
    axis : (3,) unit vector
    major_radius : of the circle in the middle of the tube
    minor_radius : of the tube

    Notes
    -----
    Of a spindle torus `surface` gives the inner sheet, too.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> torus = primfit.Torus(center=[0, 0, 0], axis=[0, 0, 1], major_radius=3.0, minor_radius=1.0)
    >>> torus.signed_distance(np.array([[5.0, 0.0, 0.0], [0.0, 3.0, 1.0]]))
    array([1., 0.])
    """

    center: Array
    axis: Array
    major_radius: float
    minor_radius: float

    kind: ClassVar[str] = "torus"
    dof: ClassVar[int] = 7
    chart: ClassVar[Chart] = Chart(
        tilts=(0, 1),
        shifts=(2, 3, 4),
        across=((0, 1), (2, 3)),
        numbers={"major_radius": Number(5, 7), "minor_radius": Number(6, 8)},
    )
    form: ClassVar[str] = "toroidal form"
    quadrics: ClassVar[int] = 0
    has_sign: ClassVar[bool] = False

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
    def initial_guesses(cls, oriented: Oriented, rng: np.random.Generator) -> Array:
        return cls.rows_about(oriented.directions, oriented.points, oriented.normals, oriented.line)

    @classmethod
    def rows_about(
        cls, directions: Array, points: Array, normals: Array, line: RevolutionAxis, rounds: int = ROUNDS
    ) -> Array:
        """For each candidate axis the circle through the profile (rho, h) of the points (N, 3) about it.

        The candidates are two for each direction (K, 3), and the given line, (2 K + 1, 9). One passes where
        the normal lines meet it,  (n x a) . (x - p) = 0,  the other through the center of the circle that the
        points describe when seen along it.
        """
        return _guesses.tori(
            np.ascontiguousarray(directions),
            np.ascontiguousarray(points),
            np.ascontiguousarray(normals),
            np.ascontiguousarray(line.direction),
            np.ascontiguousarray(line.point),
            rounds,
            SMALLEST_MAJOR,
        )

    @classmethod
    def rows_along(cls, cylinder: Array, points: Array, normals: Array, rounds: int = ROUNDS) -> Array:
        """The torus (1, 9) whose tube has the radius of a cylinder (9,), bent as the normals say.

        Going back along the normals by the radius leads to the circle in the middle of the tube.
        """
        found = _guesses.tube(
            np.ascontiguousarray(cylinder),
            np.ascontiguousarray(points),
            np.ascontiguousarray(normals),
            rounds,
        )
        return found[None]

    @classmethod
    def rows_bent(cls, cylinders: Array, points: Array, rounds: int = ROUNDS) -> Array:
        """The tori (K, 9) that cylinders (K, 9) bend into, as the points say; no normals are needed."""
        return _guesses.bent(
            np.ascontiguousarray(cylinders), np.ascontiguousarray(points), rounds, LEAST_CURVATURE
        )

    @staticmethod
    def impose(row: Array, points: Array, limits: Limited) -> None:
        """Bring a row (9,) within limits, as near to the points (N, 3) as a linear step brings it."""
        radial, rho, height = around_axis(points, row[3:6], row[:3])
        grown = limits.clip(row, 7)
        if not limits.pinned:
            row[3:6] -= grown * (radial / (rho + TINY)[:, None]).mean(axis=0)
            _, rho, height = around_axis(points, row[3:6], row[:3])
        row[8] = np.median(np.hypot(rho - row[7], height))
        limits.clip(row, 8)

    def bent_row(self, step: Array) -> Array | None:
        """By its curvatures 1 / r, cos v / rho and -sin v / rho, v the foot's azimuth around the tube."""
        row = self.row()
        axis, center, major, minor = row[:3], row[3:6], row[7], row[8]
        height = -float(center @ axis)
        outward = -center - height * axis
        away = float(np.linalg.norm(outward))
        tube = float(np.hypot(away - major, height))
        distance = tube - minor
        if abs(distance) > NEARER * min(minor, away) or away == 0.0 or minor == 0.0:
            return None
        outward = outward / away
        across = np.array(cross(axis, outward))
        tangents = np.stack(basis(axis))
        tilt, shift = step[:2] @ tangents, step[2:4] @ tangents
        cosine, sine = (away - major) / tube, height / tube
        height_by = away * (outward @ tilt) - step[4]
        away_by = -shift @ outward - height * (tilt @ outward)
        turn = (cosine * height_by - sine * (away_by - step[5])) / tube
        distance += cosine * (away_by - step[5]) + sine * height_by - step[6]
        rho = major + minor * cosine
        rho_by = step[5] + step[6] * cosine - minor * sine * turn
        rotation = np.array(
            [-tilt @ across, -(shift @ across + height * (tilt @ across)) / away, tilt @ outward - turn]
        )
        outward, axis, across = turned(np.stack([outward, axis, across]), rotation)
        normal, meridian = cosine * outward + sine * axis, cosine * axis - sine * outward
        along_normal = (cosine - sine * turn - cosine * rho_by / rho) / rho
        along_meridian = -(sine + cosine * turn - sine * rho_by / rho) / rho
        rho = inverse(float(np.hypot(along_normal, along_meridian)))
        cosine, sine = along_normal * rho, -along_meridian * rho
        outward, axis = cosine * normal - sine * meridian, sine * normal + cosine * meridian
        minor = inverse((1.0 - step[6] / minor) / minor)
        center = -distance * normal - rho * outward - minor * sine * axis
        return rows(axis, center, major=abs(rho - minor * cosine), offset=abs(minor))

    def coordinates(self, feet: Array, extent: float) -> list[tuple[Array, float]]:
        azimuth, rho, height = cylindrical(feet, self.center, self.axis)
        return [(azimuth, 2.0 * np.pi), (np.arctan2(height, rho - self.major_radius), 2.0 * np.pi)]

    @classmethod
    def guesses_given(cls, known: Known, oriented: Oriented, rng: np.random.Generator) -> Array:
        if known.direction is None:
            return NO_ROWS
        return cls.rows_about(known.direction[None], oriented.points, oriented.normals, oriented.line)

    @classmethod
    def later_guesses(
        cls, oriented: Oriented, rng: np.random.Generator, settled: Callable[[str, Array], Array]
    ) -> Array:
        """The tori that the better ones of the cylinders bend into: they need no good normals."""
        cylinders = settled("cylinder", Cylinder.initial_guesses(oriented, rng))
        return cls.rows_bent(cylinders[:BENT_CYLINDERS], oriented.points)

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
