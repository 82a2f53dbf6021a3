"""How the noise of points agrees over a surface: under each of what explains it, with its probability.

The fields are those of the verdict (`fitting.fields.fields`). A smooth field as wide as the cloud is a
deviation of the part, and the surface asked for is the one that it deviates from by 0 in the mean over the
points; the mean of others is noise. A rough field as wide as the cloud does not count: one of a third of its
range and of its variance differs as much from patch to patch, and its shorter intervals do.
"""

from dataclasses import dataclass
from functools import cached_property
from math import log
from typing import Self

import numpy as np

from ..cloud.patches import PATCHES
from ..fields.fields import EPS, Explanations
from ..geometry.vectors import Array
from . import _covariance

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
    own : (T,) the part of the variance of a point that its neighbors do not share, over what is left over
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
        likely = weight > EPS**2  # what is less likely shows nowhere
        own = np.ones(len(weight))
        own[1:-1], own[-1] = np.minimum(white[1:] / variance, 1.0), found.apart_white**2 / variance
        sizes = white * found.rough_size**2, white * found.smooth_size**2
        fields = sizes[0], found.rough_range, sizes[1], found.smooth_range
        table = np.zeros((len(fields), len(weight)))  # the last explanation has none
        table[:, :-1] = fields
        correlation = _correlation(found, weight, extent, len(patch), variance)
        rough, rough_range, smooth, smooth_range = table[:, likely]
        return cls(
            patch,
            seen,
            extent,
            weight[likely],
            own[likely],
            rough,
            rough_range,
            smooth,
            smooth_range,
            correlation,
        )

    def fields(self, rows: Array, gain: Array, feet: Array) -> Array:
        """Covariances (R - 1, k, k) of the sum of  gain r  under the fields, each of variance 1.

        Rows r (k, M) and gains (M,) are those of the points, whose feet (3, M) are on the surface.
        """
        return _covariance.fields(
            rows, gain, feet, self.patch, self.seen.view(np.uint8), self.extent, *map(np.array, self._spans)
        )

    @cached_property
    def shares(self) -> Array:
        """(T, R) parts of each explanation: of independent noise, and the variances of the fields."""
        rough, smooth = self._spans
        columns = [self.own]
        columns += [np.where(self.rough_range == span, self.rough, 0.0) for span in rough]
        columns += [np.where(self.smooth_range == span, self.smooth, 0.0) for span in smooth]
        return np.stack(columns, axis=1)

    @cached_property
    def _spans(self) -> tuple[list[float], list[float]]:
        """The ranges of rough fields, and of smooth ones."""
        rough, smooth = (sorted(set(each.tolist()) - {0.0}) for each in (self.rough_range, self.smooth_range))
        return rough, smooth


def _weights(found: Explanations) -> Array:
    """(T + 1,) probability of each explanation, the last that patches have a noise of their own.

    That counts as the rough field of the shortest range.
    """
    rough, smooth = found.rough_range > 0.0, found.smooth_range > 0.0
    held = found.rough_range < 1.0
    each = [log(FIELDS / np.count_nonzero(held & some)) for some in (rough & ~smooth, smooth & ~rough)]
    prior = np.where(rough, each[0], log(1.0 - FIELDS)) + np.where(smooth, each[1], log(1.0 - FIELDS))
    logs = np.empty(len(held) + 1)
    logs[:-1] = np.where(held, found.log_evidence + prior, -np.inf)
    logs[-1] = found.apart + log(FIELDS) + log(1.0 - FIELDS)
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
    fields, patches = float(weights[1:-1].sum()), float(weights[-1]) if excess > 0.0 else 0.0
    if fields + patches <= 0.5:
        return None
    best = 1 + int(np.argmax(weights[1:-1]))
    if patches > weights[best]:
        others = min(excess * PATCHES / n, 1.0)
        return Correlation(float(extent * np.sqrt(others / (np.pi * PATCHES))), 1.0, 2)
    rough, smooth = found.rough_size[best] ** 2, found.smooth_size[best] ** 2
    share = float(max(rough, smooth) / (1.0 + rough + smooth))
    if rough >= smooth:
        return Correlation(extent * float(found.rough_range[best]), share, 1)
    return Correlation(extent * float(np.sqrt(2.0) * found.smooth_range[best]), share, 2)
