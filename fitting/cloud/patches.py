"""A cloud in pieces of about as many points each."""

import numpy as np

from ..geometry.vectors import Array
from . import _halves

PATCHES = 64
"""Of a cloud, at most: each is an eighth of it long, in which a sensor's noise has hardly changed."""


GRAIN = 8
"""Points of the smallest pieces: within them a surface is as good as flat."""


def grains_of(points: Array) -> np.ndarray:
    """Number of the grain of each of the points (N, 3): patches of patches, down to some points each."""
    return patches_of(points, max(PATCHES, len(points) // GRAIN))


def patches_of(points: Array, most: int = PATCHES) -> np.ndarray:
    """Number of the patch of each of the points (N, 3), from 0, of at most so many.

    Halves along the widest coordinate, again and again; given along the principal axes of the cloud, patches
    turn with it. Of points that are as far along, the earlier ones are in the first half. Points fewer than
    that are patches each.
    """
    if len(points) <= most:
        return np.arange(len(points))
    return _halves.halves(np.ascontiguousarray(points), most.bit_length() - 1)


def strips_of(values: Array, most: int = PATCHES) -> np.ndarray:
    """Number of the strip of each of the values (N,), as many of neighbours each."""
    count = min(len(values), most)
    number = np.empty(len(values), np.intp)
    number[np.argsort(values, kind="stable")] = np.arange(len(values)) * count // len(values)
    return number
