"""Unit normals of a cloud, and its noise, from local principal components."""

import numpy as np

from ..geometry.vectors import Array

NEIGHBOURS = 16


def estimate_normals(points: Array, k: int = NEIGHBOURS, at: Array | None = None) -> Array:
    """Normals from the plane through the `k` nearest neighbours; their sign is arbitrary.

    Parameters
    ----------
    points : (N, 3) cloud
    k : neighbours used, the point itself included; fewer where the cloud is smaller
    at : (M, 3) places to estimate at; the points themselves by default

    Returns
    -------
    (N, 3) or (M, 3) unit normals

    Source: Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992, section 3.2.
    """
    return local_planes(points, k, at)[0]


def local_planes(points: Array, k: int = NEIGHBOURS, at: Array | None = None) -> tuple[Array, Array]:
    """Normals as `estimate_normals`, and how far the neighbours scatter about their planes, (N,) or (M,).

    The scatter is a standard deviation, unbiased for independent noise on a flat surface; curvature adds to
    it, and correlation of the noise takes from it.
    """
    from scipy.spatial import cKDTree

    where = points if at is None else at
    k = min(k, len(points))
    if k < 3:
        return np.tile([0.0, 0.0, 1.0], (len(where), 1)), np.zeros(len(where))
    _, neighbours = cKDTree(points).query(where, k=k)
    offsets = points[neighbours]
    offsets -= offsets.mean(axis=1, keepdims=True)
    squares, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    return vectors[:, :, 0], np.sqrt(np.maximum(squares[:, 0], 0.0) / max(k - 3, 1))
