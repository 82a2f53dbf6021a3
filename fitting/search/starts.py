"""Where a search starts: initial guesses after some robust steps, the best first."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..cloud.cloud import Cloud
from ..geometry.vectors import Array
from ..primitives import PRIMITIVES, Primitive
from ..primitives.cylinder import Cylinder
from ..primitives.torus import Torus
from ..solver.limits import Limits
from ..solver.refine import CODES
from . import _search
from .view import View

GUESS_POINTS = 160
"""Points that starts are derived from and ranked on."""

RANKING_STEPS = 10
"""Robust steps that every start takes before the starts are compared."""

BENT_CYLINDERS = 3
"""So many cylinders are bent for starts of tori."""

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


def ranked_starts(kind: str, view: View, rng: np.random.Generator, extra: Sequence[Array] = ()) -> Array:
    """Rows (K, 9) of initial guesses after some robust steps, the best first.

    Extra guesses (9,) are relative to the frame of the cloud, whatever the pivot of the limits.
    """
    points, normals, limits = view.points[:GUESS_POINTS], view.normals[:GUESS_POINTS], view.limits
    there = points if limits is None else points + limits.pivot
    guesses = np.vstack([PRIMITIVES[kind].initial_guesses(there, normals, rng), *extra])
    if kind == "torus":
        guesses = np.vstack([guesses, _bent_cylinders(there, normals, view.tolerance, rng)])
    if limits is not None:
        guesses = limits.guesses(guesses, there, normals, rng)
    return _settled(kind, guesses, points, view.tolerance, RANKING_STEPS, limits)[0]


def _bent_cylinders(points: Array, normals: Array, tolerance: float, rng: np.random.Generator) -> Array:
    """Rows (K, 9) of the tori that the better ones of the cylinders bend into: they need no good normals."""
    guesses = Cylinder.initial_guesses(points, normals, rng)
    cylinders, _ = _settled("cylinder", guesses, points, tolerance, RANKING_STEPS, None)
    return Torus.rows_bent(cylinders[:BENT_CYLINDERS], points)


def distinct_starts(kind: str, starts: Array, view: View) -> list[Array]:
    """Of the better starts, after some more steps, the best few that have not come to the same end."""
    points = view.points[:GUESS_POINTS]
    chosen: list[Array] = []
    ends: list[Array] = []
    rows, distances = _settled(
        kind, starts[:SETTLED_STARTS], points, view.tolerance, SETTLING_STEPS, view.limits
    )
    for row, distance in zip(rows, np.abs(distances), strict=True):
        if all(np.linalg.norm(distance - other) > SAME_END * np.linalg.norm(other) for other in ends):
            chosen.append(row)
            ends.append(distance)
        if len(chosen) == STARTS:
            break
    return chosen


def _settled(
    kind: str, rows: Array, points: Array, tolerance: float, steps: int, limits: Limits | None
) -> tuple[Array, Array]:
    """The rows after some steps of `settle`, with their distances, the best first; all of them finite."""
    if not len(rows):
        return rows, np.empty((0, len(points)))
    rows, distances = settle(kind, rows, points, tolerance, steps, limits)
    costs = np.log(np.abs(distances) + RESOLVED).mean(axis=1)
    order = np.argsort(costs, kind="stable")
    order = order[np.isfinite(costs[order])]
    return rows[order], distances[order]


def distance_to(kind: str, surface: Primitive, cloud: Cloud, rng: np.random.Generator) -> float:
    """How far the nearest surface of a kind is from another one where the cloud is: rms at some points' feet.

    A few robust steps of each start on these points without noise, with their true normals.
    """
    points = cloud.working[cloud.sample[:GUESS_POINTS]]
    feet = points - surface.signed_distance(points)[:, None] * surface.gradient(points)
    guesses = PRIMITIVES[kind].initial_guesses(feet, surface.gradient(feet), rng)
    _, distances = _settled(kind, guesses, feet, cloud.tolerance, RANKING_STEPS, None)
    if not len(distances):
        return np.inf
    return float(np.sqrt(np.min(np.mean(distances**2, axis=1))))


def settle(
    kind: str, starts: Array, points: Array, smallest: float, steps: int, limits: Limits | None = None
) -> tuple[Array, Array]:
    """Rows (K, 9) after some robust steps each from the starts (K, 9), and their distances (K, N).

    For each step the scale of a Geman-McClure kernel is twice the median distance, but at least `smallest`.
    Rows that cannot be stepped from stay as they are.
    """
    return _search.settle(
        CODES[kind], starts, points, smallest, WIDTHS, steps, None if limits is None else limits.bounds
    )


def compete(
    kind: str, starts: Array, points: Array, smallest: float, resolved: float, stages: NDArray[np.int64]
) -> tuple[Array, Array]:
    """The row (9,) that the best of the starts (K, 9) leads to, and its distances (N,).

    A row of `stages` is (points, steps, kept): all that are left take so many robust steps, as in `settle`,
    on so many points evenly spread over their order, and those with the least mean logarithm of the distance
    plus `resolved` go on.
    """
    return _search.compete(CODES[kind], starts, points, smallest, WIDTHS, resolved, stages)
