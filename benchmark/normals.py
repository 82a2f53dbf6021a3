"""Normals for methods that need some, as primfit estimated them in 0.2.0, frozen.

A copy of `fitting.cloud.normals.estimate_normals` of that day, in NumPy: whatever primfit does to its own
normals afterwards, what others are given, and the time that it takes them, stay as they were.
"""

import numpy as np
from scipy.spatial import cKDTree

from primfit.fitting.geometry.vectors import Array

NEIGHBOURS = 16


def estimate_normals(points: Array, k: int = NEIGHBOURS) -> Array:
    """Normals from the plane through the `k` nearest neighbours; their sign is arbitrary.

    Parameters
    ----------
    points : (N, 3) cloud
    k : neighbours used, the point itself included; fewer where the cloud is smaller

    Returns
    -------
    (N, 3) unit normals

    Source: Hoppe et al., "Surface reconstruction from unorganized points", SIGGRAPH 1992, section 3.2.
    """
    k = min(k, len(points))
    if k < 3:
        return np.tile([0.0, 0.0, 1.0], (len(points), 1))
    _, neighbours = cKDTree(points).query(points, k=k)
    offsets = points[neighbours]
    offsets -= offsets.mean(axis=1, keepdims=True)
    vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))[1]
    return np.asarray(vectors[:, :, 0])
