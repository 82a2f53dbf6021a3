"""What the parameters minimize: one finisher a criterion, from where the search ended."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..cloud.cloud import SAMPLE_POINTS, Cloud
from ..errors import FailedFit
from ..geometry.vectors import Array
from ..guesses.oriented import Oriented
from ..noise.kernels import CUTOFF, HUBER_95, TUKEY_95, Kernel
from ..primitives.primitive import Primitive
from ..solver.newton import newton
from ..solver.refine import Refined, refine
from ..trial.trial import Trial
from ..zones.extreme import maximum_inscribed, minimum_circumscribed, minimum_zone
from .finished import Finished

COMPARED_POINTS = 160
"""Points that least squares from all starts is compared on."""

BEST_ENDS = 4
"""Of their ends so many different ones, the cheapest, go on with all points."""

TURNS = 4
"""Small clouds are looked at in so many more ways for starts."""

SAME_END = 1e-3
"""Ends whose distances differ by less than this, relatively, are the same."""

LEAST_SQUARES_STEPS, POINT_STEPS = 500, 40_000
"""Steps after which plain least squares is given up; few points, whose valleys are narrow, may take
as many as look at so many points in all."""

MOST_ROUNDS = 100
"""Rounds of estimating a scale and refining at it after which an M-estimate is given up."""

AT_REST = 1e-9
"""The scale is at rest when it changes by less than this, relatively."""

FEW_POINTS = 60
"""So few points leave several minima of extreme distances: more starts are tried."""

Finisher = Callable[[Finished, Array, Trial], Finished | FailedFit]
"""From the robust fit and the rows (K, 9) of all starts of a trial to where the criterion ends.

Weights and limits are those of the refinement; the metrology criteria have neither."""


def robust(fitted: Finished, starts: Array, trial: Trial) -> Finished:
    """The robust fit as it is."""
    return fitted


def least_squares(fitted: Finished, starts: Array, trial: Trial) -> Finished | FailedFit:
    """Least squares over all points, which the robust fit to few points is already."""
    return fitted if trial.is_small else cheapest_minimum(fitted.primitive, starts, trial)


def cheapest_minimum(fitted: Primitive, starts: Array, trial: Trial) -> Finished | FailedFit:
    """The cheapest of the minima of least squares that a fit and the starts lead to.

    A failure where none is reached.
    """
    cloud, bounds = trial.cloud, trial.bounds
    some = cloud.working[cloud.sample[:COMPARED_POINTS]]
    surfaces = [fitted, *(trial.primitive.from_row(row) for row in starts)]
    if trial.is_small:
        surfaces += _turned_starts(trial)
    ends = _different([refine(surface, some, bounds=bounds) for surface in surfaces], some)
    steps = max(LEAST_SQUARES_STEPS, POINT_STEPS // len(cloud.points))
    refined = [
        refine(end, cloud.points, max_iterations=steps, factors=cloud.factors, bounds=bounds)
        for end in (fitted, *ends)
    ]
    at_rest = [each for each in refined if each.converged]
    if not at_rest:
        return FailedFit(f"the least-squares fit of a {fitted.kind} did not converge in {steps} steps")
    best = min(at_rest, key=lambda each: each.cost).primitive
    return _last_digits(best, trial, Kernel.LEAST_SQUARES)


def _last_digits(primitive: Primitive, trial: Trial, kernel: Kernel, scale: float = 1.0) -> Finished:
    """Newton's method where all points and parameters are free."""
    free = trial.limits is None and trial.cloud.factors is None
    if free:
        primitive = newton(primitive, trial.cloud.points, kernel, scale)
    return Finished(primitive, kernel, scale)


def _turned_starts(trial: Trial) -> list[Primitive]:
    """Guesses from the points as turned in several ways, and turned back: other directions are tried.

    Few points leave many minima, and their normals tell little.
    """
    from scipy.spatial.transform import Rotation  # slow to import, and few searches turn their points

    kind, points, rng = trial.primitive, trial.cloud.working, np.random.default_rng(0)
    surfaces: list[Primitive] = []
    for turn in Rotation.random(TURNS, random_state=0).as_matrix():
        normals = rng.normal(size=points.shape)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        rows = kind.initial_guesses(Oriented(points @ turn.T, normals), rng)
        guesses = (kind.from_row(row) for row in rows)
        surfaces += [guess.transformed(turn.T, np.zeros(3), 1.0) for guess in guesses]
    if trial.limits is None:
        return surfaces
    within = (trial.limits.impose(surface.row(), points) for surface in surfaces)
    return [kind.from_row(row) for row in within if np.isfinite(row).all()]


def _different(ends: list[Refined], points: Array) -> list[Primitive]:
    """The primitives of the `BEST_ENDS` cheapest ends, without those at the distances of a cheaper one."""
    kept: list[Primitive] = []
    seen: list[Array] = []
    for end in sorted((end for end in ends if np.isfinite(end.cost)), key=lambda end: end.cost):
        distance = np.abs(end.primitive.signed_distance(points))
        if all(np.linalg.norm(distance - other) > SAME_END * np.linalg.norm(other) for other in seen):
            kept.append(end.primitive)
            seen.append(distance)
        if len(kept) == BEST_ENDS:
            break
    return kept


def huber(fitted: Finished, starts: Array, trial: Trial) -> Finished | FailedFit:
    """Huber's M-estimate: outliers pull with the force of `HUBER_95` scales."""
    return _m_estimate(fitted, trial, Kernel.HUBER, HUBER_95)


def tukey(fitted: Finished, starts: Array, trial: Trial) -> Finished | FailedFit:
    """Tukey's M-estimate: points beyond `TUKEY_95` scales do not count."""
    return _m_estimate(fitted, trial, Kernel.TUKEY, TUKEY_95 / CUTOFF)


def _m_estimate(fitted: Finished, trial: Trial, kernel: Kernel, width: float) -> Finished | FailedFit:
    """Scale and surface in turn until both rest; least squares where points are too few to reject any.

    The scale is the normalized median absolute distance, 1.4826 median |d|, at least the tolerance.
    Source: Huber and Ronchetti, "Robust statistics", 2nd ed. 2009, sections 7.7 and 7.8; Holland and Welsch,
    "Robust regression using iteratively reweighted least-squares", Comm. Statist. A6, 1977 (tuning).
    """
    if trial.is_small:
        return fitted
    cloud, primitive, scale = trial.cloud, fitted.primitive, np.inf
    for _ in range(MOST_ROUNDS):
        before, scale = scale, _median_scale(primitive, cloud)
        if abs(scale - before) <= AT_REST * scale:
            end = _last_digits(primitive, trial, kernel, width * scale)
            return replace(end, scale=width * _median_scale(end.primitive, cloud))
        primitive = refine(
            primitive, cloud.points, kernel, width * scale, factors=cloud.factors, bounds=trial.bounds
        ).primitive
    return FailedFit(
        f"the {kernel.name.lower()} estimate of a {trial.kind} and of the scale of its noise "
        f"did not converge in {MOST_ROUNDS} rounds"
    )


def _median_scale(primitive: Primitive, cloud: Cloud) -> float:
    distance = np.abs(primitive.signed_distance(cloud.points))
    median = np.median(distance if cloud.factors is None else cloud.factors * distance)
    return max(1.4826 * float(median), cloud.tolerance)


def _started_at_least_squares(
    extreme: Callable[[Sequence[Primitive], Cloud], Primitive | FailedFit],
) -> Finisher:
    """An extreme surface from about that of least squares; of few points also from its other minima."""

    def finish(fitted: Finished, starts: Array, trial: Trial) -> Finished | FailedFit:
        cloud, start = trial.cloud, least_squares(fitted, starts, _of_few(trial))
        best = [(fitted if isinstance(start, FailedFit) else start).primitive]
        if len(cloud.points) <= FEW_POINTS:
            surfaces = [trial.primitive.from_row(row) for row in starts]
            best += _different([refine(surface, cloud.points) for surface in surfaces], cloud.points)
        found = extreme(best, cloud)
        return found if isinstance(found, FailedFit) else Finished(found, None)

    return finish


def _of_few(trial: Trial) -> Trial:
    """The trial with the sample of a large cloud: only the start of an extreme surface comes of it."""
    cloud = trial.cloud
    if len(cloud.points) <= SAMPLE_POINTS:
        return trial
    return replace(trial, cloud=replace(cloud, points=cloud.working[cloud.sample], factors=None))


FINISHERS: dict[str, Finisher] = {
    "robust": robust,
    "least_squares": least_squares,
    "huber": huber,
    "tukey": tukey,
    "minimum_zone": _started_at_least_squares(minimum_zone),
    "minimum_circumscribed": _started_at_least_squares(minimum_circumscribed),
    "maximum_inscribed": _started_at_least_squares(maximum_inscribed),
}
"""By the names of `fitting.names.Criterion`."""
