"""A cloud in pieces of about as many points each."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..geometry.vectors import Array
from . import _pieces

PATCHES = 64
"""Of a cloud, at most: each is an eighth of it long, in which a sensor's noise has hardly changed."""


GRAIN = 8
"""Points of the smallest pieces: within them a surface is as good as flat."""


@dataclass(frozen=True, eq=False)
class Halved:
    """Halves of halves of a cloud, down to grains: patches of patches of some points each.

    Halves are along the widest coordinate, again and again; of points given along the principal axes of the
    cloud, pieces turn with it. Of points that are as far along, the earlier ones are in the first half.

    Attributes
    ----------
    order : (N,) the points, piece by piece
    times : that the cloud was halved; `PATCHES` points or fewer are one piece
    """

    order: np.ndarray
    times: int

    @classmethod
    def of(cls, points: Array) -> Self:
        """Of points (N, 3)."""
        n = len(points)
        times = _halvings(_grains(n)) if n > PATCHES else 0
        return cls(_pieces.halves(np.ascontiguousarray(points, np.float64), times), times)

    def patches(self) -> np.ndarray:
        """Number of the patch of each of the points (N,), from 0; if they are fewer, each is one."""
        return self._numbered(PATCHES)

    def grains(self) -> np.ndarray:
        """Number of the grain of each of the points (N,), likewise."""
        return self._numbered(_grains(len(self.order)))

    def _numbered(self, most: int) -> np.ndarray:
        if len(self.order) <= most:
            return np.arange(len(self.order))
        return _pieces.numbered(self.order, _halvings(most))


def _grains(n_points: int) -> int:
    return max(PATCHES, n_points // GRAIN)


def _halvings(most: int) -> int:
    """That leave at most so many pieces."""
    return most.bit_length() - 1


def strips_of(values: Array, most: int = PATCHES) -> np.ndarray:
    """Number of the strip of each of the values (N,), as many of neighbors each."""
    count = min(len(values), most)
    number = np.empty(len(values), np.intp)
    number[np.argsort(values, kind="stable")] = np.arange(len(values)) * count // len(values)
    return number
