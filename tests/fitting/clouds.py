"""Clouds and examples that the tests of `fitting` share."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

Array = NDArray[np.float64]

EXAMPLES: dict[str, Primitive] = {
    "plane": Plane(normal=[0.6, -0.3, 0.74], point=[0.2, 0.1, -0.4]),
    "sphere": Sphere(center=[0.3, -0.2, 0.5], radius=1.3),
    "cylinder": Cylinder(axis=[0.2, 0.9, 0.3], point=[0.1, 0.4, -0.2], radius=0.8),
    "cone": Cone(apex=[0.3, -0.4, 0.9], axis=[0.1, 0.3, -0.9], half_angle=0.6),
    "torus": Torus(center=[0.1, 0.2, -0.3], axis=[0.5, -0.4, 0.7], major_radius=1.6, minor_radius=0.6),
}
"""One of each kind, in general position. A new primitive adds one line here."""

PATCHES = {
    "plane": ((-1.5, 1.0), (-0.8, 1.6)),
    "sphere": ((0.0, 4.5), (0.3, 2.4)),
    "cylinder": ((0.0, 4.0), (-1.5, 1.2)),
    "cone": ((0.0, 4.5), (0.3, 2.0)),
    "torus": ((0.0, 4.0), (0.0, 5.0)),
}
"""Ranges of the surface parameters (u, v) that the sampled part of each example covers."""


def sample(primitive: Primitive, n: int, seed: int = 0) -> Array:
    """`n` points (n, 3) of the part of an example that `PATCHES` names, at random parameters."""
    rng = np.random.default_rng(seed)
    u, v = (rng.uniform(low, high, n) for low, high in PATCHES[primitive.kind])
    return primitive.surface(u, v)


def noisy(primitive: Primitive, n: int, sigma: float, seed: int = 0) -> Array:
    """`sample` with isotropic normal noise of standard deviation `sigma`."""
    points = sample(primitive, n, seed)
    return points + np.random.default_rng([seed, 1]).normal(0.0, sigma, points.shape)


def rotation(seed: int) -> Array:
    return Rotation.random(random_state=seed).as_matrix()
