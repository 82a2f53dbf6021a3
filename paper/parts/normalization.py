"""Clouds as networks take them: centered at the centroid, in the unit sphere, of a fixed number of points.

M3 to M6 all center and scale; M4 and M6 name the unit sphere, the others are given the same.
"""

import numpy as np

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.geometry.vectors import Array


def unit_sphere(points: Array) -> Frame:
    """The frame about the centroid of points (N, 3) in which the farthest of them has the norm 1.

    Where all points are one, or the norm is no number, the scale is that of `Frame.of`.
    """
    frame = Frame.of(points)
    scale = frame.scale * float(np.linalg.norm(frame.normalize(points), axis=1).max())
    return Frame(frame.center, scale if 0.0 < scale < np.inf else frame.scale)


def resampled(points: Array, count: int, rng: np.random.Generator) -> Array:
    """So many of the points (N, 3), in random order; each as often as the others, give or take once."""
    turns = -(-count // len(points))
    return points[np.concatenate([rng.permutation(len(points)) for _ in range(turns)])[:count]]
