"""Candidate axis directions and lines, and the linear systems that follow once a direction is known."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from . import _linear
from .vectors import Array, basis, cross, principal

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
    and the grid about the principal axes of the points, which turns with them.
    """
    _, by_normals = np.linalg.eigh(normals.T @ normals)
    _, by_points = principal(points)
    revolution = revolution_axis(points, normals)
    return np.vstack([by_normals.T, revolution.direction, DIRECTION_GRID @ by_points.T])


@dataclass(frozen=True, eq=False)
class RevolutionAxis:
    """The line that the normals meet best, and the eigenvalues (3,) of their reduced scatter, ascending."""

    direction: Array
    point: Array
    eigenvalues: Array


def revolution_axis(points: Array, normals: Array, rounds: int = 4) -> RevolutionAxis:
    """The axis line that the normal lines of a surface of revolution meet best.

    A line with direction n through x has the moment m = x cross n, and meets the axis (c, c') where
    c . m + c' . n = 0; the smallest eigenvector of the reduced scatter of (m, n) is c. Reweighted, so that
    bad normals count less.

    Source: Pottmann and Wallner, "Computational line geometry", 2001, section 4.2; Pottmann and Randrup,
    "Rotational and helical surface approximation for reverse engineering", Computing 60, 1998.
    """
    lines = np.hstack([cross(points, normals), normals])
    weights = np.full(len(lines), 1.0 / len(lines))
    for _ in range(rounds):
        scatter = (lines * weights[:, None]).T @ lines
        lower = scatter[3:, 3:] + 1e-12 * np.trace(scatter) * np.eye(3)
        coupling = np.linalg.solve(lower, scatter[3:, :3])
        eigenvalues, vectors = np.linalg.eigh(scatter[:3, :3] - scatter[:3, 3:] @ coupling)
        direction = vectors[:, 0]
        momentum = -coupling @ direction
        residual = np.abs(lines[:, :3] @ direction + lines[:, 3:] @ momentum)
        middle = np.partition(residual, len(residual) // 2)[len(residual) // 2]
        weights = 1.0 / (residual + 0.5 * middle + 1e-12)
        weights /= weights.sum()
    return RevolutionAxis(direction, cross(direction, momentum), eigenvalues)


@dataclass(frozen=True, eq=False)
class Seen:
    """Points (N, 3) with their normals as seen along each of K directions.

    Attributes
    ----------
    u, v, axes : (K, 3) bases
    points, normals : as given
    x, y, height : (K, N) coordinates of the points in the bases
    """

    u: Array
    v: Array
    axes: Array
    points: Array
    normals: Array
    x: Array
    y: Array
    height: Array

    @classmethod
    def along(cls, directions: Array, points: Array, normals: Array) -> Self:
        u, v = (np.ascontiguousarray(across.T) for across in basis(directions.T))
        x, y, height = (across @ points.T for across in (u, v, directions))
        return cls(u, v, directions, points, normals, x, y, height)

    def placed(self, x: Array, y: Array) -> Array:
        """Points (K, 3) at x, y (K,) in the bases, at height 0."""
        return x[:, None] * self.u + y[:, None] * self.v


def robust_linear_solve(design: Array, target: Array, rounds: int = 4) -> Array:
    """Solutions (K, m) of K overdetermined systems  design (K, N, m) . x = target (K, N), m at most 7.

    Reweighted by 1 / (1 + (residual / median)^2), so that a minority of outliers moves them little.
    """
    return _linear.solve_linear(np.ascontiguousarray(design), np.ascontiguousarray(target), rounds)


def circles(x: Array, y: Array, rounds: int = 4) -> tuple[Array, Array, Array]:
    """Centres and radii of circles through K sets of N plane points, by Kasa's linear fit.

    Source: Kasa, "A circle fitting procedure and its error analysis", IEEE Trans. Instrum. Meas. 25, 1976.
    """
    solution = _linear.solve_circles(np.ascontiguousarray(x), np.ascontiguousarray(y), rounds)
    center_x, center_y = solution[:, 0] / 2.0, solution[:, 1] / 2.0
    return center_x, center_y, np.sqrt(np.maximum(solution[:, 2] + center_x**2 + center_y**2, 1e-12))


def random_subsets(n: int, size: int, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """`count` sets of `size` distinct indices below `n`, shape (count, size)."""
    return np.argsort(rng.random((count, n)), axis=1)[:, :size]
