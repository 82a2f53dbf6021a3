"""Annealed robust refinement of one start, and of the few that are worth it."""

from dataclasses import dataclass

import numpy as np

from ..geometry.vectors import TINY, Array
from ..noise.exact import exact_points
from ..noise.kernels import Kernel
from ..noise.scale import CORE, CORE_DEVIATION
from ..primitives.primitive import Primitive
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


@dataclass(frozen=True)
class Annealed:
    """Where annealing ended: a primitive locked on an exact subset, or one at the scale of the noise."""

    primitive: Primitive
    exact_share: float


def search(starts: Array, view: View) -> Annealed:
    """The best end of annealing from the first of the starts (K, 9), and from others where they are asked."""
    best = anneal(view.trial, starts[0], view.points)
    if best.exact_share >= ENOUGH_EXACT:
        return best
    ends = (anneal(view.trial, row, view.points) for row in distinct_starts(starts[1:], view))
    return best_of([best, *ends], view.points)


def anneal(trial: Trial, row: Array, points: Array, shrink: float = SHRINK) -> Annealed:
    """Refine under a Geman-McClure kernel whose scale shrinks to the noise, and on to an exact subset.

    Source: graduated non-convexity, Black and Rangarajan, IJCV 19, 1996; Yang et al., IEEE RA-L 5, 2020.
    """
    tolerance, dof = trial.cloud.tolerance, trial.dof
    row, at_noise = _search.anneal(
        CODES[trial.kind],
        row,
        points,
        tolerance=tolerance,
        shrink=shrink,
        locked=LOCKED,
        at_noise=AT_NOISE,
        need=max(2 * dof + 2, int(np.ceil(LOST * len(points)))),
        core=CORE,
        deviation=CORE_DEVIATION,
        limits=trial.bounds,
    )
    primitive = trial.primitive.from_row(row)
    exact = exact_points(np.abs(primitive.signed_distance(points)), tolerance, dof)
    if exact.any():
        return Annealed(primitive, float(exact.mean()))
    return Annealed(primitive if at_noise is None else trial.primitive.from_row(at_noise), 0.0)


def best_of(ends: list[Annealed], points: Array) -> Annealed:
    """The end with the largest exact subset, or else with the least robust cost at the smallest median."""
    best = max(ends, key=lambda end: end.exact_share)
    if best.exact_share > 0.0:
        return best
    squared = [end.primitive.signed_distance(points) ** 2 for end in ends]
    scale2 = max(min(float(np.median(each)) for each in squared), TINY)
    return ends[int(np.argmin([Kernel.TUKEY.rho(each / scale2).sum() for each in squared]))]
