"""What the parameters minimise: one finisher a criterion, from where the search ended."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from fitting.cloud import Cloud
from fitting.geometry import Array
from fitting.kernels import CUTOFF, HUBER_95, TUKEY_95, Kernel
from fitting.newton import newton
from fitting.primitives import PRIMITIVES, Primitive
from fitting.refine import Refined, refine
from fitting.result import FailedFit
from fitting.zones import maximum_inscribed, minimum_circumscribed, minimum_zone

COMPARED_POINTS = 160
"""Points that least squares from all starts is compared on."""

BEST_ENDS = 4
"""Of their ends so many different ones, the cheapest, go on with all points."""

TURNS = 4
"""Small clouds are looked at in so many more ways for starts."""

SAME_END = 1e-3
"""Ends whose distances differ by less than this, relatively, are the same."""

LEAST_SQUARES_STEPS = 500
"""Steps after which plain least squares is given up."""

MOST_ROUNDS = 100
"""Rounds of estimating a scale and refining at it after which an M-estimate is given up."""

AT_REST = 1e-9
"""The scale is at rest when it changes by less than this, relatively."""

Finisher = Callable[[Primitive, Array, Cloud], Primitive | FailedFit]
"""From the robust fit, the rows (K, 9) of all starts and the cloud to the primitive of a criterion."""


def robust(fitted: Primitive, starts: Array, cloud: Cloud) -> Primitive:
    """The robust fit as it is."""
    return fitted


def least_squares(fitted: Primitive, starts: Array, cloud: Cloud) -> Primitive | FailedFit:
    """Least squares over all points, which the robust fit to few points is already."""
    return fitted if cloud.is_small(fitted.dof) else cheapest_minimum(fitted, starts, cloud)


def cheapest_minimum(fitted: Primitive, starts: Array, cloud: Cloud) -> Primitive | FailedFit:
    """The cheapest of the minima of least squares that a fit and the starts lead to.

    A failure where none is reached.
    """
    some = cloud.working[cloud.sample[:COMPARED_POINTS]]
    surfaces = [fitted, *(PRIMITIVES[fitted.kind].from_row(row) for row in starts)]
    if cloud.is_small(fitted.dof):
        surfaces += _turned_starts(fitted.kind, cloud)
    ends = _different([refine(surface, some) for surface in surfaces], some)
    refined = [refine(end, cloud.points, max_iterations=LEAST_SQUARES_STEPS) for end in (fitted, *ends)]
    at_rest = [each for each in refined if each.converged]
    if not at_rest:
        return FailedFit(
            f"least squares on a {fitted.kind} did not come to rest in {LEAST_SQUARES_STEPS} steps"
        )
    best = min(at_rest, key=lambda each: each.cost).primitive
    return newton(best, cloud.points, Kernel.LEAST_SQUARES)


def _turned_starts(kind: str, cloud: Cloud) -> list[Primitive]:
    """Guesses from the points as turned in several ways, and turned back: other directions are tried.

    Few points leave many minima, and their normals tell little.
    """
    points, rng = cloud.working, np.random.default_rng(0)
    surfaces: list[Primitive] = []
    for turn in Rotation.random(TURNS, random_state=0).as_matrix():
        normals = rng.normal(size=points.shape)
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        rows = PRIMITIVES[kind].initial_guesses(points @ turn.T, normals, rng)
        guesses = (PRIMITIVES[kind].from_row(row) for row in rows)
        surfaces += [guess.transformed(turn.T, np.zeros(3), 1.0) for guess in guesses]
    return surfaces


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


def huber(fitted: Primitive, starts: Array, cloud: Cloud) -> Primitive | FailedFit:
    """Huber's M-estimate: outliers pull with the force of `HUBER_95` scales."""
    return _m_estimate(fitted, cloud, Kernel.HUBER, HUBER_95)


def tukey(fitted: Primitive, starts: Array, cloud: Cloud) -> Primitive | FailedFit:
    """Tukey's M-estimate: points beyond `TUKEY_95` scales do not count."""
    return _m_estimate(fitted, cloud, Kernel.TUKEY, TUKEY_95 / CUTOFF)


def _m_estimate(fitted: Primitive, cloud: Cloud, kernel: Kernel, width: float) -> Primitive | FailedFit:
    """Scale and surface in turn until both rest; least squares where points are too few to reject any.

    The scale is the normalised median absolute distance, 1.4826 median |d|, at least the tolerance.
    Source: Huber and Ronchetti, "Robust statistics", 2nd ed. 2009, sections 7.7 and 7.8; Holland and Welsch,
    "Robust regression using iteratively reweighted least-squares", Comm. Statist. A6, 1977 (tuning).
    """
    if cloud.is_small(fitted.dof):
        return fitted
    primitive, scale = fitted, np.inf
    for _ in range(MOST_ROUNDS):
        before, scale = scale, 1.4826 * float(np.median(np.abs(primitive.signed_distance(cloud.points))))
        scale = max(scale, cloud.tolerance)
        if abs(scale - before) <= AT_REST * scale:
            return newton(primitive, cloud.points, kernel, width * scale)
        primitive = refine(primitive, cloud.points, kernel, width * scale).primitive
    return FailedFit(
        f"scale and surface of the {kernel.name.lower()} estimate of a {fitted.kind} "
        f"did not come to rest in {MOST_ROUNDS} rounds"
    )


def _started_at_least_squares(extreme: Callable[[Primitive, Cloud], Primitive | FailedFit]) -> Finisher:
    def finish(fitted: Primitive, starts: Array, cloud: Cloud) -> Primitive | FailedFit:
        start = least_squares(fitted, starts, cloud)
        return extreme(fitted if isinstance(start, FailedFit) else start, cloud)

    return finish


FINISHERS: dict[str, Finisher] = {
    "robust": robust,
    "least_squares": least_squares,
    "huber": huber,
    "tukey": tukey,
    "minimum_zone": _started_at_least_squares(minimum_zone),
    "minimum_circumscribed": _started_at_least_squares(minimum_circumscribed),
    "maximum_inscribed": _started_at_least_squares(maximum_inscribed),
}
"""By the names of `fitting.config.Criterion`."""
