"""Levenberg-Marquardt on signed orthogonal distances, under any kernel, for any primitive.

Source: Levenberg 1944, Marquardt 1963; damping on the scaled diagonal as in More, "The Levenberg-Marquardt
algorithm", 1978. Our own rather than scipy's because a step of five to seven parameters is one small
solve, and the search below takes two steps at each of many scales.
"""

from dataclasses import dataclass

import numpy as np

from fitting.geometry import Array
from fitting.kernels import Kernel, LeastSquares
from fitting.primitives import Primitive

SMALLEST_STEP = 1e-15
"""Steps below this length, in a frame of extent near 1, change nothing any more."""

LARGEST_DAMPING = 1e8


@dataclass(frozen=True)
class Refined:
    """A refined primitive, its cost  sum rho(d / scale), and whether the steps came to rest."""

    primitive: Primitive
    cost: float
    converged: bool


def refine(
    primitive: Primitive,
    points: Array,
    kernel: Kernel | None = None,
    scale: float = 1.0,
    max_iterations: int = 60,
) -> Refined:
    """The primitive that minimises  sum rho(d / scale)  near the given one.

    Parameters
    ----------
    primitive : where to start, in the frame of the points
    points : (N, 3) in a frame centred near the origin, extent near 1
    kernel : `LeastSquares` by default
    scale : residual of one unit, in the unit of the points
    max_iterations : steps that lower the cost
    """
    kernel = kernel or LeastSquares()
    damping = 1e-12
    distance, jacobian = primitive.linearize(points)
    squared = (distance / scale) ** 2
    cost = float(kernel.rho(squared).sum())
    for _ in range(max_iterations):
        weighted = jacobian * kernel.weight(squared)[:, None]
        normal = weighted.T @ jacobian
        gradient = weighted.T @ distance
        if not np.all(np.isfinite(normal)):
            return Refined(primitive, cost, False)
        diagonal = np.diag(normal).copy()
        diagonal += 1e-14 * max(float(diagonal.max()), 1e-300)
        while True:
            step = np.asarray(np.linalg.solve(normal + np.diag(damping * diagonal), -gradient), np.float64)
            if not np.all(np.isfinite(step)):
                return Refined(primitive, cost, False)
            if float(np.abs(step).max()) <= SMALLEST_STEP:
                return Refined(primitive, cost, True)
            candidate = primitive.stepped(step)
            new_distance, new_jacobian = candidate.linearize(points)
            new_squared = (new_distance / scale) ** 2
            new_cost = float(kernel.rho(new_squared).sum())
            if new_cost < cost:
                break
            damping = max(damping * 8.0, 1e-6)
            if damping > LARGEST_DAMPING:
                return Refined(primitive, cost, True)
        gain = cost - new_cost
        primitive, distance, jacobian, squared = candidate, new_distance, new_jacobian, new_squared
        cost = new_cost
        damping = max(damping * 0.1, 1e-12)
        if gain <= 1e-15 * cost:
            return Refined(primitive, cost, True)
    return Refined(primitive, cost, False)
