"""Candidate axis directions and lines, and the linear systems that follow once a direction is known."""

from dataclasses import dataclass
from functools import cached_property
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
    direction, momentum, eigenvalues = _linear.revolution_axis(
        np.ascontiguousarray(points), np.ascontiguousarray(normals), rounds
    )
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

    @cached_property
    def seen(self) -> Seen:
        """Along these directions."""
        return Seen.along(self.directions, self.points, self.normals)

    def along(self, direction: Array) -> Seen:
        """Along one (3,)."""
        return Seen.along(direction[None], self.points, self.normals)


def robust_linear_solve(columns: Array, target: Array, rounds: int = 4) -> Array:
    """Solutions (K, m) of K overdetermined systems, m at most 9.

    They are  sum_k columns[:, k] . x_k = target  with columns (K, m, N) and target (K, N), reweighted by
    1 / (1 + (residual / median)^2), so that a minority of outliers moves them little.
    """
    return _linear.solve_linear(np.ascontiguousarray(columns), np.ascontiguousarray(target), rounds)


def circles(x: Array, y: Array, rounds: int = 4) -> tuple[Array, Array, Array]:
    """Centres and radii of circles through K sets of N plane points, by Kasa's linear fit.

    Source: Kasa, "A circle fitting procedure and its error analysis", IEEE Trans. Instrum. Meas. 25, 1976.
    """
    return _circles_of(_linear.solve_circles(np.ascontiguousarray(x), np.ascontiguousarray(y), rounds))


def profile_circles(points: Array, axes: Array, feet: Array, rounds: int = 4) -> tuple[Array, Array, Array]:
    """The same of the profiles of points (N, 3) about K axes (K, 3) through feet (K, 3).

    Distance from the axis, height above the foot, and radius, (K,) each.
    """
    return _circles_of(
        _linear.solve_profiles(
            np.ascontiguousarray(points), np.ascontiguousarray(axes), np.ascontiguousarray(feet), rounds
        )
    )


def spine_circle(
    cylinder: Array, points: Array, normals: Array, rounds: int = 4
) -> tuple[Array, Array, float]:
    """Axis (3,), centre (3,) and radius of the circle that a tube's middle is, as its outside looks.

    The tube is near a cylinder (9,); points (N, 3) lead back along their normals (N, 3), of either sign, by
    its radius. Those farther off it than twice the median are left out.
    """
    return _linear.solve_spine(
        np.ascontiguousarray(cylinder), np.ascontiguousarray(points), np.ascontiguousarray(normals), rounds
    )


def cones(x: Array, y: Array, height: Array, rounds: int = 4) -> tuple[Array, Array]:
    """The quadrics  x^2 + y^2 = a x + b y + m h^2 + e h + f  through K sets of N points.

    Coefficients (K, 5), and the median heights (K,).
    """
    return _linear.solve_cones(
        np.ascontiguousarray(x), np.ascontiguousarray(y), np.ascontiguousarray(height), rounds
    )


def _circles_of(solution: Array) -> tuple[Array, Array, Array]:
    """Centres and radii of  x^2 + y^2 = a x + b y + c  from (K, 3)."""
    center_x, center_y = solution[:, 0] / 2.0, solution[:, 1] / 2.0
    return center_x, center_y, np.sqrt(np.maximum(solution[:, 2] + center_x**2 + center_y**2, 1e-12))


def random_subsets(n: int, size: int, count: int, rng: np.random.Generator) -> NDArray[np.intp]:
    """`count` sets of `size` distinct indices below `n`, shape (count, size)."""
    return np.argsort(rng.random((count, n)), axis=1)[:, :size]
