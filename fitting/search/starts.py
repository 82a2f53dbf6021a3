"""Where a search starts: initial guesses after some robust steps, the best first."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array
from ..primitives.primitive import Primitive
from ..solver.refine import CODES
from ..trial.trial import Trial
from . import _search
from .view import View

GUESS_POINTS = 160
"""Points that starts are derived from and ranked on."""

RANKING_STEPS = 10
"""Robust steps that every start takes before the starts are compared."""

WIDTHS = 2.0
"""Scale of the kernel that starts settle under, in medians of the absolute distance."""

SETTLED_STARTS = 24
SETTLING_STEPS = 20
STARTS = 5
"""Unless the best start finds a large exact subset, so many others take so many more steps, and so many of
those are annealed."""

RESOLVED = 1e-3
"""Distances, in the normalised frame, below which one start is not taken for better than another."""

SAME_END = 0.03
"""Starts whose distances differ by less than this, relatively, have come to the same end."""


def ranked_starts(view: View, rng: np.random.Generator, extra: Sequence[Array] = ()) -> Array:
    """Rows (K, 9) of initial guesses after some robust steps, the best first.

    Extra guesses (9,) are relative to the frame of the cloud, whatever the pivot of the limits.
    """
    trial, points, normals = view.trial, view.points[:GUESS_POINTS], view.normals[:GUESS_POINTS]
    kind, limits = trial.primitive, trial.limits
    there = points if limits is None else points + limits.pivot

    def ranked(other: str, rows: Array) -> Array:
        return settled(Trial(other, trial.cloud), rows, there, RANKING_STEPS)[0]

    guesses = np.vstack([kind.initial_guesses(there, normals, rng), *extra])
    guesses = np.vstack([guesses, kind.later_guesses(there, normals, rng, ranked)])
    if limits is not None:
        guesses = limits.guesses(guesses, there, normals, rng)
    return settled(trial, guesses, points, RANKING_STEPS)[0]


def distinct_starts(starts: Array, view: View) -> list[Array]:
    """Of the better starts, after some more steps, the best few that have not come to the same end."""
    chosen: list[Array] = []
    ends: list[Array] = []
    rows, distances = settled(view.trial, starts[:SETTLED_STARTS], view.points[:GUESS_POINTS], SETTLING_STEPS)
    for row, distance in zip(rows, np.abs(distances), strict=True):
        if all(np.linalg.norm(distance - other) > SAME_END * np.linalg.norm(other) for other in ends):
            chosen.append(row)
            ends.append(distance)
        if len(chosen) == STARTS:
            break
    return chosen


def distance_to(trial: Trial, surface: Primitive, rng: np.random.Generator) -> float:
    """How far the nearest surface of a kind is from another one where the cloud is: rms at some points' feet.

    A few robust steps of each start on these points without noise, with their true normals.
    """
    points = trial.cloud.working[trial.cloud.sample[:GUESS_POINTS]]
    feet = points - surface.signed_distance(points)[:, None] * surface.gradient(points)
    guesses = trial.primitive.initial_guesses(feet, surface.gradient(feet), rng)
    _, distances = settled(trial.free, guesses, feet, RANKING_STEPS)
    if not len(distances):
        return np.inf
    return float(np.sqrt(np.min(np.mean(distances**2, axis=1))))


def settled(trial: Trial, rows: Array, points: Array, steps: int) -> tuple[Array, Array]:
    """Rows (K, 9) after some robust steps, with their distances (K, N), the best first; all of them finite.

    For each step the scale of a Geman-McClure kernel is twice the median distance, but at least the rounding.
    Rows that cannot be stepped from stay as they are.
    """
    if not len(rows):
        return rows, np.empty((0, len(points)))
    rows, distances = _search.settle(
        CODES[trial.kind], rows, points, trial.cloud.tolerance, WIDTHS, steps, trial.bounds
    )
    costs = np.log(np.abs(distances) + RESOLVED).mean(axis=1)
    order = np.argsort(costs, kind="stable")
    order = order[np.isfinite(costs[order])]
    return rows[order], distances[order]


def compete(
    kind: str, starts: Array, points: Array, smallest: float, resolved: float, stages: NDArray[np.int64]
) -> tuple[Array, Array]:
    """The row (9,) that the best of the starts (K, 9) leads to, and its distances (N,).

    A row of `stages` is (points, steps, kept): all that are left take so many robust steps, as starts do,
    on so many points evenly spread over their order, and those with the least mean logarithm of the distance
    plus `resolved` go on.
    """
    return _search.compete(CODES[kind], starts, points, smallest, WIDTHS, resolved, stages)
