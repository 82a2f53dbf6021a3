"""Both histograms of a cloud, from the normals of some of its points, and how they are stored."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.cloud.normals import estimate_normals
from primfit.fitting.geometry.vectors import Array, principal
from primfit.fitting.guesses.oriented import Oriented

from .nearest import Rows
from .normal_histograms import CELLS, histogram, recentred
from .surflets import surflet_histogram

NORMALS = 800
"""Points of a cloud whose normals are counted ..."""
SURFLETS = 150
"""... and those of them all of whose pairs are."""
LEVELS = 255


@dataclass(frozen=True, eq=False)
class Local:
    """What M2 knows of a cloud: its oriented points, both histograms, and how flat it is.

    `flatness` is the smallest root mean square extent along a principal axis over the next one.
    """

    oriented: Oriented
    normals: NDArray[np.uint8]
    surflets: NDArray[np.uint8]
    flatness: float

    @classmethod
    def of(cls, points: Array) -> "Local":
        """Of a cloud (N, 3) near the origin with an extent near 1."""
        at = points[np.random.default_rng(0).permutation(len(points))[:NORMALS]]
        oriented = Oriented(at, estimate_normals(points, at=at))
        extents, _ = principal(points - points.mean(axis=0))
        return cls(
            oriented,
            levels(np.sqrt(histogram(oriented.normals))),
            levels(np.sqrt(surflet_histogram(at[:SURFLETS], oriented.normals[:SURFLETS]))),
            float(extents[2] / extents[1]) if extents[1] > 0.0 else 0.0,
        )


def levels(roots: Array) -> NDArray[np.uint8]:
    """Roots of shares, flat, in whole levels: so they are stored, for references and questions alike."""
    return np.rint(LEVELS * roots).astype(np.uint8).ravel()


def peaked(stored: NDArray[np.uint8]) -> Rows:
    """A histogram of normals (CELLS * CELLS,) recentred on each of its peaks, (P, CELLS * CELLS).

    Of the shares the roots are compared: their squared distance is that of Hellinger, twice.
    """
    shares = shares_of(stored).reshape(CELLS, CELLS)
    return np.sqrt(recentred(shares)).reshape(-1, CELLS**2).astype(np.float32)


def shares_of(stored: NDArray[np.uint8]) -> Rows:
    """Shares (..., D) of surflet pairs, which are compared as they are."""
    return np.square(stored / np.float32(LEVELS))
