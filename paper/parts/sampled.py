"""The mean fitting error of the paper: distances to a surface that is sampled on a grid of its parameters."""

import numpy as np
from scipy.spatial import cKDTree

from primfit.fitting.geometry.vectors import Array, around_axis, basis
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.torus import Torus

GRID = 100
"""Samples along each parameter."""


def sampled_error(surface: Primitive, points: Array, grid: int = GRID) -> float:
    """Mean distance of points (N, 3) from the nearest sample, over the diagonal of their bounding box."""
    samples = surface.surface(*np.meshgrid(*spans(surface, points, grid))).reshape(-1, 3)
    if not np.isfinite(samples).all():
        return np.inf
    return float(cKDTree(samples).query(points)[0].mean() / np.linalg.norm(np.ptp(points, axis=0)))


def spans(surface: Primitive, points: Array, grid: int) -> list[Array]:
    """Both parameters of `Primitive.surface`: full turns, and as far as the points reach in lengths."""
    turn = np.linspace(0.0, 2.0 * np.pi, grid)
    match surface:
        case Plane():
            sides = [(points - surface.point) @ side for side in basis(surface.normal)]
            return [np.linspace(side.min(), side.max(), grid) for side in sides]
        case Cylinder():
            heights = around_axis(points, surface.point, surface.axis)[2]
        case Cone():
            heights = np.maximum(around_axis(points, surface.apex, surface.axis)[2], 0.0)
        case Torus():
            return [turn, turn]
        case _:
            return [turn, turn / 2.0]
    return [turn, np.linspace(heights.min(), heights.max(), grid)]
