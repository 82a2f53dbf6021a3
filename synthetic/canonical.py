"""Primitives at the origin with axis z, sampled on parameter grids and cut by random planes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .recipes import Range

Array = NDArray[np.float64]
Span = tuple[float, float]

ORIGIN = np.zeros(3)
Z_AXIS = np.array([0.0, 0.0, 1.0])
TURN = 2 * np.pi

GRID = 80
TORUS_GRID = 90

RADIUS = Range(1.0, 4.0)
SMALLEST_MINOR_RADIUS = 0.5
HALF_ANGLE = Range(np.pi / 6, np.pi / 3)
CONE_SLANT = Range(1.75, 4.0)
"""Length of a cone's generatrix from the apex to the rim, before cuts."""
CYLINDER_HALF_HEIGHT = Range(0.5, 4.0)
"""Small heights are more frequent: low + (high - low) * Beta(1, 1.5)."""
PLANE_HALF_SIDE = 10.0
PLANE_OFFSET = Range(0.0, 10.0)
"""Distance of a plane from the origin before it is moved."""

WHOLE_SPAN = 0.5
"""How often a parameter runs over all of its range; independently for each of the two."""
PARTIAL_SPAN = Range(0.2, 1.0)
"""The share of the range that a parameter runs over otherwise, at a random place."""


@dataclass(frozen=True)
class KeptLaw:
    """Which share of a clean cloud's grid is left: all of it with probability `uncut`, or less.

    `quantiles` are those of the share at 0, 10, .. 100% of the clouds that are cut.
    """

    uncut: float
    quantiles: tuple[float, ...]

    def draw(self, rng: Generator) -> float:
        if rng.random() < self.uncut:
            return 1.0
        return float(np.interp(rng.random(), np.linspace(0.0, 1.0, len(self.quantiles)), self.quantiles))


KEPT_SHARE = {
    "plane": KeptLaw(0.095, (0.101, 0.208, 0.292, 0.364, 0.426, 0.472, 0.505, 0.554, 0.638, 0.814, 1.0)),
    "sphere": KeptLaw(0.170, (0.100, 0.208, 0.294, 0.372, 0.448, 0.521, 0.593, 0.727, 0.927, 0.998, 1.0)),
    "cylinder": KeptLaw(0.061, (0.100, 0.186, 0.257, 0.311, 0.379, 0.452, 0.517, 0.592, 0.677, 0.828, 1.0)),
    "cone": KeptLaw(0.078, (0.043, 0.201, 0.299, 0.398, 0.495, 0.591, 0.691, 0.825, 0.951, 0.997, 1.0)),
    "torus": KeptLaw(0.380, (0.101, 0.282, 0.369, 0.439, 0.504, 0.562, 0.644, 0.740, 0.836, 0.943, 1.0)),
}
"""From the point counts of the 3,000 training clouds a kind that nothing is removed from (A0, A1, A2)."""
MOST_CUTS = 3


def uniform(rng: Generator, law: Range) -> float:
    return float(rng.uniform(law.low, law.high))


def span(rng: Generator, low: float, high: float) -> Span:
    """All of [low, high], or a random part of it."""
    if rng.random() < WHOLE_SPAN:
        return low, high
    width = (high - low) * uniform(rng, PARTIAL_SPAN)
    start = float(rng.uniform(low, high - width))
    return start, start + width


def azimuths(rng: Generator) -> Span:
    """A full turn or a random arc; an arc may start anywhere."""
    low, high = span(rng, 0.0, TURN)
    start = 0.0 if high - low == TURN else float(rng.uniform(0.0, TURN))
    return start, start + high - low


def grid(u: Span, v: Span, size: int) -> tuple[Array, Array]:
    """The parameters of a size x size grid, bounds included, flattened."""
    along_u, along_v = np.meshgrid(np.linspace(*u, size), np.linspace(*v, size), indexing="ij")
    return along_u.ravel(), along_v.ravel()


def sample_plane(rng: Generator) -> tuple[Primitive, Array]:
    plane = Plane(Z_AXIS, np.array([0.0, 0.0, uniform(rng, PLANE_OFFSET)]))
    sides = [span(rng, -PLANE_HALF_SIDE, PLANE_HALF_SIDE) for _ in range(2)]
    return plane, plane.surface(*grid(sides[0], sides[1], GRID))


def sample_sphere(rng: Generator) -> tuple[Primitive, Array]:
    sphere = Sphere(ORIGIN, uniform(rng, RADIUS))
    return sphere, sphere.surface(*grid(azimuths(rng), span(rng, 0.0, np.pi), GRID))


def sample_cylinder(rng: Generator) -> tuple[Primitive, Array]:
    cylinder = Cylinder(Z_AXIS, ORIGIN, uniform(rng, RADIUS))
    law = CYLINDER_HALF_HEIGHT
    half_height = law.low + (law.high - law.low) * float(rng.beta(1.0, 1.5))
    return cylinder, cylinder.surface(*grid(azimuths(rng), (-half_height, half_height), GRID))


def sample_cone(rng: Generator) -> tuple[Primitive, Array]:
    cone = Cone(ORIGIN, Z_AXIS, uniform(rng, HALF_ANGLE))
    height = uniform(rng, CONE_SLANT) * float(np.cos(cone.half_angle))
    return cone, cone.surface(*grid(azimuths(rng), span(rng, 0.0, height), GRID))


def sample_torus(rng: Generator) -> tuple[Primitive, Array]:
    major_radius = uniform(rng, RADIUS)
    minor_radius = float(rng.uniform(SMALLEST_MINOR_RADIUS, major_radius))
    torus = Torus(ORIGIN, Z_AXIS, major_radius, minor_radius)
    return torus, torus.surface(*grid(azimuths(rng), azimuths(rng), TORUS_GRID))


SAMPLERS: dict[str, Callable[[Generator], tuple[Primitive, Array]]] = {
    "plane": sample_plane,
    "sphere": sample_sphere,
    "cylinder": sample_cylinder,
    "cone": sample_cone,
    "torus": sample_torus,
}


def cut(rng: Generator, points: Array, count: int) -> Array:
    """The `count` points left beyond one to `MOST_CUTS` planes of uniform directions, sharing the removal."""
    cuts = int(rng.integers(1, MOST_CUTS, endpoint=True))
    removals = rng.multinomial(len(points) - count, rng.dirichlet(np.ones(cuts)))
    for removed in removals[removals > 0]:
        height = points @ rng.standard_normal(3)
        points = points[np.sort(np.argpartition(height, removed)[removed:])]
    return points


def sample_segment(rng: Generator, kind: str, cuts: bool = True) -> tuple[Primitive, Array]:
    """A primitive of this kind in canonical position and the points (N, 3) of a grid on it, cut or whole."""
    primitive, points = SAMPLERS[kind](rng)
    if not cuts:
        return primitive, points
    return primitive, cut(rng, points, round(KEPT_SHARE[kind].draw(rng) * len(points)))
