"""How much noise a seen piece of a primitive bears before it could be one of a simpler kind.

Nothing is fitted in earnest: the deviations are those of the best plane and the algebraic sphere, and for
cylinder and cone the sagittas that make the difference.
"""

import numpy as np
from numpy.typing import NDArray

from fitting.primitives import Cone, Plane, Sphere, Torus
from synthetic.patches import Patch

Array = NDArray[np.float64]

CERTAIN, MANY = 0.5, 8.0
"""A deviation is visible above 0.5 + 8 / sqrt(N) standard deviations of the noise of N points."""
ENOUGH = 400
"""Points that the deviations are computed from."""


def from_plane(points: Array) -> float:
    """Root mean square distance from the best plane."""
    centered = points - points.mean(axis=0)
    return float(np.sqrt(max(np.linalg.eigvalsh(centered.T @ centered)[0], 0.0) / len(points)))


def from_sphere(points: Array) -> float:
    """Root mean square distance from the algebraic sphere  |x|^2 = 2 c.x + b."""
    centered = points - points.mean(axis=0)
    design = np.column_stack([2.0 * centered, np.ones(len(points))])
    solution = np.linalg.lstsq(design, np.einsum("ij,ij->i", centered, centered), rcond=None)[0]
    center = solution[:3]
    radius = np.sqrt(max(solution[3] + center @ center, 0.0))
    return float(np.sqrt(np.mean((np.linalg.norm(centered - center, axis=1) - radius) ** 2)))


def sagitta(radius: float, angles: Array) -> float:
    """About the root mean square distance of an arc at these angles from its best line: 0.3 of its height."""
    turned = np.sort(np.mod(angles, 2 * np.pi))
    covered = 2 * np.pi - np.diff(turned, append=turned[0] + 2 * np.pi).max()
    return 0.3 * radius * (1.0 - float(np.cos(min(covered, np.pi) / 2)))


def deviation(patch: Patch, points: Array) -> float:
    """The smallest deviation of the points of a piece from any simpler kind, in their unit."""
    points = points[:: max(1, len(points) // ENOUGH)]
    if isinstance(patch.primitive, Plane):
        return np.inf
    if isinstance(patch.primitive, Sphere):
        return from_plane(points)
    least = min(from_plane(points), from_sphere(points))
    x, y, z = points.T
    match patch.primitive:
        case Cone(half_angle=half_angle):
            least = min(least, float(np.sin(half_angle) * z.std()))
        case Torus(major_radius=major_radius, minor_radius=minor_radius):
            tube = np.arctan2(z, np.hypot(x, y) - major_radius)
            least = min(least, sagitta(major_radius, np.arctan2(y, x)), sagitta(minor_radius, tube))
    return least


def bearable_noise(least: float, count: float) -> float:
    """The standard deviation of the noise of `count` points from which a deviation can still be told."""
    return least / (CERTAIN + MANY / np.sqrt(count))
