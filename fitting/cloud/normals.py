"""Unit normals of a cloud, and its noise, from local principal components."""

import numpy as np

from ..geometry.vectors import Array
from . import _pieces
from .patches import Halved

NEIGHBOURS = 16


def estimate_normals(points: Array, k: int = NEIGHBOURS, at: Array | None = None) -> Array:
    """Normals from the plane through the `k` nearest neighbors; their sign is arbitrary.

    Parameters
    ----------
    points : (N, 3) cloud
    k : neighbors used, the point itself included; fewer where the cloud is smaller
    at : (M, 3) places to estimate at; the points themselves by default

    Returns
    -------
    (N, 3) or (M, 3) unit normals

    Source: Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992, section 3.2.
    """
    return local_planes(points, Halved.of(points), points if at is None else at, k)[0]


def local_planes(points: Array, halved: Halved, at: Array, k: int = NEIGHBOURS) -> tuple[Array, Array, Array]:
    """Normals (M, 3) as `estimate_normals`, and how neighbors scatter: about their planes, (M,), and along
    those in the narrower direction, (M,).

    They are standard deviations. That about the plane is unbiased for independent noise on a flat surface;
    curvature adds to it, and correlation of the noise takes from it. Of neighbors that are as far, the
    earlier ones count.
    """
    k = min(k, len(points))
    if k < 3:
        return np.tile([0.0, 0.0, 1.0], (len(at), 1)), np.zeros(len(at)), np.zeros(len(at))
    contiguous = (np.ascontiguousarray(each, np.float64) for each in (points, at))
    return _pieces.local_planes(next(contiguous), halved.order, halved.times, next(contiguous), k)
