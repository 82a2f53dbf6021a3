"""From the end of a search to the optimum: exact points, or the scale of the noise."""

import numpy as np

from ..cloud.cloud import WORKING_POINTS
from ..geometry.vectors import Array
from ..noise.exact import exact_points, is_peaked
from ..noise.kernels import CUTOFF, Kernel
from ..noise.scale import CORE, CORE_DEVIATION, SCALE_AT_REST, is_normal
from ..primitives.primitive import Primitive
from ..solver.refine import CODES, LIMITED_STEPS, STEPS, distances, refine
from ..trial.trial import Trial
from . import _rest
from .anneal import SLOW_SHRINK, anneal
from .finished import Finished

MOST_ROUNDS = 100
"""Rounds of choosing points or a scale and refining on them."""

LONG_ROUNDS, ROUND_STEPS, POINT_STEPS = 20, 2, 2000
"""Where nothing limits the surface, so many rounds are taken at most, of so many steps, or of as many as look
at so many points in all: more of them bring a surface nearer to where it would rest at a scale that it
changes. What has come to no rest by then is on its way to a simpler kind."""


def polish(primitive: Primitive, trial: Trial) -> Finished:
    """Least squares on the exact points where there are any, else under a wide biweight on all points.

    A small exact subset is found only from the biweight's optimum, and on all working points.
    """
    exact = _polish_exact(primitive, trial)
    if exact:
        return exact
    noisy = _polish_noisy(primitive, trial)
    if not is_peaked(distances(noisy.primitive, trial.cloud.working), trial.dof):
        return noisy
    end = anneal(trial, noisy.primitive.row(), trial.cloud.working, SLOW_SHRINK)
    return _polish_exact(trial.primitive.from_row(end.row), trial) or noisy


def _polish_exact(primitive: Primitive, trial: Trial) -> Finished | None:
    """Least squares on the exact points, until they are the same ones before and after."""
    before, cloud = None, trial.cloud
    for _ in range(MOST_ROUNDS):
        exact = exact_points(np.abs(distances(primitive, cloud.working)), cloud.tolerance, trial.dof)
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
    row, scale, residual = _with_its_scale(primitive, trial)
    cloud, primitive = trial.cloud, trial.primitive.from_row(row)
    factors = cloud.working_factors
    normal = is_normal(residual if factors is None else factors * residual, CUTOFF * scale)
    many = len(cloud.points) > WORKING_POINTS
    kernel = Kernel.LEAST_SQUARES if normal else Kernel.TUKEY
    if normal or many:
        points, factors = (cloud.points, cloud.factors) if many else (cloud.working, factors)
        primitive = refine(primitive, points, kernel, scale, factors=factors, bounds=trial.bounds).primitive
    return Finished(primitive, kernel, scale)


def _with_its_scale(primitive: Primitive, trial: Trial) -> tuple[Array, float, Array]:
    """The row (9,) under a biweight and the scale of the core of its distances (M,), at rest with each other.

    Limits are kept by rounds of both alone. A surface that is on its way to a simpler kind, to which a radius
    without end leads, comes to no rest.
    """
    cloud, limits = trial.cloud, trial.limits
    steps = min(max(POINT_STEPS // len(cloud.working), ROUND_STEPS), STEPS)
    return _rest.with_its_scale(
        CODES[trial.kind],
        primitive.row(),
        np.ascontiguousarray(cloud.working),
        cloud.tolerance,
        LIMITED_STEPS if limits else steps,
        MOST_ROUNDS if limits else LONG_ROUNDS,
        np.array(primitive.chart.across, np.int64).reshape(-1, 2),
        CORE,
        CORE_DEVIATION,
        SCALE_AT_REST,
        cloud.working_factors,
        trial.bounds,
    )
