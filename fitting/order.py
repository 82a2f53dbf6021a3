"""Orders and samples of points that do not depend on how the points are listed, turned or moved."""

import numpy as np

from fitting.geometry import TINY, Array

RESOLVED = 1e-9
"""Squared distances from the centroid that differ by less, over the largest, count as equal."""


def canonical_order(points: Array) -> np.ndarray:
    """Indices (N,) that sort the points (N, 3) by their distance from the centroid, then by x, y and z."""
    key = _distance_keys(points)
    order = np.argsort(key)
    equal = key[order][1:] == key[order][:-1]
    if equal.any():
        tied = np.concatenate([equal, [False]]) | np.concatenate([[False], equal])
        among = order[tied]
        x, y, z = points[among].T
        order[tied] = among[np.lexsort((z, y, x, key[among]))]
    return order


def is_first(ordered: Array) -> np.ndarray:
    """Mask (N,) of the points in canonical order that are not the same as the one before."""
    first = np.ones(len(ordered), bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    return first


def _distance_keys(points: Array) -> np.ndarray:
    """Squared distances (N,) from the centroid as whole numbers of what is resolved."""
    low, high = points.min(axis=0), points.max(axis=0)
    extent = max(float(np.max(high / 2.0 - low / 2.0)), TINY)
    offsets = points / extent - low / extent
    offsets -= offsets.mean(axis=0)
    squared = np.einsum("ij,ij->i", offsets, offsets)
    return np.round(squared / (RESOLVED * max(float(squared.max()), TINY))).astype(np.uint64)


def _hashed(keys: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The keys (N,) spread over all 64-bit numbers, another way for each state of `rng`.

    Source: the finaliser of MurmurHash3 (Appleby, 2011), after a multiplication by a random odd number.
    """
    mixed = keys * (2 * rng.integers(2**62, dtype=np.uint64) + np.uint64(1))
    for factor in (0xFF51AFD7ED558CCD, 0xC4CEB9FE1A85EC53):
        mixed ^= mixed >> np.uint64(33)
        mixed *= np.uint64(factor)
    return mixed ^ (mixed >> np.uint64(33))


def canonical_sample(
    points: Array, count: int, rng: np.random.Generator, repeated: bool = False
) -> np.ndarray:
    """Indices (count,) of a random sample of the points (N, 3), N > count, in canonical order.

    The points with the smallest hashes of their distances. Where points of the sample repeat others, it is
    one of the different points, and all of them if there are no more; unless points may be `repeated`.
    """
    hashed = _hashed(_distance_keys(points), rng)
    chosen = _of_smallest(hashed, points, count, rng)
    if repeated or is_first(points[chosen]).all():
        return chosen
    order = canonical_order(points)
    different = order[is_first(points[order])]
    if len(different) <= count:
        return different
    return different[_of_smallest(hashed[different], points[different], count, rng)]


def _of_smallest(hashed: np.ndarray, points: Array, count: int, rng: np.random.Generator) -> np.ndarray:
    """Indices (count,) of the points (N, 3) with the smallest hashes (N,), in canonical order.

    Where many distances are the same, which a hash cannot tell apart, any in canonical order.
    """
    chosen = np.argpartition(hashed, count)[:count]
    if np.count_nonzero(hashed <= hashed[chosen].max()) > count:
        chosen = canonical_order(points)[rng.choice(len(points), count, replace=False)]
    return chosen[canonical_order(points[chosen])]
