"""Points with normals, and what surfaces start from: candidate axes, linear systems, random subsets."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array, cross, principal
from . import _guesses

ROUNDS = 4
"""Rounds in which the systems that surfaces start from are reweighted."""

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


@dataclass(frozen=True, eq=False)
class RevolutionAxis:
    """The line that the normals meet best, and the eigenvalues (3,) of their reduced scatter, ascending."""

    direction: Array
    point: Array
    eigenvalues: Array


def revolution_axis(points: Array, normals: Array, rounds: int = ROUNDS) -> RevolutionAxis:
    """The axis line that the normal lines of a surface of revolution meet best.

    A line with direction n through x has the moment m = x cross n, and meets the axis (c, c') where
    c . m + c' . n = 0; the smallest eigenvector of the reduced scatter of (m, n) is c. Reweighted, so that
    bad normals count less.

    Source: Pottmann and Wallner, "Computational line geometry", 2001, section 4.2; Pottmann and Randrup,
    "Rotational and helical surface approximation for reverse engineering", Computing 60, 1998.
    """
    direction, momentum, eigenvalues = _guesses.revolution_axis(
        np.ascontiguousarray(points), np.ascontiguousarray(normals), rounds
    )
    return RevolutionAxis(direction, cross(direction, momentum), eigenvalues)


@dataclass(frozen=True, eq=False)
class Oriented:
    """Points (N, 3) with unit normals (N, 3), and what several kinds of surfaces start from, found once."""

    points: Array
    normals: Array

    @cached_property
    def line(self) -> RevolutionAxis:
        return revolution_axis(self.points, self.normals)

    @cached_property
    def directions(self) -> Array:
        """Directions (K, 3) that an axis may have, the informed ones first.

        The eigenvectors of the normals' scatter (the Gauss map of a cylinder is a great circle about its
        axis, that of a complete cone or torus has its axis for an eigenvector), the axis of the linear line
        complex, and the grid about the principal axes of the points, which turns with them.
        """
        _, by_normals = np.linalg.eigh(self.normals.T @ self.normals)
        _, by_points = principal(self.points)
        return np.vstack([by_normals.T, self.line.direction, DIRECTION_GRID @ by_points.T])


def robust_linear_solve(columns: Array, target: Array, rounds: int = ROUNDS) -> Array:
    """Solutions (K, m) of K overdetermined systems, m at most 9.

    They are  sum_k columns[:, k] . x_k = target  with columns (K, m, N) and target (K, N), reweighted by
    1 / (1 + (residual / median)^2), so that a minority of outliers moves them little.
    """
    return _guesses.solve_linear(np.ascontiguousarray(columns), np.ascontiguousarray(target), rounds)


def random_subsets(n: int, size: int, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """`count` sets of `size` distinct indices below `n`, shape (count, size)."""
    return _guesses.subsets(rng.random((count, size)), n)
