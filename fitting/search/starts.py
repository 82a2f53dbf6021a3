"""Where a search starts: initial guesses after some robust steps, the best first."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..cloud.cloud import GUESS_POINTS
from ..geometry.vectors import Array
from ..guesses.oriented import Oriented
from ..primitives.primitive import Primitive
from ..solver.refine import CODES
from ..trial.trial import Trial
from . import _search
from .view import View

RANKING: NDArray[np.int64] = np.array([[64, 4, 12], [GUESS_POINTS, 6, 12]])
"""Points, robust steps and how many starts are left of each stage before they are annealed: what is far off
after few steps on few points is so after more."""

ALL: NDArray[np.int64] = np.array([[GUESS_POINTS, 10, 1000]])
"""Few points have several minima, which starts of every rank lead to."""

SETTLING: NDArray[np.int64] = np.array([[GUESS_POINTS, 10, 12]])
STARTS = 5
"""Unless the best start finds a large exact subset, all that are left take so many more steps, and so many of
those that differ are annealed."""

WIDTHS = 2.0
"""Scale of the kernel that starts settle under, in medians of the absolute distance."""

RESOLVED = 1e-3
"""Distances, in the normalized frame, below which one start is not taken for better than another."""

SAME_END = 0.03
"""Starts whose distances differ by less than this, relatively, have come to the same end."""


def ranked_starts(view: View, rng: np.random.Generator, extra: Sequence[Array] = ()) -> Array:
    """Rows (K, 9) of the better ones of the initial guesses after some robust steps, the best first.

    Extra guesses (9,) are relative to the frame of the cloud, whatever the pivot of the limits.
    """
    trial, oriented, limits = view.trial, view.oriented, view.trial.limits
    kind = trial.primitive

    def ranked(other: str, rows: Array) -> Array:
        return race(Trial(other, trial.cloud), rows, oriented.points, RANKING)[0]

    guesses = np.vstack([kind.initial_guesses(oriented, rng), *extra])
    guesses = np.vstack([guesses, kind.later_guesses(oriented, rng, ranked)])
    if limits is not None:
        guesses = limits.guesses(guesses, oriented, rng)
    return race(trial, guesses, view.points[:GUESS_POINTS], ALL if trial.is_small else RANKING)[0]


def distinct_starts(starts: Array, view: View) -> list[Array]:
    """Of the starts (K, 9), after some more steps, the best few that have not come to the same end."""
    rows, distances = race(view.trial, starts, view.points[:GUESS_POINTS], SETTLING)
    return [rows[k] for k in _search.distinct(distances, SAME_END, STARTS)]


def distance_to(trial: Trial, surface: Primitive, rng: np.random.Generator) -> float:
    """How far the nearest surface of a kind is from another one where the cloud is: rms at some points' feet.

    A few robust steps of each start on these points without noise, with their true normals.
    """
    points = trial.cloud.oriented.points
    normals = surface.gradient(points)
    feet = points - surface.signed_distance(points)[:, None] * normals
    guesses = trial.primitive.initial_guesses(Oriented(feet, normals), rng)
    _, distances = race(trial.free, guesses, feet, RANKING)
    if not len(distances):
        return np.inf
    return float(np.sqrt(np.min(np.mean(distances**2, axis=1))))


def race(trial: Trial, rows: Array, points: Array, stages: NDArray[np.int64]) -> tuple[Array, Array]:
    """Those of the rows (K, 9) that are left after some stages, with their distances (L, N), the best first.

    A row of `stages` is (points, steps, kept): all that are left take so many robust steps, on so many points
    evenly spread over their order, and those with the least mean logarithm of the distance go on. For each
    step the scale of a Geman-McClure kernel is twice the median distance, but at least the rounding. Rows
    that cannot be stepped from stay as they are; the distances are on the points of the last stage.
    """
    return _search.race(
        CODES[trial.kind],
        np.ascontiguousarray(rows),
        np.ascontiguousarray(points),
        trial.cloud.tolerance,
        WIDTHS,
        RESOLVED,
        stages,
        trial.bounds,
    )


def compete(
    kind: str, starts: Array, points: Array, smallest: float, resolved: float, stages: NDArray[np.int64]
) -> tuple[Array, Array]:
    """The row (9,) that the best of the starts (K, 9) leads to after a race, and its distances (N,)."""
    rows, distances = _search.race(
        CODES[kind], np.ascontiguousarray(starts), points, smallest, WIDTHS, resolved, stages
    )
    return rows[0], distances[0]
