"""How the noise of points agrees over a surface: under each of what explains it, with its probability.

The fields are those of the verdict (`fitting.fields.fields`). A smooth field as wide as the cloud is a
deviation of the part, and the surface asked for is the one that it deviates from by 0 in the mean over the
points; the mean of others is noise. A rough field as wide as the cloud does not count: one of a third of its
range and of its variance differs as much from patch to patch, and its shorter intervals do.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..cloud.patches import PATCHES
from ..fields.fields import Explanations
from ..geometry.vectors import Array

FIELDS = 0.2
"""Probability, before anything is known, of a rough field, and of a smooth one; sizes and ranges alike. Less
makes intervals on bowed parts, which are too short, shorter; at 0.3 those of spheres under independent noise
are a quarter longer than need be."""


@dataclass(frozen=True)
class Correlation:
    """Correlation  share * exp(-(h / length)^power)  of the noise of two points at distance h."""

    length: float
    share: float
    power: int


@dataclass(frozen=True, eq=False)
class Agreement:
    """Of the noise of points in patches, under each of T explanations.

    Attributes
    ----------
    patch : (M,) number of the patch of each point
    seen : (M,) mask of the points that the noise was seen on
    extent : of the cloud
    weight : (T,) probability of each
    own : (T,) the part of the variance of a point that its neighbours do not share, over what is left over
    rough, smooth : (T,) variances of the fields
    rough_range, smooth_range : (T,) their ranges over the extent, 0 where there is no field
    correlation : the likeliest, None where noise is likelier independent
    """

    patch: np.ndarray
    seen: np.ndarray
    extent: float
    weight: Array
    own: Array
    rough: Array
    rough_range: Array
    smooth: Array
    smooth_range: Array
    correlation: Correlation | None

    @classmethod
    def of(
        cls, found: Explanations, patch: np.ndarray, seen: np.ndarray, extent: float, variance: float
    ) -> Self:
        """From explanations of residuals that have this variance."""
        weight, white = _weights(found), found.white**2
        likely = weight > 0.0
        own = np.append(np.minimum(white / variance, 1.0), found.apart_white**2 / variance)
        own[0] = 1.0

        def column(values: Array) -> Array:
            """Of explanations that may be, the last of which has no fields."""
            return np.append(values, 0.0)[likely]

        return cls(
            patch,
            seen,
            extent,
            weight[likely],
            own[likely],
            column(white * found.rough_size**2),
            column(found.rough_range),
            column(white * found.smooth_size**2),
            column(found.smooth_range),
            _correlation(found, weight, extent, len(patch), variance),
        )

    def meats(self, independent: Array, rows: Array, feet: Array) -> Array:
        """Covariances (T, k, k) of the sum of the rows (M, k), from the one under independent noise."""
        _, place, count = np.unique(self.patch[self.seen], return_inverse=True, return_counts=True)
        total = _sums(place, rows[self.seen])
        middle = _sums(place, feet[self.seen]) / count[:, None]
        apart = np.sqrt(np.sum((middle[:, None] - middle) ** 2, axis=2)) / self.extent
        meats = self.own[:, None, None] * independent
        for span, variance in _by_range(self.rough_range, self.rough):
            meats += variance * (total.T @ np.exp(-apart / span) @ total)
        middled = total - np.outer(count / count.sum(), total.sum(axis=0))
        for span, variance in _by_range(self.smooth_range, self.smooth):
            some = middled if span >= 1.0 else total  # a part deviates by 0 in the mean
            meats += variance * (some.T @ np.exp(-0.5 * (apart / span) ** 2) @ some)
        return np.asarray(meats)


def _by_range(ranges: Array, variance: Array) -> list[tuple[float, Array]]:
    """Each range among (T,) of them, and the variances (T, 1, 1) of the fields that have it."""
    spans = np.unique(ranges[ranges > 0.0])
    return [(float(span), np.where(ranges == span, variance, 0.0)[:, None, None]) for span in spans]


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
    held = found.rough_range < 1.0
    each = [np.log(FIELDS / np.count_nonzero(held & some)) for some in (rough & ~smooth, smooth & ~rough)]
    prior = np.where(rough, each[0], np.log(1.0 - FIELDS)) + np.where(smooth, each[1], np.log(1.0 - FIELDS))
    logs = np.append(
        np.where(held, found.log_evidence + prior, -np.inf),
        found.apart + np.log(FIELDS) + np.log(1.0 - FIELDS),
    )
    weights = np.exp(logs - logs.max())
    return np.asarray(weights / weights.sum())


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
