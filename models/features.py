"""What a classifier sees of a cloud: numbers that rotation, translation, scale and order do not change.

The shape of the cloud and of its Gauss map, the histogram of oriented normal vectors, surflet-pair relations,
and how rough fits of all kinds compare. The histograms are those of method M2 of SHREC 2022 (Romanengo et
al., 2022, section 3.2), made invariant: normals are seen from the eigenvectors of their own scatter, up to
sign.

Sources: Tang et al., "Histogram of oriented normal vectors for object recognition with a depth sensor", ACCV
2012; Wahl, Hillenbrand and Hirzinger, "Surflet-pair-relation histograms", 3DIM 2003.
"""

import numpy as np
from numpy.typing import NDArray

from .rough import N_ROUGH, evenly, rough_features

Array = NDArray[np.float64]

FEATURE_VERSION = 3
"""Raised with any change that alters a number below: weights of another version are refused."""

SAMPLE_POINTS = 512
PAIR_POINTS = 64
NORMAL_BINS = 10
PAIR_BINS = 8
DISTANCE_BINS = 4
DISTANCE_BIN_WIDTH = 2.0 / 3.0
"""In rms radii of the cloud; the last bin holds everything farther."""

PAIRS = np.triu_indices(PAIR_POINTS, 1)

BLOCKS = {
    "shape": 3,
    "gauss_map": 4,
    "normals": 3 * NORMAL_BINS,
    "pair_normals": PAIR_BINS * DISTANCE_BINS,
    "pair_directions": PAIR_BINS * DISTANCE_BINS,
    "rough_fits": N_ROUGH,
}
"""The blocks of a feature vector, in order, with their lengths."""
N_FEATURES = sum(BLOCKS.values())


def features(points: Array, normals: Array) -> Array:
    """The features of a cloud.

    Parameters
    ----------
    points : (N, 3), N >= 3, any unit
    normals : (N, 3) unit normals, signs arbitrary

    Returns
    -------
    (N_FEATURES,) finite numbers of order 1, bit for bit the same for every order of the points
    """
    points, normals = representatives(points, normals)
    return np.concatenate(
        [
            shape_features(points),
            gauss_map_features(normals),
            normal_features(normals),
            *pair_features(*evenly(PAIR_POINTS, points, normals)),
            rough_features(points, normals),
        ]
    )


def representatives(points: Array, normals: Array) -> tuple[Array, Array]:
    """At most `SAMPLE_POINTS` of the points, spread evenly over the distances to the centroid, in rms radii.

    The choice follows the shape, not the order or the pose: coordinates are sorted before they are summed,
    and points at equal distances are ordered by their coordinates.
    """
    centered = points - np.sort(points, axis=0).mean(axis=0)
    radius = np.sqrt(np.einsum("ij,ij->i", centered, centered))
    order = np.argsort(radius)
    if np.any(np.diff(radius[order]) == 0.0):
        order = np.lexsort((*centered.T, radius))
    centered, normals = evenly(SAMPLE_POINTS, centered[order], normals[order])
    centered = centered - centered.mean(axis=0)
    scale = np.sqrt(np.mean(np.einsum("ij,ij->i", centered, centered)))
    return centered / (scale if scale > 0.0 else 1.0), normals


def shape_features(points: Array) -> Array:
    """Standard deviations along the principal axes, ascending, shape (3,)."""
    return np.sqrt(np.maximum(np.linalg.eigvalsh(points.T @ points / len(points)), 0.0))


def gauss_map_features(normals: Array) -> Array:
    """Eigenvalues of the scatter of the normals, ascending, and the logarithm of the smallest, shape (4,)."""
    values = np.maximum(np.linalg.eigvalsh(normals.T @ normals / len(normals)), 0.0)
    return np.append(values, np.log10(values[0] + 1e-4))


def normal_features(normals: Array) -> Array:
    """Histograms of |cosine| between the normals and each eigenvector of their scatter, smallest first."""
    _, axes = np.linalg.eigh(normals.T @ normals)
    cosines = np.abs(normals @ axes)
    return np.concatenate([_histogram(cosines[:, k] * NORMAL_BINS, NORMAL_BINS) for k in range(3)])


def pair_features(points: Array, normals: Array) -> tuple[Array, Array]:
    """Two histograms over all pairs, each by distance: |n1 . n2|, and the larger |d . n| of the two ends.

    d is the unit vector between the points. Coinciding points count as seen across their normals.
    """
    n = len(points)
    i, j = PAIRS if n == PAIR_POINTS else np.triu_indices(n, 1)
    heights = points @ normals.T
    heights -= np.einsum("ij,ij->i", points, normals)
    squared = points @ points.T
    diagonal = np.diagonal(squared)
    squared = np.maximum(diagonal[:, None] + diagonal - 2.0 * squared, 0.0)[i, j]
    distance = np.sqrt(squared)
    direction = np.maximum(np.abs(heights[i, j]), np.abs(heights[j, i])) / np.maximum(distance, 1e-12)
    alike = np.abs(normals @ normals.T)[i, j]
    near = np.minimum((distance / DISTANCE_BIN_WIDTH).astype(int), DISTANCE_BINS - 1)
    return (
        _histogram(alike * PAIR_BINS, PAIR_BINS, near),
        _histogram(np.minimum(direction, 1.0) * PAIR_BINS, PAIR_BINS, near),
    )


def _histogram(position: Array, bins: int, group: NDArray[np.int_] | int = 0) -> Array:
    """Shares of the positions in unit bins; with a group, bins by groups, flattened."""
    groups = DISTANCE_BINS if isinstance(group, np.ndarray) else 1
    index = np.clip(position.astype(int), 0, bins - 1) * groups + group
    return np.bincount(index, minlength=bins * groups) / len(position)
