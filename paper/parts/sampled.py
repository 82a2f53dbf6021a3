"""The mean fitting error of the paper: distances to a surface that is sampled on a grid of its parameters."""

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.shrec22 import sampled_distances

GRID = 100
"""Samples along each parameter."""


def sampled_error(surface: Primitive, points: Array, grid: int = GRID) -> float:
    """Mean distance of points (N, 3) from the nearest sample, over the diagonal of their bounding box."""
    mean = sampled_distances(surface, points, grid).mean()
    return float(mean / np.linalg.norm(np.ptp(points, axis=0)))
