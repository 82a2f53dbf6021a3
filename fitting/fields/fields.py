"""Residuals of a surface as white noise and random fields on it: how likely, and how large is each part?

Noise of sensors is shared by neighbors, and over the whole cloud it is as large as what differs between
neighboring kinds; parts bow and bulge by as much. So residuals count as

    r = J s + e + f + g

with steps s of the parameters, white noise e, a rough field f of correlation exp(-d / l), and a smooth one g
of exp(-d^2 / 2 l^2), where d is the distance between feet on the surface. Points are taken together in
patches (their means, and what they scatter about those), so that all of them count where the fields are
small, and no more than some dozen where they are not.
Source: Rasmussen and Williams, "Gaussian processes for machine learning", 2006, chapters 2 and 5; Occam's
factor: MacKay, "Information theory, inference, and learning algorithms", 2003, chapter 28; exponential
variograms: Cressie, "Statistics for spatial data", 1993, section 2.3.
"""

import math
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Self

import numpy as np

from ..geometry.vectors import Array
from . import _fields

RATIO = float(np.sqrt(10.0))
"""Sizes and ranges of the fields are looked at so many times as large as each other: half a decade."""

ROUGH = (1 / RATIO, 1.0, RATIO)
"""Standard deviations of the rough field, over that of the white noise: from what is hardly seen in a patch
to nearly all of the noise."""

ROUGH_RANGES = (1 / RATIO**2, 1 / RATIO, 1.0)
"""Its ranges, over the extent: from a patch to the whole cloud."""

SMOOTH = (1.0, RATIO, RATIO**2, RATIO * RATIO**2)
"""Standard deviations of the smooth field, over that of the white noise: from one that patches just show to
that of a wrong kind under little noise."""

SMOOTH_RANGES = (0.5 / RATIO, 1.0)
"""Its ranges, over the extent: of waves, which patches just show, and of a bow of all of it."""

EPS = float(np.finfo(np.float64).eps)
"""Directions that move the surface by less than this, over the one that moves it most, are not seen."""

PRIOR = 0.5
"""Extents by which a parameter may move the surface: to either side as far as the cloud goes."""


@dataclass(frozen=True, eq=False)
class Patched:
    """Residuals of a surface, patch by patch.

    Attributes
    ----------
    mean : (P,) of the residuals of each patch
    jacobian : (P, dof) of their derivatives
    count : (P,) how many points it has
    apart : (P, P) distances between the patches, over the extent
    scatter : standard deviation of the residuals within the smaller pieces, 0 where none has two points
    spare : how many such deviations are free, at most P: in a patch points tell the same
    hidden : standard deviation within patches beyond that
    """

    mean: Array
    jacobian: Array
    count: Array
    apart: Array
    scatter: float
    spare: float
    hidden: float

    @classmethod
    def of(
        cls,
        patch: np.ndarray,
        grain: np.ndarray,
        residual: Array,
        jacobian: Array,
        place: Array,
        turn: float = 0.0,
    ) -> Self:
        """Of points with the numbers (N,) of their patches and of smaller pieces.

        They are at `place` (N, k), over the extent. With a `turn`, places that differ by it are the same.
        """
        return cls(*_fields.patched(patch, grain, residual, jacobian, place, turn))


@dataclass(frozen=True, eq=False)
class Explanations:
    """Ways to explain residuals: a size and range of either field each.

    Attributes
    ----------
    log_evidence : (T,) of the residuals under each
    white : (T,) standard deviation of the white noise of a point
    rough, rough_range : (T,) of the rough field, as it shows beside what steps of the parameters take of it;
        the range over the extent
    smooth, smooth_range : (T,) the same of the smooth one
    rough_size, smooth_size : (T,) standard deviations of the fields themselves, over the white noise
    apart : logarithm of the evidence if the means of patches have a white noise of their own, -inf where no
        patch has two points
    apart_white : standard deviation of a point that this noise amounts to
    hidden : deviation within patches, which the fields do not see
    spread : (dof,) standard deviations of the parameters under the likeliest
    unexplained : logarithm of how much likelier the residuals would be if they were white noise as points
        have it within patches, None where no patch has two points
    """

    log_evidence: Array
    white: Array
    rough: Array
    rough_range: Array
    smooth: Array
    smooth_range: Array
    rough_size: Array
    smooth_size: Array
    apart: float
    apart_white: float
    hidden: float
    spread: Array
    unexplained: float | None

    @property
    def likeliest(self) -> int:
        return int(np.argmax(self.log_evidence))

    def among(self, chosen: np.ndarray) -> float:
        """Evidence of the chosen (T,) ones together, each as likely beforehand; none has none."""
        return log_mean(self.log_evidence[chosen])


def log_mean(logarithms: Array) -> float:
    """Logarithm of the mean of what these are logarithms of."""
    if not len(logarithms):
        return -np.inf
    return float(np.logaddexp.reduce(logarithms)) - math.log(len(logarithms))


def explanations(patched: Patched, extent: float, least: float) -> Explanations:
    """Of residuals with fewer parameters than patches; `least` is the smallest noise of a point.

    For each pair of fields the white noise is the most likely one, the parameters take one step of
    generalized least squares, and Occam's factor is that of a normal prior by which each of them, turned so
    that it moves the surface by itself, may move it by `PRIOR` extents in the mean square. Two fields are
    looked at together where each alone explains more than white noise; else they explain nothing.
    """
    prior = (PRIOR * extent) ** 2
    columns, apart, apart_white, spread = _fields.explained(
        _grid(),
        patched.mean,
        patched.jacobian,
        patched.count,
        patched.apart,
        patched.scatter,
        patched.spare,
        prior,
        least,
    )
    unexplained = _unexplained(patched, log_mean(columns[0]), prior)
    return Explanations(*columns, apart, apart_white, patched.hidden, spread, unexplained)


@cache
def _grid() -> _fields.Grid:
    """Fields by themselves, none of them first, then the pairs of a rough and a smooth one."""
    rough = [((size, 0.0), (bell, 0)) for bell in range(len(ROUGH_RANGES)) for size in ROUGH]
    bells = range(len(ROUGH_RANGES), len(ROUGH_RANGES) + len(SMOOTH_RANGES))
    smooth = [((0.0, size), (0, bell)) for bell in bells for size in SMOOTH]
    alone = [((0.0, 0.0), (0, 0)), *rough, *smooth]
    pairs = list(product(range(1, 1 + len(rough)), range(1 + len(rough), len(alone))))
    both = [((alone[i][0][0], alone[j][0][1]), (alone[i][1][0], alone[j][1][1])) for i, j in pairs]
    sizes, which = zip(*alone, *both, strict=True)
    return _fields.Grid(ROUGH_RANGES + SMOOTH_RANGES, len(ROUGH_RANGES), sizes, which, pairs)


def _unexplained(patched: Patched, found: float, prior: float) -> float | None:
    """What white noise of the points' own scatter would gain on the evidence that was found."""
    if patched.scatter == 0.0:
        return None
    dof, variance, free = patched.jacobian.shape[1], patched.scatter**2, len(patched.mean) + patched.spare
    points, logs = float(patched.count.sum()), float(np.log(patched.count).sum())
    occam = dof * math.log1p(prior * points / variance)
    return -0.5 * (free * math.log(2.0 * math.pi * variance) + free - dof + occam - logs) - found
