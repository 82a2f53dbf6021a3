"""Normals by voting: planes through some neighbors vote for the direction of their normal.

In the Hesse normal form  n . x = rho  a plane through a point has the direction n left to vote for. Votes are
spread by a Gaussian kernel, as in Limberger and Oliveira, "Real-time detection of planar regions in
unorganized point clouds", Pattern Recognition 48(6), 2015, section 3.3; each candidate is a plane through
three neighbors, as in Boulch and Marlet, "Fast and robust normal estimation for point clouds with sharp
features", Computer Graphics Forum 31(5), 2012.
"""

import numpy as np
from scipy.spatial import cKDTree

from primfit.fitting.geometry.vectors import TINY, Array, cross
from primfit.fitting.guesses.oriented import Oriented, random_subsets

NEIGHBOURS = 24
TRIPLES = 40
SPREAD = np.radians(8.0)
"""Standard deviation of the kernel by which a vote is spread."""


def hough_normals(points: Array, at: Array, rng: np.random.Generator) -> tuple[Oriented, Array]:
    """Points `at` (M, 3) of a cloud (N, 3) with the most voted normals, and the shares (M,) of the votes."""
    near = points[cKDTree(points).query(at, min(NEIGHBOURS, len(points)))[1].reshape(len(at), -1)]
    corners = near[:, random_subsets(near.shape[1], 3, TRIPLES, rng)]
    across = cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
    area = np.linalg.norm(across, axis=2)
    across /= area[..., None] + TINY
    cosines = np.einsum("mti,msi->mts", across, across)
    votes = np.exp((cosines**2 - 1.0) / (2.0 * SPREAD**2)) * area[:, None]
    totals = votes.sum(axis=2)
    best = np.argmax(totals * (area > 0.0), axis=1)
    chosen = np.arange(len(at))
    weights = votes[chosen, best] * np.where(cosines[chosen, best] < 0.0, -1.0, 1.0)
    normals = np.einsum("mt,mti->mi", weights, across)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + TINY
    return Oriented(at, normals), totals[chosen, best] / (area.sum(axis=1) + TINY)
