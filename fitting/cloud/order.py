"""Orders and samples of points that do not depend on how the points are listed, turned or moved."""

import numpy as np

from ..geometry.vectors import TINY, Array

RESOLVED = 1e-6
"""Squared distances that differ by less, over the largest, count as equal: rounding hardly ever tells them
apart, also far from the origin."""


def canonical_order(points: Array, keys: np.ndarray) -> np.ndarray:
    """Indices (N,) that sort the points (N, 3) by their keys (N,), then by x, y and z."""
    order = np.argsort(keys)
    equal = keys[order][1:] == keys[order][:-1]
    if equal.any():
        tied = np.concatenate([equal, [False]]) | np.concatenate([[False], equal])
        among = order[tied]
        x, y, z = points[among].T
        order[tied] = among[np.lexsort((z, y, x, keys[among]))]
    return order


def is_first(ordered: Array) -> np.ndarray:
    """Mask (N,) of the points in canonical order that are not the same as the one before."""
    first = np.ones(len(ordered), bool)
    first[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    return first


def distance_keys(points: Array) -> np.ndarray:
    """Squared distances of the points (N, 3) from two centres that move with the cloud, in one number (N,).

    The centres are the centroid and, beside it, the mean of the offsets from it weighted by their squares.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    extent = max(float(np.max(high / 2.0 - low / 2.0)), TINY)
    offsets = points / extent - low / extent
    offsets -= offsets.mean(axis=0)
    squared = np.einsum("ij,ij->i", offsets, offsets)
    unit = RESOLVED * max(float(squared.max()), TINY)
    offsets -= squared @ offsets / max(float(squared.sum()), TINY)
    first, second = (
        np.round(each / unit).astype(np.uint64) for each in (squared, np.einsum("ij,ij->i", offsets, offsets))
    )
    return (first << np.uint64(32)) + second


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
    points: Array, keys: np.ndarray, count: int, rng: np.random.Generator, repeated: bool = False
) -> np.ndarray:
    """Indices (count,) of a random sample of the points (N, 3), N > count, in canonical order.

    The points with the smallest hashes of their keys (N,). Where points of the sample repeat others, it is
    one of the different points, and all of them if there are no more; unless points may be `repeated`.
    """
    hashed = _hashed(keys, rng)
    chosen = _of_smallest(hashed, points, keys, count, rng)
    if repeated or is_first(points[chosen]).all():
        return chosen
    order = canonical_order(points, keys)
    different = order[is_first(points[order])]
    if len(different) <= count:
        return different
    return different[_of_smallest(hashed[different], points[different], keys[different], count, rng)]


def shuffled(keys: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Indices (N,) of points in canonical order, as at random.

    By hashes of their keys (N,) and, where those are the same, of their places among them. A point more, or a
    key that rounds the other way, moves no others.
    """
    starts = np.flatnonzero(np.append(True, keys[1:] != keys[:-1]))
    places = np.arange(len(keys)) - np.repeat(starts, np.diff(starts, append=len(keys)))
    return np.argsort(_hashed(keys + (places.astype(np.uint64) << np.uint64(52)), rng), kind="stable")


def _of_smallest(
    hashed: np.ndarray, points: Array, keys: np.ndarray, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Indices (count,) of the points (N, 3) with the smallest hashes (N,), in canonical order.

    Where many distances are the same, which a hash cannot tell apart, any in canonical order.
    """
    chosen = np.argpartition(hashed, count)[:count]
    if np.count_nonzero(hashed <= hashed[chosen].max()) > count:
        chosen = canonical_order(points, keys)[rng.choice(len(points), count, replace=False)]
    return chosen[canonical_order(points[chosen], keys[chosen])]
