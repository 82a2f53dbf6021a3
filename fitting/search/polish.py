"""From the end of a search to the optimum: exact points, or the scale of the noise."""

import numpy as np

from ..cloud.cloud import WORKING_POINTS
from ..noise.exact import exact_points, is_peaked
from ..noise.kernels import CUTOFF, Kernel
from ..noise.scale import core_scale, is_normal
from ..primitives.primitive import Primitive
from ..solver.refine import STEPS, refine
from ..trial.trial import Trial
from .anneal import SLOW_SHRINK, anneal
from .finished import Finished
from .rest import at_rest

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


def polish(primitive: Primitive, trial: Trial) -> Finished:
    """Least squares on the exact points where there are any, else under a wide biweight on all points.

    A small exact subset is found only from the biweight's optimum, and on all working points.
    """
    exact = _polish_exact(primitive, trial)
    if exact:
        return exact
    noisy = _polish_noisy(primitive, trial)
    if not is_peaked(noisy.primitive.signed_distance(trial.cloud.working), trial.dof):
        return noisy
    end = anneal(trial, noisy.primitive.row(), trial.cloud.working, SLOW_SHRINK)
    return _polish_exact(end.primitive, trial) or noisy


def _polish_exact(primitive: Primitive, trial: Trial) -> Finished | None:
    """Least squares on the exact points, until they are the same ones before and after."""
    before, cloud = None, trial.cloud
    for _ in range(MOST_ROUNDS):
        exact = exact_points(np.abs(primitive.signed_distance(cloud.working)), cloud.tolerance, trial.dof)
        if not exact.any():
            return None
        if before is not None and np.array_equal(exact, before):
            break
        factors = None if cloud.working_factors is None else cloud.working_factors[exact]
        primitive = refine(primitive, cloud.working[exact], factors=factors, bounds=trial.bounds).primitive
        before = exact
    return Finished(primitive, Kernel.LEAST_SQUARES, exact=True)


def _polish_noisy(primitive: Primitive, trial: Trial) -> Finished:
    """A biweight at the scale of the noise: on the working points until both agree, then on all points.

    Where the noise is normal, and nothing is to be rejected, least squares in the end.
    """
    primitive, scale = _with_its_scale(primitive, trial)
    cloud = trial.cloud
    factors = cloud.working_factors
    residual = primitive.signed_distance(cloud.working)
    normal = is_normal(residual if factors is None else factors * residual, CUTOFF * scale)
    many = len(cloud.points) > WORKING_POINTS
    kernel = Kernel.LEAST_SQUARES if normal else Kernel.TUKEY
    if normal or many:
        points, factors = (cloud.points, cloud.factors) if many else (cloud.working, factors)
        primitive = refine(primitive, points, kernel, scale, factors=factors, bounds=trial.bounds).primitive
    return Finished(primitive, kernel, scale)


def _with_its_scale(primitive: Primitive, trial: Trial) -> tuple[Primitive, float]:
    """The surface under a biweight and the scale of the core of its distances, at rest with each other.

    Limits are kept by rounds of both alone. A surface that is on its way to a simpler kind, to which a radius
    without end leads, comes to no rest.
    """
    cloud, limits = trial.cloud, trial.limits
    factors, n = cloud.working_factors, len(cloud.working)
    steps = None if limits else min(max(POINT_STEPS // n, FEWEST_STEPS), STEPS)
    scale, nearly = 0.0, NEARLY
    for _ in range(MOST_ROUNDS if limits else LONG_ROUNDS):
        residual = primitive.signed_distance(cloud.working)
        before, scale = scale, core_scale(np.abs(residual if factors is None else factors * residual))
        scale = max(scale, cloud.tolerance)
        refined = refine(primitive, cloud.working, Kernel.TUKEY, scale, steps, factors, trial.bounds)
        primitive, change = refined.primitive, abs(scale - before)
        if change <= AT_REST * scale and (limits or refined.converged):
            break
        if change <= nearly * scale and not limits:
            nearly *= NEARLY
            if rest := at_rest(primitive, scale, cloud.working, cloud.tolerance, factors):
                return rest
    return primitive, scale
