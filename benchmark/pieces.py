"""Pieces of surfaces with independent noise of a known size: pairs that it makes alike, round shapes.

A pair is a piece of a surface and a surface of another kind that hardly differs there. What the truth gains
on the other one in log-likelihood is known before anything is fitted: N points at a root mean square distance
D from the other surface, under noise of standard deviation s, gain  N D^2 / (2 s^2)  on the average.
"""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from benchmark.measures import diagonal
from fitting.geometry import Z_AXIS, Array
from fitting.primitives import Cone, Cylinder, Plane, Primitive, Sphere, Torus
from fitting.refine import refine
from synthetic import SyntheticCloud
from synthetic.recipes import Range
from synthetic.scanner import log_uniform, random_rotation

ORIGIN = np.zeros(3)
X_AXIS = np.array([1.0, 0.0, 0.0])

GAINS = {"indistinguishable": 0.1, "clearly distinguishable": 500.0}
"""What the truth gains on the other surface of its pair in log-likelihood, on the average.

A gain of 0.1 is a difference of 0.45 standard errors: a test at 5 % that knows the noise and both surfaces
finds it in one cloud of fourteen. At 500 it is 32 of them, and what nests the one kind in the other is known
to a sixteenth of its value.
"""
PAIR_POINTS = Range(30.0, 60.0)
PAIR_NOISE = Range(0.01, 0.02)
"""Of indistinguishable pairs, in extents; pieces that would need more or less are drawn again."""

Layout = tuple[Primitive, Array, Primitive]
"""The simpler surface, points (N, 3) on it, and the other surface, which nearly holds them."""


def plane_or_sphere(rng: Generator, count: int) -> Layout:
    """A square, or one of a radius of 10 to 20 extents."""
    radius = np.sqrt(2.0) * rng.uniform(10.0, 20.0)
    return Plane(Z_AXIS, ORIGIN), _square(rng, count), Sphere(-radius * Z_AXIS, radius)


def plane_or_cylinder(rng: Generator, count: int) -> Layout:
    radius = np.sqrt(2.0) * rng.uniform(10.0, 20.0)
    return Plane(Z_AXIS, ORIGIN), _square(rng, count), Cylinder(X_AXIS, -radius * Z_AXIS, radius)


def _square(rng: Generator, count: int) -> Array:
    return np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)), np.zeros(count)])


def sphere_or_cylinder(rng: Generator, count: int) -> Layout:
    """A strip of 60 to 90 degrees, a tenth to a quarter of the radius wide."""
    sphere, half, width = Sphere(ORIGIN, 1.0), np.radians(rng.uniform(30.0, 45.0)), rng.uniform(0.1, 0.25)
    points = sphere.surface(
        rng.uniform(-half, half, count), np.pi / 2 + rng.uniform(-0.5, 0.5, count) * width
    )
    return sphere, points, Cylinder(Z_AXIS, ORIGIN, 1.0)


def sphere_or_torus(rng: Generator, count: int) -> Layout:
    """A cap of 40 to 60 degrees, on the outer side of a torus with R = r / 50 to r / 6."""
    cap = cap_points(rng, np.radians(rng.uniform(40.0, 60.0)), count) @ np.roll(np.eye(3), 1, axis=0)
    major = rng.uniform(0.02, 0.16)
    return Sphere(ORIGIN, 1.0), cap, Torus(-major * X_AXIS, Z_AXIS, major, 1.0)


def cylinder_or_cone(rng: Generator, count: int) -> Layout:
    """A half to a whole turn, one to two radii long, or a cone of 0.5 to 1.2 degrees."""
    cylinder, points = _tube(rng, count)
    angle = np.radians(rng.uniform(0.5, 1.2))
    return cylinder, points, Cone(-Z_AXIS / np.tan(angle), Z_AXIS, angle)


def cylinder_or_torus(rng: Generator, count: int) -> Layout:
    """The same, or a torus with R = 8 r to 20 r that bends it."""
    cylinder, points = _tube(rng, count)
    major = rng.uniform(8.0, 20.0)
    return cylinder, points, Torus(-major * X_AXIS, np.cross(Z_AXIS, X_AXIS), major, 1.0)


def _tube(rng: Generator, count: int) -> tuple[Cylinder, Array]:
    cylinder, half, length = (
        Cylinder(Z_AXIS, ORIGIN, 1.0),
        rng.uniform(0.5, 1.0) * np.pi,
        rng.uniform(1.0, 2.0),
    )
    return cylinder, cylinder.surface(rng.uniform(-half, half, count), length * rng.uniform(-0.5, 0.5, count))


def cap_points(rng: Generator, angle: float, count: int) -> Array:
    """Points of the unit sphere about the z axis, uniform in area, on a cap of so many radians across."""
    heights = rng.uniform(np.cos(angle / 2), 1.0, count)
    return Sphere(ORIGIN, 1.0).surface(rng.uniform(0.0, 2 * np.pi, count), np.arccos(heights))


PAIRS: dict[str, Callable[[Generator, int], Layout]] = {
    "plane or sphere": plane_or_sphere,
    "plane or cylinder": plane_or_cylinder,
    "sphere or cylinder": sphere_or_cylinder,
    "sphere or torus": sphere_or_torus,
    "cylinder or cone": cylinder_or_cone,
    "cylinder or torus": cylinder_or_torus,
}
"""By name: the simpler kind, then the other."""


def draw_pair(rng: Generator, name: str) -> tuple[Primitive, Primitive, Array, float]:
    """The two surfaces of a pair, points (N, 3) on the second, and the noise under which the gain is 1.

    The simpler surface is the one that least squares fits to the points of the other.
    """
    while True:
        count = round(log_uniform(rng, PAIR_POINTS))
        start, points, other = PAIRS[name](rng, count)
        points = feet(other, points)
        simpler = refine(start, points).primitive
        noise = float(np.sqrt(np.sum(simpler.signed_distance(points) ** 2) / 2.0))
        share = noise_of_gain(noise, GAINS["indistinguishable"]) / diagonal(points)
        if PAIR_NOISE.low <= share <= PAIR_NOISE.high:
            return simpler, other, points, noise


def noise_of_gain(noise_of_1: float, gain: float) -> float:
    return noise_of_1 / float(np.sqrt(gain))


def pair_cloud(rng: Generator, name: str, simpler: bool, gain: float) -> SyntheticCloud:
    """A cloud of the simpler surface of a pair, or of the other, of which the truth gains so much."""
    *surfaces, points, noise = draw_pair(rng, name)
    truth = surfaces[0 if simpler else 1]
    return noisy(rng, truth, feet(truth, points), noise_of_gain(noise, gain), "along the normal")


# -- spheres and cylinders, for the bias of their radius ----------------------------------------------------

BIAS_POINTS = 1000
BIAS_NOISE = 0.01
"""Of the radius."""
NOISE_LAWS = ("along the normal", "isotropic")


def round_cloud(rng: Generator, kind: str, arc: float, law: str) -> SyntheticCloud:
    """A sphere or a cylinder two radii long, of so many degrees (of a sphere: a cap), uniform in area."""
    if kind == "sphere":
        truth: Primitive = Sphere(ORIGIN, 1.0)
        points = cap_points(rng, np.radians(arc), BIAS_POINTS)
    else:
        truth, half = Cylinder(Z_AXIS, ORIGIN, 1.0), np.radians(arc) / 2
        points = truth.surface(*rng.uniform([[-half], [-1.0]], [[half], [1.0]], (2, BIAS_POINTS)))
    return noisy(rng, truth, points, BIAS_NOISE, law)


# -- both ---------------------------------------------------------------------------------------------------


def feet(surface: Primitive, points: Array) -> Array:
    """The closest points (N, 3) of the surface."""
    return points - surface.signed_distance(points)[:, None] * surface.gradient(points)


def noisy(rng: Generator, truth: Primitive, points: Array, noise: float, law: str) -> SyntheticCloud:
    """Points (N, 3) of the surface with normal noise, turned and moved by up to three extents."""
    extent = diagonal(points)
    if law == "isotropic":
        points = points + noise * rng.standard_normal(points.shape)
    else:
        points = points + noise * rng.standard_normal((len(points), 1)) * truth.gradient(points)
    rotation, shift = random_rotation(rng), extent * rng.uniform(-3.0, 3.0, 3)
    return SyntheticCloud(
        points @ rotation.T + shift,
        truth.transformed(rotation, shift, 1.0),
        truth.kind,
        family="piece",
        noise=noise,
        extent=extent,
    )
