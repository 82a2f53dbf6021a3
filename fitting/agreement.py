"""How the noise of points agrees over a surface: the mean of what explains it, each by its evidence.

The fields are those of the verdict (`fitting.fields`), of ranges below the size of the cloud: wider ones are
taken up by the parameters, and what is left of them does not tell how much they took.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fitting.fields import Explanations
from fitting.geometry import Array
from fitting.patches import PATCHES

WIDEST = 0.5
"""Range, over the extent, of the widest field that counts: wider ones are not told from the parameters, and
would make intervals under independent noise several times as long."""

FIELDS = 0.1
"""Probability, before anything is known, of a rough field, and of a smooth one; sizes and ranges alike. At
0.3 the intervals of planes were a third longer than need be under independent noise."""


@dataclass(frozen=True)
class Correlation:
    """Correlation  share * exp(-(h / length)^power)  of the noise of two points at distance h."""

    length: float
    share: float
    power: int


@dataclass(frozen=True, eq=False)
class Agreement:
    """Of the noise of points in patches.

    Attributes
    ----------
    patch : (M,) number of the patch of each point
    seen : (M,) mask of the points that the noise was seen on
    own : the part of the variance of a point that its neighbours do not share, over what is left over
    rough, smooth : by range, the variance of the fields of this range; lengths in the frame
    correlation : the likeliest, None where noise is likelier independent
    """

    patch: np.ndarray
    seen: np.ndarray
    own: float
    rough: dict[float, float]
    smooth: dict[float, float]
    correlation: Correlation | None

    @classmethod
    def of(
        cls, found: Explanations, patch: np.ndarray, seen: np.ndarray, extent: float, variance: float
    ) -> Self:
        """From explanations of residuals that have this variance."""
        weights = _weights(found)
        fields, none, apart = weights[1:-1], weights[0], weights[-1]
        white = found.white[1:] ** 2
        own = none + fields @ np.minimum(white / variance, 1.0) + apart * found.apart_white**2 / variance
        return cls(
            patch,
            seen,
            float(own),
            _by_range(fields * white * found.rough_size[1:] ** 2, extent * found.rough_range[1:]),
            _by_range(fields * white * found.smooth_size[1:] ** 2, extent * found.smooth_range[1:]),
            _correlation(found, weights, extent, len(patch), variance),
        )

    def meat(self, rows: Array, feet: Array) -> Array:
        """What pairs of the points add to the covariance of the sum of the rows (M, k)."""
        _, place = np.unique(self.patch[self.seen], return_inverse=True)
        total = _sums(place, rows[self.seen])
        middle = _sums(place, feet[self.seen]) / np.bincount(place)[:, None]
        apart = np.sqrt(np.sum((middle[:, None] - middle) ** 2, axis=2))
        covariance = np.zeros_like(apart)
        for span, variance in self.rough.items():
            covariance += variance * np.exp(-apart / span)
        for span, variance in self.smooth.items():
            covariance += variance * np.exp(-0.5 * (apart / span) ** 2)
        return np.asarray(total.T @ covariance @ total)


def _sums(place: np.ndarray, rows: Array) -> Array:
    """Of the rows (M, k) at the same place."""
    sums = np.zeros((int(place.max()) + 1, rows.shape[1]))
    for sum_, column in zip(sums.T, rows.T, strict=True):
        sum_[:] = np.bincount(place, column)
    return sums


def _weights(found: Explanations) -> Array:
    """(T + 1,) probability of each explanation, the last that patches have a noise of their own.

    That counts as the rough field of the shortest range.
    """
    rough, smooth = found.rough_range > 0.0, found.smooth_range > 0.0
    held = (found.rough_range <= WIDEST) & (found.smooth_range <= WIDEST)
    alone = [held & rough & ~smooth, held & smooth & ~rough]
    each = [np.log(FIELDS / max(int(np.count_nonzero(some)), 1)) for some in alone]
    prior = np.where(rough, each[0], np.log(1.0 - FIELDS)) + np.where(smooth, each[1], np.log(1.0 - FIELDS))
    logs = np.append(
        np.where(held, found.log_evidence + prior, -np.inf),
        found.apart + np.log(FIELDS) + np.log(1.0 - FIELDS),
    )
    weights = np.exp(logs - logs.max())
    return np.asarray(weights / weights.sum())


def _by_range(variance: Array, ranges: Array) -> dict[float, float]:
    return {
        float(span): float(variance[ranges == span].sum())
        for span in np.unique(ranges[(ranges > 0.0) & (variance > 0.0)])
    }


def _correlation(
    found: Explanations, weights: Array, extent: float, n: int, variance: float
) -> Correlation | None:
    """Of the larger field of the likeliest explanation.

    One within patches, whose sides are an eighth of the extent, is as long as it takes for a point to agree
    with as many others of its patch as the variance of the means says: the area under exp(-(h / L)^2) is
    pi L^2.
    """
    excess = found.apart_white**2 / variance - 1.0
    fields = float(weights[1:-1].sum())
    if fields + (weights[-1] if excess > 0.0 else 0.0) <= 0.5:
        return None
    best = 1 + int(np.argmax(weights[1:-1]))
    if weights[-1] > weights[best]:
        others = min(excess * PATCHES / n, 1.0)
        return Correlation(float(extent * np.sqrt(others / (np.pi * PATCHES))), 1.0, 2)
    rough, smooth = found.rough_size[best] ** 2, found.smooth_size[best] ** 2
    share = float(max(rough, smooth) / (1.0 + rough + smooth))
    if rough >= smooth:
        return Correlation(extent * float(found.rough_range[best]), share, 1)
    return Correlation(extent * float(np.sqrt(2.0) * found.smooth_range[best]), share, 2)
