"""What is compiled in `models.features`, in NumPy."""

import numpy as np
from numpy.typing import NDArray

from primfit.models import features
from primfit.models.rough import evenly

Array = NDArray[np.float64]


def representatives(points: Array, normals: Array) -> tuple[Array, Array]:
    """At most so many of the points, spread evenly over the distances to the centroid, in rms radii.

    The choice follows the shape, not the order or the pose: coordinates are sorted before they are summed,
    and points at equal distances are ordered by their coordinates.
    """
    centered = points - np.sort(points, axis=0).mean(axis=0)
    radius = np.sqrt(np.einsum("ij,ij->i", centered, centered))
    order = np.argsort(radius)
    if np.any(np.diff(radius[order]) == 0.0):
        order = np.lexsort((*centered.T, radius))
    centered, normals = evenly(features.SAMPLE_POINTS, centered[order], normals[order])
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
    return np.concatenate(
        [_histogram(cosines[:, k] * features.NORMAL_BINS, features.NORMAL_BINS) for k in range(3)]
    )


def pair_features(points: Array, normals: Array) -> tuple[Array, Array]:
    """Two histograms over all pairs, each by distance: |n1 . n2|, and the larger |d . n| of the two ends.

    d is the unit vector between the points. Coinciding points count as seen across their normals.
    """
    points, normals = evenly(features.PAIR_POINTS, points, normals)
    n = len(points)
    i, j = np.triu_indices(n, 1)
    heights = points @ normals.T
    heights -= np.einsum("ij,ij->i", points, normals)
    squared = points @ points.T
    diagonal = np.diagonal(squared)
    squared = np.maximum(diagonal[:, None] + diagonal - 2.0 * squared, 0.0)[i, j]
    distance = np.sqrt(squared)
    direction = np.maximum(np.abs(heights[i, j]), np.abs(heights[j, i])) / np.maximum(distance, 1e-12)
    alike = np.abs(normals @ normals.T)[i, j]
    near = np.minimum((distance / features.DISTANCE_BIN_WIDTH).astype(int), features.DISTANCE_BINS - 1)
    return (
        _histogram(alike * features.PAIR_BINS, features.PAIR_BINS, near),
        _histogram(np.minimum(direction, 1.0) * features.PAIR_BINS, features.PAIR_BINS, near),
    )


def _histogram(position: Array, bins: int, group: NDArray[np.int_] | int = 0) -> Array:
    """Shares of the positions in unit bins; with a group, bins by groups, flattened."""
    groups = features.DISTANCE_BINS if isinstance(group, np.ndarray) else 1
    index = np.clip(position.astype(int), 0, bins - 1) * groups + group
    return np.bincount(index, minlength=bins * groups) / len(position)
