"""The best primitive of one kind: starts, annealed robust refinement, and a finish on the right points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import FailedFit
from ..geometry.vectors import Array
from ..names import KINDS
from ..noise.outliers import NoiseModel
from ..primitives.primitive import Primitive
from ..request.config import FITTING_KINDS
from ..solver.refine import distances
from ..trial.limits import Limits, moved
from ..trial.trial import Trial
from .anneal import ENOUGH_EXACT, Annealed, anneal, search
from .criteria import FINISHERS, cheapest_minimum
from .finished import Finished
from .polish import polish
from .starts import ranked_starts
from .view import View

UNEXPLAINED, OUTLYING, SCATTERED = 1.0, 0.02, 0.03
"""The flattest part of the cloud is searched, too, where what is left over is so many times its noise, and
what a search that outliers have misled leaves: so large a share of them, or so much noise over the extent.
Neighbors scatter no less about their plane than about the right surface, as curvature adds to it. Noise that
they share is left over as well, but without outliers."""

LEAST_TURN = 1e-3
"""A curved surface whose normals turn by less [rad] between points of one plane is that plane."""


@dataclass(frozen=True)
class Fit:
    """Where the criterion ends, and the robust fit of the kind, which is what is judged.

    `unlimited`, within limits, is roughly the best surface without them, where the points are not too few.
    """

    finished: Finished
    robust: Primitive
    unlimited: Primitive | None = None


def fit_kind(
    trial: Trial,
    criterion: str,
    rng: np.random.Generator,
    guess: Primitive | None = None,
    rough: Primitive | None = None,
) -> Fit | FailedFit:
    """The best primitive of a kind in the normalized frame of its cloud.

    A guess, which joins the starts of its kind, is in input units. A rough surface, in that frame, is tried
    before any of them.
    """
    kind, cloud, limits = trial.kind, trial.cloud, trial.limits
    if kind not in (allowed := FITTING_KINDS.get(criterion, KINDS)):
        return FailedFit(
            f"the criterion {criterion} is defined for a {' or a '.join(allowed)}, not for a {kind}"
        )
    if (count := len(cloud.working)) < trial.dof:
        return FailedFit(f"{count} distinct points do not determine a {kind}; it takes {trial.dof}")
    bends = cloud.flat and not trial.primitive.flat
    in_one_plane = FailedFit(f"the points lie in one plane and do not determine a {kind}")
    if bends and trial.dof == trial.primitive.dof:
        return in_one_plane
    guessed = guess is not None and guess.kind == kind
    extra = [cloud.frame.bring(guess).row()] if guessed and guess else []
    if limits is None:
        exact = _from_rough(rough, trial) if rough and criterion == "robust" else None
        return exact or _fit(trial, criterion, rng, extra)
    found = _fit_limited(trial, limits, criterion, rng, extra)
    turned = isinstance(found, Fit) and _turn(found.robust, cloud.working) >= LEAST_TURN
    return in_one_plane if bends and not turned else found


def _from_rough(rough: Primitive, trial: Trial) -> Fit | None:
    """What a rough surface is annealed to, where it locks on so many exact points that no start is needed."""
    if trial.is_small:
        return None
    end = anneal(trial, rough.row(), trial.cloud.searched)
    if end.exact_share < ENOUGH_EXACT:
        return None
    robust = polish(trial.primitive.from_row(end.row), trial)
    return Fit(robust, robust.primitive)


def _fit_limited(
    trial: Trial, limits: Limits, criterion: str, rng: np.random.Generator, extra: list[Array]
) -> Fit | FailedFit:
    """Within limits, about their pivot; the best surface without them joins the starts."""
    free = _unlimited(trial, rng, extra)
    found = _fit(trial.about_pivot, criterion, rng, extra + free)
    if isinstance(found, FailedFit):
        return found
    unlimited = trial.primitive.from_row(free[0]) if free else None
    return Fit(found.finished.moved(limits.pivot), moved(found.robust, limits.pivot), unlimited)


def _unlimited(trial: Trial, rng: np.random.Generator, extra: Sequence[Array]) -> list[Array]:
    """The row of the best surface without limits, where the cloud is not too small to tell."""
    view = View.of(trial.free)
    starts = ranked_starts(view, rng, extra)
    return [_likeliest(starts, view, rng).row] if len(starts) and not trial.is_small else []


def _turn(primitive: Primitive, points: Array) -> float:
    """How far the normals of a surface turn between the points (N, 3), about [rad]."""
    return float(np.linalg.norm(np.ptp(primitive.gradient(points), axis=0)))


def _fit(trial: Trial, criterion: str, rng: np.random.Generator, extra: Sequence[Array]) -> Fit | FailedFit:
    """The best primitive within the limits, to the pivot of which the cloud is relative."""
    view = View.of(trial)
    starts = ranked_starts(view, rng, extra)
    if not len(starts):
        return FailedFit(f"no first guess of a {trial.kind} was found from these points")
    robust = _fit_robustly(starts, view, rng)
    if isinstance(robust, FailedFit):
        return robust
    finished = FINISHERS[criterion](robust, starts, trial)
    return finished if isinstance(finished, FailedFit) else Fit(finished, robust.primitive)


def _fit_robustly(starts: Array, view: View, rng: np.random.Generator) -> Finished | FailedFit:
    """The best of what the starts are annealed to, polished; in a small cloud plain least squares."""
    trial = view.trial
    if trial.is_small:
        return cheapest_minimum(trial.primitive.from_row(starts[0]), starts, trial)
    return polish(trial.primitive.from_row(_likeliest(starts, view, rng).row), trial)


def _likeliest(starts: Array, view: View, rng: np.random.Generator) -> Annealed:
    """The end of a search, or of one in the flattest part of the cloud where much noise is unexplained."""
    trial, best = view.trial, search(starts, view)
    if best.exact_share > 0.0 or len(trial.cloud.flattest) < trial.primitive.dof:
        return best
    if not _is_misled(_noise(best.row, trial), trial):
        return best
    flattest = View.of_flattest(trial)
    others = ranked_starts(flattest, rng)
    if not len(others):
        return best
    ends = (best, search(others, flattest))
    return max(ends, key=lambda end: _noise(end.row, trial).log_likelihood)


def _is_misled(noise: NoiseModel, trial: Trial) -> bool:
    """Whether noise may come of a surface that outliers have led the search to."""
    if noise.scale <= UNEXPLAINED * trial.cloud.local_noise:
        return False
    return noise.outlier_share > OUTLYING or noise.scale > SCATTERED * trial.cloud.extent


def _noise(row: Array, trial: Trial) -> NoiseModel:
    cloud = trial.cloud
    distance = distances(trial.primitive.from_row(row), cloud.working[cloud.sample])
    return NoiseModel.of(distance, cloud.tolerance, cloud.extent)
