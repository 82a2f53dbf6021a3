"""Annealed robust refinement of one start, and of the few that are worth it."""

import math
from dataclasses import dataclass

import numpy as np

from ..geometry.vectors import TINY, Array
from ..noise.exact import exact_points
from ..noise.scale import CORE, CORE_DEVIATION
from ..solver.refine import CODES
from ..trial.trial import Trial
from . import _search
from .starts import distinct_starts
from .view import View

SHRINK = 0.7
SLOW_SHRINK = 0.85
"""Factor between the kernel scales of one step and the next; the slow one finds smaller exact subsets."""

ENOUGH_EXACT = 0.3
"""If the best start finds an exact subset of this share, no other is annealed."""

LOST = 0.04
"""Annealing towards an exact subset ends when less than this share of the points is within its scale."""

LOCKED = 20.0
"""The scale drops at once to this many times the median distance within it, where most are that close."""

AT_NOISE = 1.5
"""The scale has come down to the noise when it is this many times the scale of their core."""


@dataclass(frozen=True, eq=False)
class Annealed:
    """Where annealing ended: a row (9,) locked on an exact subset, or one at the scale of the noise.

    `distance` (N,) is that of the points it was annealed on.
    """

    row: Array
    distance: Array
    exact_share: float


def search(starts: Array, view: View) -> Annealed:
    """The best end of annealing from the first of the starts (K, 9), and from others where they are asked."""
    best = anneal(view.trial, starts[0], view.points)
    if best.exact_share >= ENOUGH_EXACT:
        return best
    ends = (anneal(view.trial, row, view.points) for row in distinct_starts(starts[1:], view))
    return best_of([best, *ends])


def anneal(trial: Trial, row: Array, points: Array, shrink: float = SHRINK) -> Annealed:
    """Refine under a Geman-McClure kernel whose scale shrinks to the noise, and on to an exact subset.

    Source: graduated non-convexity, Black and Rangarajan, IJCV 19, 1996; Yang et al., IEEE RA-L 5, 2020.
    """
    tolerance, dof = trial.cloud.tolerance, trial.dof
    rows, distances = _search.anneal(
        CODES[trial.kind],
        row,
        points,
        tolerance=tolerance,
        shrink=shrink,
        locked=LOCKED,
        at_noise=AT_NOISE,
        need=max(2 * dof + 2, math.ceil(LOST * len(points))),
        core=CORE,
        deviation=CORE_DEVIATION,
        limits=trial.bounds,
    )
    exact = np.count_nonzero(exact_points(np.abs(distances[0]), tolerance, dof)) / len(points)
    end = 0 if exact else -1
    return Annealed(rows[end], distances[end], exact)


def best_of(ends: list[Annealed]) -> Annealed:
    """The end with the largest exact subset, or else with the least robust cost at the smallest median."""
    best = max(ends, key=lambda end: end.exact_share)
    if best.exact_share > 0.0 or len(ends) == 1:
        return best
    return ends[_search.cheapest(np.array([end.distance for end in ends]), TINY)]
