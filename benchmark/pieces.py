"""Pieces of surfaces with independent noise of a known size: pairs that it makes alike, round shapes.

A pair is a piece of a surface and a surface of another kind that hardly differs there. What the truth gains
on the other one in log-likelihood is known before anything is fitted: N points at a root mean square distance
D from the other surface, under noise of standard deviation s, gain  N D^2 / (2 s^2)  on the average.
"""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator

from primfit.fitting.geometry.vectors import Z_AXIS, Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.solver.refine import refine
from primfit.synthetic import SyntheticCloud
from primfit.synthetic.recipes import Range
from primfit.synthetic.scanner import log_uniform, random_rotation

from .measures import diagonal

ORIGIN = np.zeros(3)
X_AXIS, Y_AXIS = np.eye(3)[:2]

GAINS = {"indistinguishable": 0.1, "clearly distinguishable": 500.0}
"""What the truth gains on the other surface of its pair in log-likelihood, on the average.

A gain of 0.1 is a difference of 0.45 standard errors: a test at 5% that knows the noise and both surfaces
finds it in one cloud of fourteen. At 500 it is 32 of them, and what nests the one kind in the other is known
to a sixteenth of its value.
"""
INDISTINGUISHABLE, CLEAR = GAINS
PAIR_POINTS = Range(30.0, 60.0)
PAIR_NOISE = Range(0.01, 0.02)
"""Of indistinguishable pairs, in extents; pieces that would need more or less are drawn again."""
BOW = 0.002
"""Share of the extent by which sensors and parts bow without being another shape: 0.2 mm on a hand's breadth,
flatness K of ISO 2768-2."""
CLEARLY_APART = 3.0 * BOW
"""Root mean square distance of the surfaces of a clear pair, in extents, at least: no bow passes for it."""
LARGEST_RADIUS = 5.0
"""Of any surface of a pair, in extents: there an arc has a sagitta of a fortieth. Who cuts a scan into pieces
leaves one that shows what it is a piece of, and that of a larger sphere is a plane to everybody."""

STRIP, HALF_ANGLE, BEND = Range(0.15, 0.8), Range(0.5, 8.0), Range(2.0, 12.0)
"""Width of a strip over its radius, degrees of a cone, R / r of a bent tube; log-uniform. One end makes pairs
that nobody can tell, the other clear ones; pieces between are drawn again."""

Layout = tuple[Primitive, Array, Primitive]
"""The simpler surface, points (N, 3) on it, and the other surface, which nearly holds them."""


def plane_or_sphere(rng: Generator, count: int) -> Layout:
    """A square, or one of a radius of 1 to 5 extents."""
    radius = np.sqrt(2.0) * rng.uniform(1.0, 4.5)
    return Plane(Z_AXIS, ORIGIN), _square(rng, count), Sphere(-radius * Z_AXIS, radius)


def plane_or_cylinder(rng: Generator, count: int) -> Layout:
    radius = np.sqrt(2.0) * rng.uniform(1.0, 4.5)
    return Plane(Z_AXIS, ORIGIN), _square(rng, count), Cylinder(X_AXIS, -radius * Z_AXIS, radius)


def _square(rng: Generator, count: int) -> Array:
    return np.column_stack([rng.uniform(-0.5, 0.5, (count, 2)), np.zeros(count)])


def sphere_or_cylinder(rng: Generator, count: int) -> Layout:
    """A strip along an equator, or around a cylinder."""
    return Sphere(ORIGIN, 1.0), _strip(rng, count), Cylinder(Z_AXIS, ORIGIN, 1.0)


def sphere_or_torus(rng: Generator, count: int) -> Layout:
    """A strip along an equator, or around the tube of a torus with R = r to 3 r, on its outer side."""
    major = rng.uniform(1.0, 3.0)
    return Sphere(ORIGIN, 1.0), _strip(rng, count), Torus(-major * X_AXIS, Y_AXIS, major, 1.0)


def _strip(rng: Generator, count: int) -> Array:
    """Of the unit sphere, 60 to 90 degrees long and 0.15 to 0.8 wide."""
    half, width = np.radians(rng.uniform(30.0, 45.0)), log_uniform(rng, STRIP)
    azimuth, away = rng.uniform(-half, half, count), rng.uniform(-0.5, 0.5, count) * width
    return Sphere(ORIGIN, 1.0).surface(azimuth, np.pi / 2 + away)


def cylinder_or_cone(rng: Generator, count: int) -> Layout:
    """A half to a whole turn, one to two radii long, or a cone of 0.5 to 8 degrees."""
    cylinder, points = _tube(rng, count)
    angle = np.radians(log_uniform(rng, HALF_ANGLE))
    return cylinder, points, Cone(-Z_AXIS / np.tan(angle), Z_AXIS, angle)


def cylinder_or_torus(rng: Generator, count: int) -> Layout:
    """The same, or a torus with R = 2 r to 12 r that bends it."""
    cylinder, points = _tube(rng, count)
    major = log_uniform(rng, BEND)
    return cylinder, points, Torus(-major * X_AXIS, Y_AXIS, major, 1.0)


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
PAIRS_OF = {
    INDISTINGUISHABLE: tuple(pair for pair in PAIRS if not pair.startswith("plane")),
    CLEAR: tuple(PAIRS),
}
"""Of each level. What hardly differs from a plane has a radius far beyond `LARGEST_RADIUS`."""


def draw_pair(rng: Generator, name: str, level: str) -> tuple[Primitive, Primitive, Array, float]:
    """The two surfaces of a pair, points (N, 3) on the second, and the noise under which it gains as asked.

    The simpler surface is the one that least squares fits to the points of the other.
    """
    while True:
        count = round(log_uniform(rng, PAIR_POINTS))
        start, points, other = PAIRS[name](rng, count)
        points = feet(other, points)
        simpler, extent = refine(start, points).primitive, diagonal(points)
        apart = float(np.sqrt(np.mean(simpler.signed_distance(points) ** 2)))
        noise = apart * float(np.sqrt(count / (2.0 * GAINS[level])))
        hidden = PAIR_NOISE.low <= noise / extent <= PAIR_NOISE.high
        as_asked = hidden if level == INDISTINGUISHABLE else apart >= CLEARLY_APART * extent
        if as_asked and largest_radius(other) <= LARGEST_RADIUS * extent:
            return simpler, other, points, noise


def largest_radius(surface: Primitive) -> float:
    """Of a cone, whose radius is whatever its length makes it, 0."""
    match surface:
        case Sphere(radius=radius) | Cylinder(radius=radius) | Torus(major_radius=radius):
            return float(radius)
    return 0.0


def pair_cloud(rng: Generator, name: str, simpler: bool, level: str) -> SyntheticCloud:
    """A cloud of the simpler surface of a pair, or of the other.

    Its truth is that surface; of a pair that nobody can tell it is the simpler one, whichever was drawn.
    """
    *surfaces, points, noise = draw_pair(rng, name, level)
    drawn = surfaces[0 if simpler else 1]
    told = surfaces[0] if level == INDISTINGUISHABLE else drawn
    return noisy(rng, drawn, feet(drawn, points), noise, "along the normal", told)


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


def noisy(
    rng: Generator, surface: Primitive, points: Array, noise: float, law: str, truth: Primitive | None = None
) -> SyntheticCloud:
    """Points (N, 3) of a surface with normal noise, turned and moved by up to three extents.

    The truth is the surface, unless another one is given.
    """
    extent, truth = diagonal(points), truth or surface
    if law == "isotropic":
        points = points + noise * rng.standard_normal(points.shape)
    else:
        points = points + noise * rng.standard_normal((len(points), 1)) * surface.gradient(points)
    rotation, shift = random_rotation(rng), extent * rng.uniform(-3.0, 3.0, 3)
    return SyntheticCloud(
        points @ rotation.T + shift,
        truth.transformed(rotation, shift, 1.0),
        truth.kind,
        family="piece",
        noise=noise,
        extent=extent,
    )
