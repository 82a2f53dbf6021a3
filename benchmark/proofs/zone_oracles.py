"""Slow and independent optima of extreme points; nothing here is shared with `fitting`."""

from collections.abc import Iterable
from itertools import combinations

import numpy as np
from scipy.optimize import minimize

from .oracles import DOF, Array, Surface, distances, moved

ROUNDS = 3
"""From each start, on what the round before has found."""


def extreme(kind: str, surface: Surface, points: Array, criterion: str) -> float:
    """Largest distance, or radius of the least surface about this axis or centre with all points inside,
    or of the largest with all outside."""
    d = distances(kind, surface, points.astype(np.longdouble)).astype(np.float64)
    if criterion == "minimum_zone":
        return float(np.abs(d).max())
    return float(surface["radius"]) + float(d.max() if criterion == "minimum_circumscribed" else d.min())


def polished(kind: str, starts: Iterable[Surface], points: Array, criterion: str) -> float:
    """The extreme value that SLSQP reaches on the problem with one more variable and all constraints.

    Points are to be centred and of extent near 1.
    """
    ends = [_polished(kind, start, points, criterion) for start in starts]
    return max(ends) if criterion == "maximum_inscribed" else min(ends)


def _polished(kind: str, surface: Surface, points: Array, criterion: str) -> float:
    far = points.astype(np.longdouble)
    free = DOF[kind] - (criterion != "minimum_zone")

    def values(step: Array) -> Array:
        after = moved(kind, surface, np.append(step, np.zeros(DOF[kind] - free)))
        d = distances(kind, after, far).astype(np.float64)
        if criterion == "minimum_zone":
            return np.concatenate([d, -d])
        rho = d + float(surface["radius"])
        return rho if criterion == "minimum_circumscribed" else -rho

    def slopes(step: Array) -> Array:
        units = 1e-6 * np.eye(free)
        return np.stack([(values(step + unit) - values(step - unit)) / 2e-6 for unit in units], axis=1)

    best, step = np.inf, np.zeros(free)
    for _ in range(ROUNDS):
        found = minimize(
            lambda x: x[-1],
            np.append(step, values(step).max()),
            jac=lambda x: np.append(np.zeros(free), 1.0),
            constraints={
                "type": "ineq",
                "fun": lambda x: x[-1] - values(x[:-1]),
                "jac": lambda x: np.column_stack([-slopes(x[:-1]), np.ones(len(values(x[:-1])))]),
            },
            bounds=[(-0.3, 0.3)] * free + [(None, None)],
            method="SLSQP",
            options={"ftol": 1e-16, "maxiter": 200},
        )
        if not np.all(np.isfinite(found.x)):
            break
        step = found.x[:-1]
        best = min(best, float(values(step).max()))
    return -best if criterion == "maximum_inscribed" else best


def flatness(points: Array) -> float:
    """The least width between two parallel planes around the points, by trying all that touch enough of them.

    Either one plane holds three points of the hull, or each holds two.
    """
    edges = points[:, None] - points[None]
    pairs = np.array(list(combinations(range(len(points)), 2)))
    directions = edges[pairs[:, 0], pairs[:, 1]]
    normals = np.cross(directions[:, None], directions[None]).reshape(-1, 3)
    lengths = np.linalg.norm(normals, axis=1)
    normals = normals[lengths > 1e-9] / lengths[lengths > 1e-9, None]
    return float(np.ptp(normals @ points.T, axis=1).min())


def smallest_sphere(points: Array) -> float:
    """Radius of the smallest sphere with all points inside, by trying all with two, three or four on them."""
    best = np.inf
    for size in (2, 3, 4):
        for chosen in combinations(points, size):
            origin, edges = chosen[0], np.array(chosen[1:]) - chosen[0]
            gram = edges @ edges.T
            center = origin + np.linalg.solve(2.0 * gram, np.diag(gram)) @ edges
            radius = float(np.linalg.norm(origin - center))
            if radius < best and np.linalg.norm(points - center, axis=1).max() <= radius * (1 + 1e-12):
                best = radius
    return best
