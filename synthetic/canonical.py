"""Primitives at the origin with axis z, sampled on parameter grids and cut by random planes."""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from fitting.primitives import Cone, Cylinder, Plane, Primitive, Sphere, Torus
from synthetic.recipes import Range

Array = NDArray[np.float64]

ORIGIN = np.zeros(3)
Z_AXIS = np.array([0.0, 0.0, 1.0])

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

CUTS = {"plane": 2.0, "sphere": 1.5, "cylinder": 2.0, "cone": 1.4, "torus": 1.0}
"""Mean number of cutting planes (Poisson); with the share that a cut keeps, matched to the point counts."""
KEPT_SHARE = Range(0.3, 1.0)
SMALLEST_CUT = 400
"""A cut that would leave fewer points is not made."""


def uniform(rng: Generator, law: Range) -> float:
    return float(rng.uniform(law.low, law.high))


def grid(u: tuple[float, float], v: tuple[float, float], size: int) -> tuple[Array, Array]:
    """The parameters of a size x size grid, bounds included, flattened."""
    along_u, along_v = np.meshgrid(np.linspace(*u, size), np.linspace(*v, size), indexing="ij")
    return along_u.ravel(), along_v.ravel()


def sample_plane(rng: Generator) -> tuple[Primitive, Array]:
    plane = Plane(Z_AXIS, np.array([0.0, 0.0, uniform(rng, PLANE_OFFSET)]))
    side = (-PLANE_HALF_SIDE, PLANE_HALF_SIDE)
    return plane, plane.surface(*grid(side, side, GRID))


def sample_sphere(rng: Generator) -> tuple[Primitive, Array]:
    sphere = Sphere(ORIGIN, uniform(rng, RADIUS))
    return sphere, sphere.surface(*grid((0.0, 2 * np.pi), (0.0, np.pi), GRID))


def sample_cylinder(rng: Generator) -> tuple[Primitive, Array]:
    cylinder = Cylinder(Z_AXIS, ORIGIN, uniform(rng, RADIUS))
    law = CYLINDER_HALF_HEIGHT
    half_height = law.low + (law.high - law.low) * float(rng.beta(1.0, 1.5))
    return cylinder, cylinder.surface(*grid((0.0, 2 * np.pi), (-half_height, half_height), GRID))


def sample_cone(rng: Generator) -> tuple[Primitive, Array]:
    cone = Cone(ORIGIN, Z_AXIS, uniform(rng, HALF_ANGLE))
    height = uniform(rng, CONE_SLANT) * float(np.cos(cone.half_angle))
    return cone, cone.surface(*grid((0.0, 2 * np.pi), (0.0, height), GRID))


def sample_torus(rng: Generator) -> tuple[Primitive, Array]:
    major_radius = uniform(rng, RADIUS)
    minor_radius = float(rng.uniform(SMALLEST_MINOR_RADIUS, major_radius))
    torus = Torus(ORIGIN, Z_AXIS, major_radius, minor_radius)
    return torus, torus.surface(*grid((0.0, 2 * np.pi), (0.0, 2 * np.pi), TORUS_GRID))


SAMPLERS: dict[str, Callable[[Generator], tuple[Primitive, Array]]] = {
    "plane": sample_plane,
    "sphere": sample_sphere,
    "cylinder": sample_cylinder,
    "cone": sample_cone,
    "torus": sample_torus,
}


def cut(rng: Generator, points: Array, count: int) -> Array:
    """What is left of the points beyond `count` planes of uniform directions, each keeping a random share."""
    for _ in range(count):
        normal = rng.standard_normal(3)
        height = points @ (normal / np.sqrt(normal @ normal))
        kept = height >= np.quantile(height, 1.0 - uniform(rng, KEPT_SHARE))
        if np.count_nonzero(kept) >= SMALLEST_CUT:
            points = points[kept]
    return points


def sample_segment(rng: Generator, kind: str) -> tuple[Primitive, Array]:
    """A primitive of this kind in canonical position and the points (N, 3) of a cut grid on it."""
    primitive, points = SAMPLERS[kind](rng)
    return primitive, cut(rng, points, int(rng.poisson(CUTS[kind])))
