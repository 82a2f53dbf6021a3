"""Where the benchmark puts its primitives: about half keep the z axis, half (independently) the origin."""

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

Array = NDArray[np.float64]

KEPT_AXES = 0.5
KEPT_POSITIONS = 0.5
REACH = 3.0
"""Translations reach this many half-extents."""
CONE_REACH = 1.14
"""A cone's translations are larger by this than the height left after cuts explains."""
TORUS_REACH = (1.2, 4.0)
"""The largest translation of a torus along z, in minor radii, is drawn first."""
PLANE_SHIFT = (0.0, 26.0)
"""Translation of a plane on each coordinate."""


def rotation_about_axes(angles: Array) -> Array:
    """Rz Rx Ry for three angles [rad], shape (3, 3).

    With uniform angles the z axis gets z = cos cos and a uniform azimuth; the quantiles of the training
    axes agree with it, not with the uniform distribution on the sphere.
    """
    (cx, cy, cz), (sx, sy, sz) = np.cos(angles), np.sin(angles)
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]])
    about_y = np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
    about_z = np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
    return about_z @ about_x @ about_y


def half_extents(primitive: Primitive, points: Array) -> Array:
    """What translations are proportional to, on x, y and z (the canonical axis is z)."""
    match primitive:
        case Cylinder(radius=radius):
            return np.array([radius, radius, np.abs(points[:, 2]).max()])
        case Sphere(radius=radius):
            return np.full(3, radius)
        case Cone(half_angle=half_angle):
            height = CONE_REACH * points[:, 2].max()
            return np.array([height * np.tan(half_angle), height * np.tan(half_angle), 0.7 * height])
        case Torus(major_radius=major_radius, minor_radius=minor_radius):
            return np.array([major_radius, major_radius, minor_radius])
    raise TypeError(f"no half-extents for {type(primitive).__name__}")


def sample_translation(rng: Generator, primitive: Primitive, points: Array) -> Array:
    if isinstance(primitive, Plane):
        return rng.uniform(*PLANE_SHIFT, 3)
    translation = rng.uniform(-REACH, REACH, 3) * half_extents(primitive, points)
    if isinstance(primitive, Torus):
        translation[2] = rng.uniform(-1.0, 1.0) * rng.uniform(*TORUS_REACH) * primitive.minor_radius
    return translation


def place(rng: Generator, primitive: Primitive, points: Array, turn: bool = False) -> tuple[Primitive, Array]:
    """Rotate and translate, or not; a plane is always rotated, and so is everything when `turn` is set.

    A pose that is kept is kept to the last digit: axes stay exactly z, positions exactly the origin.
    """
    if turn or isinstance(primitive, Plane) or rng.random() >= KEPT_AXES:
        rotation = rotation_about_axes(rng.uniform(0.0, 2 * np.pi, 3))
        turned = primitive.transformed(rotation, np.zeros(3), 1.0), points @ rotation.T
    else:
        turned = primitive, points
    if rng.random() < KEPT_POSITIONS:
        return turned
    translation = sample_translation(rng, primitive, points)
    return turned[0].transformed(np.eye(3), translation, 1.0), turned[1] + translation
