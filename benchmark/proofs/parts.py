"""Measured parts as metrology has them: 1 to 500 mm in size, anywhere within a metre of the origin."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .oracles import DOF, Array

HALF_ANGLES = np.radians([0.6, 2.0, 5.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0])
ARCS = (30.0, 60.0, 90.0, 180.0, 360.0)
"""In degrees; of a sphere that of its cap."""
BEYOND_MINIMUM = (0, 1, 2, 5, 20, 200, 1000)
"""Points more than the surface has parameters."""
NOISE = (-6.5, -2.5)
"""Powers of ten between which the standard deviation of the noise lies, as a share of the size."""


@dataclass(frozen=True, eq=False)
class Part:
    """A measured surface and the nominal one.

    Attributes
    ----------
    points : (N, 3) [mm]
    size : diameter, or length of the longer side of a plane [mm]
    sigma : standard deviation of the noise of each coordinate [mm]
    arc : of the feature [deg]
    about : all of it in words
    """

    nominal: Primitive
    points: Array
    size: float
    sigma: float
    arc: float
    about: str

    @property
    def is_minimal(self) -> bool:
        """Whether there are as many points as parameters."""
        return len(self.points) == self.nominal.dof


def part(
    kind: str,
    rng: Generator,
    exact: bool = False,
    more: Sequence[int] = BEYOND_MINIMUM,
    arcs: Sequence[float] = ARCS,
    noise: tuple[float, float] = NOISE,
) -> Part:
    """A whole or partial feature of few or many points, under more or less noise or none."""
    size, arc = 10.0 ** rng.uniform(0.0, 2.7), np.radians(rng.choice(arcs))
    n, share = int(rng.choice(more)) + DOF[kind], rng.uniform(0.2, 0.8)
    center = rng.uniform(-1.0, 1.0, 3) * (1000.0 - 0.75 * size)
    axis = rng.normal(size=3) if rng.random() < 0.7 else np.eye(3)[rng.integers(3)]
    sigma = 0.0 if exact else size * 10.0 ** rng.uniform(*noise)
    nominal, points = _feature(kind, rng, n, size, arc, share, center, axis)
    about = f"{n} points of {size:.3g} mm over {np.degrees(arc):.0f} degrees, noise {sigma:.1e} mm, {nominal}"
    points = points + rng.normal(0.0, sigma, points.shape) if sigma else points
    return Part(nominal, points, size, sigma, float(np.degrees(arc)), about)


def _feature(
    kind: str, rng: Generator, n: int, size: float, arc: float, share: float, center: Array, axis: Array
) -> tuple[Primitive, Array]:
    """The nominal surface and points (n, 3) of it."""
    radius = size / 2.0
    if kind == "plane":
        plane = Plane(axis, center)
        return plane, plane.surface(rng.uniform(-radius, radius, n), share * rng.uniform(-radius, radius, n))
    if kind == "sphere":
        sphere = Sphere(center, radius)
        return sphere, sphere.surface(
            rng.uniform(0.0, 2.0 * np.pi, n), np.arccos(rng.uniform(np.cos(arc / 2.0), 1.0, n))
        )
    if kind == "cylinder":
        cylinder = Cylinder(axis, center, radius)
        return cylinder, cylinder.surface(
            rng.uniform(0.0, arc, n), 2.0 * share * rng.uniform(-radius, radius, n)
        )
    if kind == "cone":
        half_angle = rng.choice(HALF_ANGLES)
        top = radius / np.tan(half_angle)
        cone = Cone(center - top * axis / np.linalg.norm(axis), axis, half_angle)
        lowest = max(top - 2.0 * size, share * top)
        return cone, cone.surface(rng.uniform(0.0, arc, n), rng.uniform(lowest, top, n))
    torus = Torus(center, axis, radius, share * 0.8 * radius)
    around = rng.uniform(0.0, arc, n)
    return torus, torus.surface(around, rng.uniform(0.0, rng.choice([np.pi, 2.0 * np.pi]), n))
