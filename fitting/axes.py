"""Candidate axis directions and lines, and the linear systems that follow once a direction is known."""

import numpy as np
from numpy.typing import NDArray

from fitting.geometry import TINY, Array, basis

_GRID = np.array(
    [
        [1, 0, 0], [0, 1, 0], [0, 0, 1],
        [1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1],
        [1, 1, 1], [1, 1, -1], [1, -1, 1], [-1, 1, 1],
    ],
    dtype=np.float64,
)  # fmt: skip
DIRECTION_GRID: Array = _GRID / np.linalg.norm(_GRID, axis=1)[:, None]
"""Face, edge and corner directions of a cube: every direction is within 28 degrees of one of them."""


def axis_directions(points: Array, normals: Array) -> Array:
    """Directions (K, 3) that an axis of the cloud may have, the informed ones first.

    The eigenvectors of the normals' scatter (the Gauss map of a cylinder is a great circle about its axis,
    that of a complete cone or torus has its axis for an eigenvector), the axis of the linear line complex,
    the principal axes of the points, and the fixed grid.
    """
    _, by_normals = np.linalg.eigh(normals.T @ normals)
    centred = points - points.mean(axis=0)
    _, by_points = np.linalg.eigh(centred.T @ centred)
    direction, _ = revolution_axis(points, normals)
    return np.vstack([by_normals.T, direction, by_points.T, DIRECTION_GRID])


def revolution_axis(points: Array, normals: Array, rounds: int = 4) -> tuple[Array, Array]:
    """The axis line (direction, point) that the normal lines of a surface of revolution meet best.

    A line with direction n through x has the moment m = x cross n, and meets the axis (c, c') where
    c . m + c' . n = 0; the smallest eigenvector of the reduced scatter of (m, n) is c. Reweighted, so that
    bad normals count less.

    Source: Pottmann and Wallner, "Computational line geometry", 2001, section 4.2; Pottmann and Randrup,
    "Rotational and helical surface approximation for reverse engineering", Computing 60, 1998.
    """
    lines = np.hstack([np.cross(points, normals), normals])
    weights = np.ones(len(lines))
    direction, momentum = np.array([0.0, 0.0, 1.0]), np.zeros(3)
    for _ in range(rounds):
        scatter = (lines * weights[:, None]).T @ lines
        lower = scatter[3:, 3:] + 1e-12 * np.trace(scatter) * np.eye(3)
        coupling = np.linalg.solve(lower, scatter[3:, :3])
        _, vectors = np.linalg.eigh(scatter[:3, :3] - scatter[:3, 3:] @ coupling)
        direction = vectors[:, 0]
        momentum = -coupling @ direction
        residual = np.abs(lines[:, :3] @ direction + lines[:, 3:] @ momentum)
        weights = 1.0 / (residual + 0.5 * np.median(residual) + 1e-12)
    return direction, np.cross(direction, momentum)


def in_bases(points: Array, directions: Array) -> tuple[Array, Array, Array, Array]:
    """Coordinates of the points (N, 3) about each of K directions.

    Returns
    -------
    bases : (K, 3, 3) with rows u, v, axis
    x, y, height : (K, N) coordinates along them
    """
    bases = np.array([[*basis(direction), direction] for direction in directions])
    coordinates = np.einsum("kij,nj->kin", bases, points)
    return bases, coordinates[:, 0], coordinates[:, 1], coordinates[:, 2]


def robust_linear_solve(design: Array, target: Array, rounds: int = 4) -> Array:
    """Solutions (K, m) of K overdetermined systems  design (K, N, m) . x = target (K, N).

    Reweighted by 1 / (1 + (residual / median)^2), so that a minority of outliers moves them little.
    """
    weights = np.ones_like(target)
    size = design.shape[-1]
    solution = np.zeros((len(design), size))
    for _ in range(rounds):
        weighted = design * weights[..., None]
        normal = np.swapaxes(weighted, 1, 2) @ design
        ridge = 1e-13 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(size) + TINY * np.eye(size)
        solution = np.linalg.solve(normal + ridge, np.einsum("knm,kn->km", weighted, target)[..., None])[
            ..., 0
        ]
        residual = np.einsum("knm,km->kn", design, solution) - target
        middle = np.median(np.abs(residual), axis=1, keepdims=True) + 1e-12
        weights = 1.0 / (1.0 + (residual / middle) ** 2)
    return solution


def circles(x: Array, y: Array, rounds: int = 4) -> tuple[Array, Array, Array]:
    """Centres and radii of circles through K sets of N plane points, by Kasa's linear fit.

    Source: Kasa, "A circle fitting procedure and its error analysis", IEEE Trans. Instrum. Meas. 25, 1976.
    """
    design = np.stack([x, y, np.ones_like(x)], axis=-1)
    solution = robust_linear_solve(design, x**2 + y**2, rounds)
    center_x, center_y = solution[:, 0] / 2.0, solution[:, 1] / 2.0
    return center_x, center_y, np.sqrt(np.maximum(solution[:, 2] + center_x**2 + center_y**2, 1e-12))


def random_subsets(n: int, size: int, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """`count` sets of `size` distinct indices below `n`, shape (count, size)."""
    return np.argsort(rng.random((count, n)), axis=1)[:, :size]
