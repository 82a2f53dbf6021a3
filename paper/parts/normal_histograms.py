"""Histograms of oriented normal vectors, recentred.

A normal in spherical coordinates falls in one of 25 x 25 cells of zenith and azimuth. Source: Tang et al.,
"Histogram of oriented normal vectors for object recognition with a depth sensor", ACCV 2012, section 3.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.geometry.vectors import Array

CELLS = 25
PEAK = 0.8
"""Share of the fullest cell from which a cell is one that a histogram is recentred on."""


def histogram(normals: Array) -> Array:
    """Shares (CELLS, CELLS) of unit normals (N, 3) by zenith, the first index, and azimuth.

    Estimated normals have no sign, so each counts with its opposite, half.
    """
    both = np.vstack([normals, -normals])
    zenith = np.arccos(both[:, 2].clip(-1.0, 1.0)) / np.pi
    azimuth = np.arctan2(both[:, 1], both[:, 0]) / (2.0 * np.pi) + 0.5
    cells = [np.minimum((CELLS * part).astype(int), CELLS - 1) for part in (zenith, azimuth)]
    counts = np.bincount(CELLS * cells[0] + cells[1], minlength=CELLS**2)
    return counts.reshape(CELLS, CELLS) / max(len(both), 1)


def recentred(shares: NDArray[Any]) -> NDArray[Any]:
    """The histogram (CELLS, CELLS) once for each peak, (P, CELLS, CELLS), which then is in the middle."""
    peaks = np.argwhere((shares >= PEAK * shares.max()) & (shares > 0.0))
    return np.array([np.roll(shares, CELLS // 2 - peak, axis=(0, 1)) for peak in peaks]).reshape(
        -1, CELLS, CELLS
    )
