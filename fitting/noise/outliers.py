"""Distances as a mixture of noise and outliers."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..geometry.vectors import Array


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
        criterion C2; outliers so modelled in Torr and Zisserman, "MLESAC", CVIU 78, 2000.
        """
        from scipy.special import xlogy

        squared = np.sort(distance**2)
        sums, many = np.cumsum(squared), len(squared)
        noise = np.arange(1, many + 1)
        scales, outliers = np.maximum(np.sqrt(sums / noise), smallest), many - noise
        normal = xlogy(noise, noise / (many * scales * np.sqrt(2.0 * np.pi))) - 0.5 * sums / scales**2
        best = int(np.argmax(normal + xlogy(outliers, outliers / (many * width))))
        scale, share = float(scales[best]), float(outliers[best]) / many
        density = np.exp(-0.5 * squared / scale**2) / (scale * np.sqrt(2.0 * np.pi))
        return cls(scale, share, float(np.log((1.0 - share) * density + share / width).sum()))
