"""A sphere by least squares on many samples of the points: the one that most points are near to.

The least squares are algebraic,  |x|^2 = 2 c . x + b  with  r^2 = b + |c|^2, which is linear. Source: the
page that the paper cites, jekel.me/2015/Least-Squares-Sphere-Fit.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.sphere import Sphere

FEWEST = 4
"""Points that a sphere takes."""
SAMPLES = 100
SHARE = 0.3
"""Of the points, in each sample."""
FAR = 0.05
"""Share of the radius beyond which a point is an outlier."""


def sampled_sphere(points: Array, rng: np.random.Generator) -> Sphere | None:
    """The sphere with the most inliers; None where four points are missing, or no sphere has any."""
    if len(points) < FEWEST:
        return None
    columns, target = np.column_stack([2.0 * points, np.ones(len(points))]), np.square(points).sum(axis=1)
    # One sample after the other: a hundred of a large cloud at once take gigabytes.
    spheres = [algebraic_sphere(columns[rows], target[rows]) for rows in samples(len(points), rng)]
    inliers = [inliers_of(points, *sphere) for sphere in spheres]
    best = int(np.argmax(inliers))
    center, radius = spheres[best]
    return Sphere(center, radius) if inliers[best] and 0.0 < radius < np.inf else None


def samples(n: int, rng: np.random.Generator) -> Iterator[NDArray[np.bool_]]:
    """Of n points, which are in each of the samples."""
    size = max(FEWEST, round(SHARE * n))
    return (rng.random(n).argsort() < size for _ in range(SAMPLES))


def algebraic_sphere(columns: Array, target: Array) -> tuple[Array, float]:
    """Center and radius by least squares on rows (2 x, 1) and squared norms of points near the origin."""
    solution = np.linalg.pinv(columns.T @ columns, hermitian=True) @ (columns.T @ target)
    center = solution[:3]
    return center, float(np.sqrt(max(solution[3] + center @ center, 0.0)))


def inliers_of(points: Array, center: Array, radius: float) -> int:
    """How many points are near to a sphere."""
    away = np.linalg.norm(points - center, axis=1) - radius
    return int((np.abs(away) <= FAR * radius).sum())
