"""A sphere by least squares on many samples of the points: the one that most points are near to.

The least squares are algebraic,  |x|^2 = 2 c . x + b  with  r^2 = b + |c|^2, which is linear. Source: the
page that the paper cites, jekel.me/2015/Least-Squares-Sphere-Fit.
"""

import numpy as np

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
    centers, radii = algebraic_spheres(points, chosen(len(points), rng))
    distances = np.array([np.linalg.norm(points - center, axis=1) for center in centers])
    inliers = (np.abs(distances - radii[:, None]) <= FAR * radii[:, None]).sum(axis=1)
    best = int(np.argmax(inliers))
    usable = inliers[best] and 0.0 < radii[best] < np.inf
    return Sphere(centers[best], radii[best]) if usable else None


def chosen(n: int, rng: np.random.Generator) -> Array:
    """Samples (SAMPLES, n) of a share of n points: 1 where one is chosen."""
    size = max(FEWEST, round(SHARE * n))
    return (rng.random((SAMPLES, n)).argsort(axis=1) < size).astype(float)


def algebraic_spheres(points: Array, samples: Array) -> tuple[Array, Array]:
    """Centers (K, 3) and radii (K,) by least squares on K samples (K, N) of points near the origin."""
    columns = np.column_stack([2.0 * points, np.ones(len(points))])
    target = np.einsum("ij,ij->i", points, points)
    products = np.einsum("ni,nj->nij", columns, columns).reshape(len(points), -1)
    normal = (samples @ products).reshape(-1, 4, 4)
    right = samples @ (columns * target[:, None])
    solution = np.einsum("kij,kj->ki", np.linalg.pinv(normal, hermitian=True), right)
    centers = solution[:, :3]
    return centers, np.sqrt(np.maximum(solution[:, 3] + np.einsum("ki,ki->k", centers, centers), 0.0))
