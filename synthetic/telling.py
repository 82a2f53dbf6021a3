"""How much noise a seen piece of a primitive bears before it could be one of a simpler kind.

The deviation from a simpler kind is that of the best plane, of the algebraic sphere, and of the cylinder and
the cone that least squares finds from where they are to be expected.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, least_squares

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .canonical import ORIGIN, Z_AXIS
from .patches import Patch

Array = NDArray[np.float64]

CERTAIN, MANY = 0.5, 8.0
"""A deviation is visible above 0.5 + 8 / sqrt(N) standard deviations of the noise of N points."""
ENOUGH = 120
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


def settled(start: Primitive, points: Array) -> OptimizeResult:
    """The surface of this kind that is nearest to the points, near the start: distances `fun`, their `jac`.

    A cylinder or a cone; least squares over tilts of the axis, shifts across it, and what the kind adds.
    """
    row = start.row()
    across = np.linalg.svd(row[None, :3])[2][1:]
    free = [6, 8] if isinstance(start, Cone) else [8]

    def distances(step: Array) -> Array:
        moved = row.copy()
        moved[:3] += step[:2] @ across
        moved[3:6] += step[2:4] @ across
        moved[free] += step[4:]
        moved[6] = np.clip(moved[6], 1e-3, 1.5) if isinstance(start, Cone) else 0.0
        return type(start).from_row(moved).signed_distance(points)

    return least_squares(distances, np.zeros(4 + len(free)), method="lm", xtol=1e-4, ftol=1e-4, max_nfev=150)


def nearest(start: Primitive, points: Array) -> float:
    """Root mean square distance of the points from what `settled` finds."""
    return float(np.sqrt(2.0 * settled(start, points).cost / len(points)))


def outward(points: Array) -> Array:
    """The unit vector from the z axis towards the middle of the points."""
    azimuth = np.arctan2(points[:, 1].mean(), points[:, 0].mean())
    return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])


def nearest_cylinders(patch: Patch, points: Array) -> Iterator[Cylinder]:
    """Where to look for the cylinder nearest to a piece of a canonical cone or torus.

    About the same axis; and along the middle of the points: a cone's generatrix, a torus's tube.
    """
    rho = np.hypot(points[:, 0], points[:, 1])
    yield Cylinder(Z_AXIS, ORIGIN, float(rho.mean()))
    away = outward(points)
    match patch.primitive:
        case Cone(half_angle=half_angle):
            sine, cosine = np.sin(half_angle), np.cos(half_angle)
            radius = float(rho.mean()) / cosine
            on_surface = float(points[:, 2].mean()) * (Z_AXIS + sine / cosine * away)
            yield Cylinder(
                cosine * Z_AXIS + sine * away,
                on_surface - radius * (cosine * away - sine * Z_AXIS),
                radius,
            )
        case Torus(major_radius=major_radius, minor_radius=minor_radius):
            yield Cylinder(np.cross(Z_AXIS, away), major_radius * away, minor_radius)


def nearest_cones(torus: Torus, points: Array) -> Iterator[Cone]:
    """Where to look for the cone nearest to a piece of a canonical torus: about its axis, along its tube."""
    rho = np.hypot(points[:, 0], points[:, 1])
    slope, offset = np.polyfit(points[:, 2], rho, 1)
    slope = float(np.copysign(max(abs(slope), 0.02), slope))
    yield Cone(-offset / slope * Z_AXIS, np.sign(slope) * Z_AXIS, float(np.arctan(abs(slope))))
    tangent, center = np.cross(Z_AXIS, outward(points)), torus.major_radius * outward(points)
    for axis in (tangent, -tangent):
        yield Cone(center - torus.minor_radius / np.tan(0.1) * axis, axis, 0.1)


def deviation(patch: Patch, points: Array) -> float:
    """The smallest deviation of the points of a piece from any simpler kind, in their unit."""
    points = points[:: max(1, -(-len(points) // ENOUGH))]
    if isinstance(patch.primitive, Plane):
        return np.inf
    least = from_plane(points)
    if isinstance(patch.primitive, Sphere):
        return least
    least = min(least, from_sphere(points))
    if isinstance(patch.primitive, Cone | Torus):
        least = min(least, *(nearest(start, points) for start in nearest_cylinders(patch, points)))
    if isinstance(patch.primitive, Torus):
        least = min(least, *(nearest(start, points) for start in nearest_cones(patch.primitive, points)))
    return least


def bearable_noise(least: float, count: float) -> float:
    """The standard deviation of the noise of `count` points from which a deviation can still be told."""
    return least / (CERTAIN + MANY / np.sqrt(count))
