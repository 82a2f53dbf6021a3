"""Surfaces of each kind by a vote on their sizes, a cloud having been brought to its canonical position.

Where that is follows from the normals and from closed-form fits about few directions, which
`primfit.fitting.guesses` has; sizes are left to the vote.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter

import numpy as np

from primfit.fitting.geometry.vectors import Array, around_axis
from primfit.fitting.guesses.oriented import Oriented
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.solver.refine import distances

from .votes import ZOOMS, around, peak, voted_axis, voted_normal

WIDEST = 8.0
"""Largest radius, in root mean square distances from the centroid: beyond it a cloud is flat."""
NARROWEST = 0.02
FLATTEST, SHARPEST = np.radians(80.0), np.radians(10.0)
"""Half-angles between which a cone is looked for."""
SLIM = 10.0
"""Largest ratio of the radii of a torus."""
ALONG = 0.15
"""Cosine below which a normal may be one of a cylinder."""
NEAR = 0.02
"""Width of the kernel under which points vote for a surface."""
TILT = 0.03
"""Width of the first grid of normals about the voted one [rad]."""
SHIFTS = np.linspace(-0.2, 0.2, 9)
"""Changes of the major radius of a torus, as a share of it, that are voted on."""


@dataclass(frozen=True, eq=False)
class Seen:
    """Points (N, 3) that vote, some of them with normals, and the shares of the votes for these."""

    points: Array
    oriented: Oriented
    weights: Array

    @cached_property
    def directions(self) -> Array:
        """(K, 3) that an axis may have: voted for, and those that need no vote."""
        voted = [
            voted_axis(self.oriented.normals, self.weights, low, high)[0]
            for low, high in ((0.0, ALONG), (np.cos(FLATTEST), np.cos(SHARPEST)))
        ]
        return np.vstack([*voted, self.oriented.directions])

    def votes(self, surface: Primitive) -> float:
        """Of the points for a surface."""
        return votes(distances(surface, self.points))

    def most_voted(self, surfaces: Iterator[Primitive]) -> Primitive | None:
        finite = [surface for surface in surfaces if np.isfinite(surface.row()).all()]
        return max(finite, key=self.votes, default=None)


def votes(distance: Array) -> float:
    """Of points at these distances (N,) from a surface: each has one, spread by a Gaussian kernel."""
    return float(np.exp(-0.5 * (distance / NEAR) ** 2).sum())


def planes(seen: Seen) -> Iterator[Primitive]:
    """Planes by their offset along the voted normal, and its neighbors on an ever finer grid."""
    normal, width = voted_normal(seen.oriented.normals, seen.weights), TILT
    for _ in range(ZOOMS):
        normals = around(normal, width)
        heights = seen.points @ normals.T
        found = [peak(column, column.min(), column.max())[0] for column in heights.T]
        surfaces = [Plane(each, offset * each) for each, offset in zip(normals, found, strict=True)]
        best = max(surfaces, key=seen.votes)
        yield best
        normal, width = best.normal, width / 3.0


def spheres(seen: Seen) -> Iterator[Primitive]:
    """Spheres about the centers of closed-form ones, by their radius."""
    for row in Sphere.initial_guesses(seen.oriented, np.random.default_rng(0)):
        radius, _ = peak(np.linalg.norm(seen.points - row[3:6], axis=1), NARROWEST, WIDEST)
        yield Sphere(row[3:6], radius)


def cylinders(seen: Seen) -> Iterator[Primitive]:
    """Cylinders about the axes of closed-form ones, by their radius."""
    for row in Cylinder.rows_about(seen.directions, seen.oriented.points):
        radius, _ = peak(around_axis(seen.points, row[3:6], row[:3])[1], NARROWEST, WIDEST)
        yield Cylinder(row[:3], row[3:6], radius)


def cones(seen: Seen) -> Iterator[Primitive]:
    """Cones of the apexes and axes of closed-form ones, by their half-angle."""
    for row in Cone.rows_about(seen.directions, seen.oriented.points):
        if not np.isfinite(row).all() or not 0.0 < row[6] < np.pi / 2:
            continue
        cone = Cone.from_row(row)
        _, rho, height = around_axis(seen.points, cone.apex, cone.axis)
        angle, _ = peak(np.arctan2(rho, height), SHARPEST, FLATTEST)
        yield Cone(cone.apex, cone.axis, angle)


def tori(seen: Seen) -> Iterator[Primitive]:
    """Tori about the axes and centers of closed-form ones, by both radii."""
    oriented = seen.oriented
    for row in Torus.rows_about(seen.directions, oriented.points, oriented.normals, oriented.line):
        if not np.isfinite(row).all() or row[7] > WIDEST:
            continue
        _, rho, height = around_axis(seen.points, row[3:6], row[:3])
        major, minor = float(row[7]), np.nan
        for shifts in (SHIFTS, SHIFTS / len(SHIFTS)):
            tubes = [tube(rho, height, each) for each in major * (1.0 + shifts)]
            major, minor, _ = max(tubes, key=itemgetter(2))
        if major < SLIM * minor:
            yield Torus(row[3:6], row[:3], major, minor)


def tube(rho: Array, height: Array, major: float) -> tuple[float, float, float]:
    """A major radius with the minor one that most points vote for, and their votes, by distances from the
    axis (N,) and heights (N,)."""
    away = np.hypot(rho - major, height)
    minor, _ = peak(away, NARROWEST, major)
    return major, minor, votes(away - minor) if np.isfinite(minor) else 0.0


STANDING: dict[str, Callable[[Seen], Iterator[Primitive]]] = {
    "plane": planes,
    "sphere": spheres,
    "cylinder": cylinders,
    "cone": cones,
    "torus": tori,
}
"""The candidates of each kind; those with the fewest sizes come first."""
