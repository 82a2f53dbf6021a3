"""The best primitive of one kind: starts, annealed robust refinement, and a finish on the right points."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..cloud.cloud import Cloud
from ..errors import FailedFit
from ..geometry.vectors import Array
from ..names import KINDS
from ..noise.outliers import NoiseModel
from ..primitives import PRIMITIVES, Primitive
from ..request.config import FITTING_KINDS
from ..request.constraints import UNCONSTRAINED, Constraints
from ..solver.limits import Limits, dof_within, moved
from .anneal import Annealed, search
from .criteria import FINISHERS, cheapest_minimum
from .polish import polish
from .starts import ranked_starts
from .view import View

UNEXPLAINED = 2.0
"""The flattest part of the cloud is searched, too, where what is left over is this many times its noise."""

LEAST_TURN = 1e-3
"""A curved surface whose normals turn by less [rad] between points of one plane is that plane."""


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
