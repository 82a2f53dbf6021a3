"""Orders and samples of points that do not depend on how the points are listed, turned or moved."""

import numpy as np

from ..geometry.vectors import Array
from . import _passes

RESOLVED = 1e-6
"""Squared distances that differ by less, over the largest, count as equal: rounding hardly ever tells them
apart, also far from the origin."""


def canonical_order(points: Array, keys: np.ndarray) -> np.ndarray:
    """Indices (N,) that sort the points (N, 3) by their keys (N,), then by x, y and z."""
    order, ties = _passes.sorted_places(keys)
    if ties:
        equal = keys[order][1:] == keys[order][:-1]
        tied = np.concatenate([equal, [False]]) | np.concatenate([[False], equal])
        among = order[tied]
        x, y, z = points[among].T
        order[tied] = among[np.lexsort((z, y, x, keys[among]))]
    return order


def distance_keys(points: Array, box: Array) -> np.ndarray:
    """Squared distances of points (N, 3) from two centers that move with the cloud, in one number (N,).

    The centers are the centroid and, beside it, the mean of the offsets from it weighted by their squares.
    The first is in the upper 32 bits and the second in the lower, in units of `RESOLVED` times the largest of
    the first. The box (2, 3) is the one around the points.
    """
    return _passes.distance_keys(points, box, RESOLVED)


def _hashed(keys: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The keys (N,) spread over all 64-bit numbers, another way for each state of `rng`.

    Source: the finalizer of MurmurHash3 (Appleby, 2011), after a multiplication by a random odd number.
    """
    return _passes.hashed(keys, 2 * int(rng.integers(2**62, dtype=np.uint64)) + 1)


def canonical_sample(
    points: Array, keys: np.ndarray, count: int, rng: np.random.Generator, repeated: bool = False
) -> np.ndarray:
    """Indices (count,) of a random sample of the points (N, 3), N > count, in canonical order.

    The points with the smallest hashes of their keys (N,). Where points of the sample repeat others, it is
    one of the different points, and all of them if there are no more; unless points may be `repeated`.
    """
    hashed = _hashed(keys, rng)
    chosen = _of_smallest(hashed, points, keys, count, rng)
    if repeated or len(_passes.firsts(points[chosen])) == count:
        return chosen
    order = canonical_order(points, keys)
    different = order[_passes.firsts(points[order])]
    if len(different) <= count:
        return different
    return different[_of_smallest(hashed[different], points[different], keys[different], count, rng)]


def shuffled(keys: np.ndarray, count: int, rng: np.random.Generator) -> np.ndarray:
    """Indices of at most `count` points in canonical order, as at random.

    By hashes of their keys (N,) and, where those are the same, of their places among them. A point more, or a
    key that rounds the other way, moves no others.
    """
    return _passes.smallest(_hashed(_passes.told_apart(keys), rng), count)


def _of_smallest(
    hashed: np.ndarray, points: Array, keys: np.ndarray, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Indices (count,) of the points (N, 3) with the smallest hashes (N,), in canonical order.

    Where many distances are the same, which a hash cannot tell apart, any in canonical order.
    """
    chosen = _passes.smallest(hashed, count)
    if np.count_nonzero(hashed <= hashed[chosen[-1]]) > count:
        chosen = canonical_order(points, keys)[rng.choice(len(points), count, replace=False)]
    return chosen[canonical_order(points[chosen], keys[chosen])]
