"""How well an answer is known: from its optimum to a covariance, intervals and warnings."""

from collections.abc import Mapping

from ..extents.values import Extents
from ..primitives import SIZES, values_of
from ..primitives.primitive import Primitive
from ..search.finished import Finished
from ..verdict.evidence import Evidence
from .covariance import StepCovariance
from .intervals import Profiles, direction_of, intervals_of, position_of
from .optimum import Optimum
from .values import CorrelatedNoise, Interval, Spread, Uncertainty
from .warnings import Findings, warnings_of


def uncertainty_of(
    finished: Finished, answer: Primitive, evidence: Evidence, extents: Extents | None
) -> Uncertainty | None:
    """How well an answer is known; None under a criterion of extreme points, which has no such theory.

    Parameters
    ----------
    finished, answer : where the criterion ended, in the frame of the cloud, and the answered surface
    evidence : about the robust fit of the same kind
    extents : where the surface begins and ends
    """
    if finished.kernel is None:
        return None
    optimum, arcs = Optimum.of(finished, evidence), {} if extents is None else extents.arcs
    steps, names = optimum.covariance(optimum.linear), optimum.layout.names
    if steps is None:
        warnings = warnings_of(_findings(optimum, arcs))
        return Uncertainty("unknown", None, names, None, {}, None, None, warnings)
    by_step, quantile = optimum.by_step, optimum.quantile(steps)
    covariance = by_step @ steps.matrix @ by_step.T
    profiles = Profiles.of(optimum, steps)
    intervals = intervals_of(optimum, values_of(answer), covariance, quantile, profiles)
    direction = direction_of(optimum, steps, quantile, profiles)
    correlation = _correlation(steps, evidence.cloud.frame.scale)
    return Uncertainty(
        noise_model="exact" if optimum.exact else "independent" if correlation is None else "correlated",
        correlation=correlation,
        parameters=names,
        covariance=covariance,
        intervals=intervals,
        direction=direction,
        position=position_of(answer, names, covariance, quantile),
        warnings=warnings_of(_findings(optimum, arcs, answer, intervals, direction, correlation)),
    )


def _correlation(steps: StepCovariance, scale: float) -> CorrelatedNoise | None:
    found = steps.correlation
    if found is None:
        return None
    return CorrelatedNoise(scale * found.length, found.share, found.power, steps.effective_points)


def _findings(
    optimum: Optimum,
    arcs: Mapping[str, float],
    answer: Primitive | None = None,
    intervals: Mapping[str, Interval] | None = None,
    direction: Spread | None = None,
    correlation: CorrelatedNoise | None = None,
) -> Findings:
    return Findings(
        kind=optimum.primitive.kind,
        n_points=len(optimum.trial.cloud.working),
        dof=optimum.dof,
        determined=answer is not None,
        few=optimum.trial.is_small,
        arcs=arcs,
        sizes={
            name: (float(getattr(answer, name)), (interval.low, interval.high))
            for name, interval in (intervals or {}).items()
            if name in SIZES and interval.method != "held"
        },
        axis_95=None if direction is None else direction.radius_95,
        correlation_length=None if correlation is None else correlation.length,
        effective_points=0.0 if correlation is None else correlation.effective_points,
        unit=optimum.trial.cloud.frame.unit,
    )
