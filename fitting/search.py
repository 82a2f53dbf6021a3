"""The best primitive of one kind: starts, annealed robust refinement, and a finish on the right points."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from fitting import _descent
from fitting.cloud import WORKING_POINTS, Cloud
from fitting.config import FITTING_KINDS
from fitting.constraints import UNCONSTRAINED, Constraints
from fitting.criteria import FINISHERS, cheapest_minimum
from fitting.geometry import TINY, Array
from fitting.kernels import CUTOFF, Kernel
from fitting.limits import Limits, dof_within, moved
from fitting.noise import (
    CORE,
    CORE_DEVIATION,
    NoiseModel,
    core_scale,
    exact_points,
    is_normal,
    is_peaked,
)
from fitting.primitives import KINDS, PRIMITIVES, Cylinder, Primitive, Torus
from fitting.refine import CODES, STEPS, refine, settle
from fitting.rest import at_rest
from fitting.result import FailedFit

GUESS_POINTS = 160
"""Points that starts are derived from and ranked on."""

SEARCH_POINTS = 512
"""Points that the annealing runs on."""

RANKING_STEPS = 10
"""Robust steps that every start takes before the starts are compared."""

BENT_CYLINDERS = 3
"""So many cylinders are bent for starts of tori."""

SETTLED_STARTS = 24
SETTLING_STEPS = 20
STARTS = 5
"""Unless the best start finds a large exact subset, so many others take so many more steps, and so many of
those are annealed."""

RESOLVED = 1e-3
"""Distances, in the normalised frame, below which one start is not taken for better than another."""

SAME_END = 0.03
"""Starts whose distances differ by less than this, relatively, have come to the same end."""

SHRINK = 0.7
SLOW_SHRINK = 0.85
"""Factor between the kernel scales of one step and the next; the slow one finds smaller exact subsets."""

ENOUGH_EXACT = 0.3
"""If the best start finds an exact subset of this share, no other is annealed."""

UNEXPLAINED = 2.0
"""The flattest part of the cloud is searched, too, where what is left over is this many times its noise."""

MOST_ROUNDS = 100
"""Rounds of choosing points or a scale and refining on them ..."""

AT_REST = 1e-12
"""... which end when the scale changes by less than this, relatively: then the path to it has no say."""

LONG_ROUNDS, FEWEST_STEPS, POINT_STEPS = 20, 5, 20_000
"""Where nothing limits the surface, so many rounds are taken, of at least so many steps: of as many as look
at so many points in all, if that is more, and of `STEPS` at most. What has come to no rest by then is on its
way to a simpler kind."""

NEARLY = 0.03
"""A round that changes the scale by less than this, relatively, is followed by Anderson's method; should that
fail, the next one that changes it by less than this share of that."""

LEAST_TURN = 1e-3
"""A curved surface whose normals turn by less [rad] between points of one plane is that plane."""

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


@dataclass(frozen=True, eq=False)
class View:
    """What a search looks at: points (N, 3) in random order, normals (L, 3) at the first, the rounding.

    With limits, the points are relative to their pivot and the search stays within them.
    """

    points: Array
    normals: Array
    tolerance: float
    limits: Limits | None = None

    @classmethod
    def of(cls, cloud: Cloud, limits: Limits | None = None) -> Self:
        return cls(cloud.working[cloud.sample[:SEARCH_POINTS]], cloud.normals, cloud.tolerance, limits)

    @classmethod
    def of_flattest(cls, cloud: Cloud, limits: Limits | None = None) -> Self:
        """Of the part of a cloud that has the fewest outliers."""
        points = cloud.working[cloud.sample[cloud.flattest]]
        return cls(points, cloud.normals[cloud.flattest], cloud.tolerance, limits)


@dataclass(frozen=True)
class Fit:
    """A primitive as the criterion has it, and the robust fit of its kind, which is what is judged."""

    primitive: Primitive
    robust: Primitive


def fit_kind(
    kind: str,
    cloud: Cloud,
    criterion: str,
    rng: np.random.Generator,
    constraints: Constraints = UNCONSTRAINED,
    guess: Primitive | None = None,
) -> Fit | FailedFit:
    """The best primitive of one kind in the normalised frame of the cloud.

    Constraints and a guess, which joins the starts of its kind, are in input units.
    """
    if kind not in (allowed := FITTING_KINDS.get(criterion, KINDS)):
        return FailedFit(f"{criterion} is defined for a {' or a '.join(allowed)}, not for a {kind}")
    limits = Limits.of(constraints, kind, cloud.frame)
    dof = dof_within(kind, limits)
    if len(cloud.working) < dof:
        return FailedFit(f"{len(cloud.working)} distinct points do not determine a {kind}, which takes {dof}")
    flat = cloud.flat and kind != "plane"
    in_one_plane = FailedFit(f"the points lie in one plane and do not determine a {kind}")
    if flat and dof == PRIMITIVES[kind].dof:
        return in_one_plane
    extra = [cloud.frame.bring(guess).row()] if guess is not None and guess.kind == kind else []
    if limits is None:
        return _fit(kind, cloud, criterion, rng, extra)
    free = View.of(cloud)
    starts = ranked_starts(kind, free, rng, extra)
    if len(starts) and not cloud.is_small(dof):
        extra.append(_likeliest(kind, starts, free, cloud, rng).primitive.row())
    found = _fit(kind, cloud.about(limits.pivot), criterion, rng, extra, limits)
    if isinstance(found, FailedFit):
        return in_one_plane if flat else found
    if flat and _turn(found.robust, cloud.working - limits.pivot) < LEAST_TURN:
        return in_one_plane
    return Fit(moved(found.primitive, limits.pivot), moved(found.robust, limits.pivot))


def _turn(primitive: Primitive, points: Array) -> float:
    """How far the normals of a surface turn between the points (N, 3), about [rad]."""
    return float(np.linalg.norm(np.ptp(primitive.gradient(points), axis=0)))


def _fit(
    kind: str,
    cloud: Cloud,
    criterion: str,
    rng: np.random.Generator,
    extra: Sequence[Array],
    limits: Limits | None = None,
) -> Fit | FailedFit:
    """The best primitive within the limits, to the pivot of which the cloud is relative."""
    view = View.of(cloud, limits)
    starts = ranked_starts(kind, view, rng, extra)
    if not len(starts):
        return FailedFit(f"no {kind} could be started from these points")
    robust = _fit_robustly(kind, starts, view, cloud, rng)
    if isinstance(robust, FailedFit):
        return robust
    primitive = FINISHERS[criterion](robust, starts, cloud, limits)
    return primitive if isinstance(primitive, FailedFit) else Fit(primitive, robust)


def _fit_robustly(
    kind: str, starts: Array, view: View, cloud: Cloud, rng: np.random.Generator
) -> Primitive | FailedFit:
    """The best of what the starts are annealed to, polished; in a small cloud plain least squares."""
    if cloud.is_small(dof_within(kind, view.limits)):
        return cheapest_minimum(PRIMITIVES[kind].from_row(starts[0]), starts, cloud, view.limits)
    return polish(_likeliest(kind, starts, view, cloud, rng).primitive, cloud, view.limits)


def _likeliest(kind: str, starts: Array, view: View, cloud: Cloud, rng: np.random.Generator) -> Annealed:
    """The end of a search, or of one in the flattest part of the cloud where much noise is unexplained."""
    best = search(kind, starts, view)
    if best.exact_share > 0.0 or len(cloud.flattest) < PRIMITIVES[kind].dof:
        return best
    if _noise(best.primitive, cloud).scale > UNEXPLAINED * cloud.local_noise:
        return _likelier(best, kind, cloud, rng, view.limits)
    return best


def _likelier(
    best: Annealed, kind: str, cloud: Cloud, rng: np.random.Generator, limits: Limits | None
) -> Annealed:
    """The given end or that of a search in the flattest part of the cloud: what explains the cloud better."""
    view = View.of_flattest(cloud, limits)
    starts = ranked_starts(kind, view, rng)
    if not len(starts):
        return best
    other = search(kind, starts, view)
    return max((best, other), key=lambda end: _noise(end.primitive, cloud).log_likelihood)


def _noise(primitive: Primitive, cloud: Cloud) -> NoiseModel:
    distance = primitive.signed_distance(cloud.working[cloud.sample])
    return NoiseModel.of(distance, cloud.tolerance, cloud.extent)


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


def search(kind: str, starts: Array, view: View) -> Annealed:
    """The best end of annealing from the first of the starts (K, 9), and from others where they are asked."""
    best = anneal(kind, starts[0], view.points, view.tolerance, limits=view.limits)
    if best.exact_share >= ENOUGH_EXACT:
        return best
    others = distinct_starts(kind, starts[1:], view)
    ends = (anneal(kind, row, view.points, view.tolerance, limits=view.limits) for row in others)
    return best_of([best, *ends], view.points)


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


def anneal(
    kind: str,
    row: Array,
    points: Array,
    tolerance: float,
    shrink: float = SHRINK,
    limits: Limits | None = None,
) -> Annealed:
    """Refine under a Geman-McClure kernel whose scale shrinks to the noise, and on to an exact subset.

    Source: graduated non-convexity, Black and Rangarajan, IJCV 19, 1996; Yang et al., IEEE RA-L 5, 2020.
    """
    dof = dof_within(kind, limits)
    need = max(2 * dof + 2, int(np.ceil(LOST * len(points))))
    numbers = None if limits is None else limits.numbers
    row, at_noise = _descent.anneal(
        CODES[kind], row, points, tolerance, shrink, LOCKED, AT_NOISE, need, CORE, CORE_DEVIATION, numbers
    )
    primitive = PRIMITIVES[kind].from_row(row)
    exact = exact_points(np.abs(primitive.signed_distance(points)), tolerance, dof)
    if exact.any():
        return Annealed(primitive, float(exact.mean()))
    return Annealed(primitive if at_noise is None else PRIMITIVES[kind].from_row(at_noise), 0.0)


def best_of(ends: list[Annealed], points: Array) -> Annealed:
    """The end with the largest exact subset, or else with the least robust cost at the smallest median."""
    best = max(ends, key=lambda end: end.exact_share)
    if best.exact_share > 0.0:
        return best
    squared = [end.primitive.signed_distance(points) ** 2 for end in ends]
    scale2 = max(min(float(np.median(each)) for each in squared), TINY)
    return ends[int(np.argmin([Kernel.TUKEY.rho(each / scale2).sum() for each in squared]))]


def polish(primitive: Primitive, cloud: Cloud, limits: Limits | None = None) -> Primitive:
    """Least squares on the exact points where there are any, else under a wide biweight on all points.

    A small exact subset is found only from the biweight's optimum, and on all working points.
    """
    exact = _polish_exact(primitive, cloud, limits)
    if exact:
        return exact
    noisy = _polish_noisy(primitive, cloud, limits)
    if not is_peaked(noisy.signed_distance(cloud.working), dof_within(noisy.kind, limits)):
        return noisy
    end = anneal(noisy.kind, noisy.row(), cloud.working, cloud.tolerance, SLOW_SHRINK, limits)
    return _polish_exact(end.primitive, cloud, limits) or noisy


def _polish_exact(primitive: Primitive, cloud: Cloud, limits: Limits | None) -> Primitive | None:
    """Least squares on the exact points, until they are the same ones before and after."""
    before, dof = None, dof_within(primitive.kind, limits)
    for _ in range(MOST_ROUNDS):
        exact = exact_points(np.abs(primitive.signed_distance(cloud.working)), cloud.tolerance, dof)
        if not exact.any():
            return None
        if before is not None and np.array_equal(exact, before):
            break
        factors = None if cloud.working_factors is None else cloud.working_factors[exact]
        primitive = refine(primitive, cloud.working[exact], factors=factors, limits=limits).primitive
        before = exact
    return primitive


def _polish_noisy(primitive: Primitive, cloud: Cloud, limits: Limits | None) -> Primitive:
    """A biweight at the scale of the noise: on the working points until both agree, then on all points.

    Where the noise is normal, and nothing is to be rejected, least squares in the end.
    """
    primitive, scale = _with_its_scale(primitive, cloud, limits)
    factors = cloud.working_factors
    residual = primitive.signed_distance(cloud.working)
    normal = is_normal(residual if factors is None else factors * residual, CUTOFF * scale)
    many = len(cloud.points) > WORKING_POINTS
    if normal or many:
        kernel = Kernel.LEAST_SQUARES if normal else Kernel.TUKEY
        points, factors = (cloud.points, cloud.factors) if many else (cloud.working, factors)
        primitive = refine(primitive, points, kernel, scale, factors=factors, limits=limits).primitive
    return primitive


def _with_its_scale(primitive: Primitive, cloud: Cloud, limits: Limits | None) -> tuple[Primitive, float]:
    """The surface under a biweight and the scale of the core of its distances, at rest with each other.

    Limits are kept by rounds of both alone. A surface that is on its way to a simpler kind, to which a radius
    without end leads, comes to no rest.
    """
    factors, n = cloud.working_factors, len(cloud.working)
    steps = None if limits else min(max(POINT_STEPS // n, FEWEST_STEPS), STEPS)
    scale, nearly = 0.0, NEARLY
    for _ in range(MOST_ROUNDS if limits else LONG_ROUNDS):
        residual = primitive.signed_distance(cloud.working)
        before, scale = scale, core_scale(np.abs(residual if factors is None else factors * residual))
        scale = max(scale, cloud.tolerance)
        refined = refine(primitive, cloud.working, Kernel.TUKEY, scale, steps, factors, limits)
        primitive, change = refined.primitive, abs(scale - before)
        if change <= AT_REST * scale and (limits or refined.converged):
            break
        if change <= nearly * scale and not limits:
            nearly *= NEARLY
            if rest := at_rest(primitive, scale, cloud.working, cloud.tolerance, factors):
                return rest
    return primitive, scale


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
