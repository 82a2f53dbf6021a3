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

from . import _features
from .rough import N_ROUGH, RoughFits, rough_features

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
    return features_and_fits(points, normals)[0]


def features_and_fits(points: Array, normals: Array) -> tuple[Array, RoughFits]:
    """The features of a cloud, and the rough fits that some of them are about."""
    points, normals, center, radius = _representatives(points, normals)
    row, fits = rough_features(points, normals)
    found = [shape_features(points), *normal_features(normals), *pair_features(points, normals), row]
    return np.concatenate(found), RoughFits(fits, center, radius)


def representatives(points: Array, normals: Array) -> tuple[Array, Array]:
    """At most `SAMPLE_POINTS` of the points, spread evenly over the distances to the centroid, in rms radii.

    The choice follows the shape, not the order or the pose: coordinates are sorted before they are summed,
    and points at equal distances are ordered by their coordinates.
    """
    return _representatives(points, normals)[:2]


def _representatives(points: Array, normals: Array) -> tuple[Array, Array, Array, float]:
    """With the center (3,) and the rms radius that they had."""
    points, normals = (np.ascontiguousarray(each, np.float64) for each in (points, normals))
    centroid = np.sort(points, axis=0).mean(axis=0)
    centered, radius = _features.radii(points, centroid)
    order = np.argsort(radius)
    ascending = radius[order]
    if (ascending[1:] == ascending[:-1]).any():
        order = np.lexsort((*centered.T, radius))
    few, few_normals, center, size = _features.chosen(centered, normals, order, SAMPLE_POINTS)
    return few, few_normals, centroid + center, size


def shape_features(points: Array) -> Array:
    """Standard deviations along the principal axes, ascending, shape (3,)."""
    return _features.shape(points)


def normal_features(normals: Array) -> tuple[Array, Array]:
    """Of the scatter of the normals: eigenvalues, ascending, and the logarithm of the smallest, shape (4,);
    histograms of |cosine| between the normals and each of its eigenvectors, smallest first."""
    values, shares = _features.gauss_map(normals, NORMAL_BINS)
    return values, shares.ravel()


def pair_features(points: Array, normals: Array) -> tuple[Array, Array]:
    """Two histograms over all pairs, each by distance: |n1 . n2|, and the larger |d . n| of the two ends.

    Of `PAIR_POINTS` points at most; d is the unit vector between two of them. Coinciding points count as seen
    across their normals.
    """
    alike, across = _features.pairs(
        points, normals, PAIR_POINTS, PAIR_BINS, DISTANCE_BINS, DISTANCE_BIN_WIDTH
    )
    return alike.ravel(), across.ravel()
