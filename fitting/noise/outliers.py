"""Distances as a mixture of noise and outliers."""

from dataclasses import dataclass
from functools import cache
from typing import Self

import numpy as np

from ..geometry.vectors import Array
from . import _noise


@dataclass(frozen=True)
class NoiseModel:
    """Distances as a mixture: normal with mean 0 and `scale`, but an `outlier_share` uniform in the cloud.

    `log_likelihood` is that of all distances.
    """

    scale: float
    outlier_share: float
    log_likelihood: float

    @classmethod
    def of(cls, distance: Array, smallest: float, width: float) -> Self:
        """The most likely mixture of distances (N,) of which the k smallest are noise, for some k.

        `smallest` is the least scale, `width` the range over which outliers are uniform.
        Source: Celeux and Govaert, "A classification EM algorithm", Comput. Stat. Data Anal. 14, 1992, the
        criterion C2; outliers so modeled in Torr and Zisserman, "MLESAC", CVIU 78, 2000.
        """
        squared = np.sort(distance * distance)
        return cls(*_noise.mixture(squared, _logs(len(squared).bit_length()), smallest, width))


@cache
def _logs(bits: int) -> Array:
    """Logarithms of all numbers of so many bits."""
    return np.log(np.arange(1.0, 2.0**bits))
