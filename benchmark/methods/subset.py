"""Fewer points for libraries that loop over them in Python."""

import numpy as np

from primfit.fitting.geometry.vectors import Array

MOST_POINTS = 1000


def at_most(count: int, points: Array) -> Array:
    """The points (N, 3), or `count` random ones of them, always the same, where there are more."""
    if len(points) <= count:
        return points
    return points[np.random.default_rng(0).permutation(len(points))[:count]]
