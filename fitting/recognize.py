"""The pipeline: check, normalise, rank, and for each kind guess, refine, weigh, until none can overtake."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from .answer.figures import summarize, summarize_noise
from .answer.residuals import Inliers
from .answer.result import Alternative, Attempt, Recognition
from .cloud.cloud import Cloud
from .errors import FailedFit, InvalidPointCloudError
from .extents import Extents, extents_of
from .geometry.vectors import Array
from .names import KINDS
from .primitives import Primitive
from .request.config import COUNTING_ALL, EXTREME, Config, takes_no
from .request.reach import check_reach
from .search.kind import fit_kind
from .search.starts import distance_to
from .solver.limits import Limits, dof_within
from .uncertainty.appraise import uncertainty_of
from .uncertainty.values import Uncertainty
from .verdict.classifier import Classifier
from .verdict.evidence import Evidence
from .verdict.judge import Claim, Decision, Question, best_of, claim, decide, may_overtake

DEFAULT_CONFIG = Config()

MOSTLY_EXACT = 0.9
"""Where so large a share of the inliers is exact, the others do not count for the extents."""


@dataclass(frozen=True)
class _Try:
    """An attempt with the claim behind it, which is missing where the fit failed."""

    attempt: Attempt
    claim: Claim | None = None
    primitive: Primitive | None = None
    """As the criterion has it, in the frame of the cloud."""


def recognize(
    points: Array,
    config: Config = DEFAULT_CONFIG,
    classifier: Classifier | None = None,
    normals: Array | None = None,
    weights: object = None,
    standard_deviations: object = None,
) -> Recognition:
    """Which primitive the points lie on, with its parameters and the trail of attempts.

    Parameters
    ----------
    points : (N, 3), any unit; N >= 3
    config : what may be answered, and how
    classifier : ranks the kinds; None takes them as equally probable, tries all, and selects
    normals : (N, 3), optional, one a point, any length and sign
    weights : (N,), optional, not negative: what the cost of each point is multiplied by in the last
        refinement; 0 leaves a point out
    standard_deviations : (N,), optional, of the noise of each point, in place of weights

    Raises
    ------
    InvalidPointCloudError : points that cannot be a cloud of any allowed kind, or weights beside a criterion
        of extreme points
    InvalidOptionError : constraints or an initial guess out of all proportion to the cloud
    """
    for field, given in (("weights", weights), ("standard_deviations", standard_deviations)):
        if given is not None and config.criterion in EXTREME:
            raise InvalidPointCloudError(takes_no(config.criterion, field), field)
    cloud = Cloud.prepare(
        points, normals, np.random.default_rng([config.seed, 0]), weights, standard_deviations
    )
    check_reach(config.constraints, config.initial_guess, cloud.frame)
    _check_count(cloud, config)
    probabilities = _rank(cloud, classifier) if classifier else None
    ranking = sorted(config.kinds, key=KINDS.index)
    if probabilities:
        ranking.sort(key=lambda kind: -probabilities[kind])
    tries: list[_Try] = []
    distances: dict[tuple[str, str], float] = {}
    while kind := _next_kind(ranking, tries, probabilities, cloud, config, distances):
        tries.append(_attempt(kind, cloud, config, probabilities))
    claims = [tried.claim for tried in tries if tried.claim]
    if not claims:
        return _nothing(tries, cloud)
    return _answer(decide(claims, cloud, _tolerance(config, cloud)), tries, cloud, config)


def _check_count(cloud: Cloud, config: Config) -> None:
    """Raise `InvalidPointCloudError` where the points determine none of the kinds."""
    fewest = min(dof_within(kind, Limits.of(config.constraints, kind, cloud.frame)) for kind in config.kinds)
    if len(cloud.points) < fewest:
        kinds = " or ".join(config.kinds)
        within = " within these constraints" if config.constraints.given else ""
        raise InvalidPointCloudError(
            f"{len(cloud.points)} points given; a {kinds}{within} needs at least {fewest}"
        )


def _rank(cloud: Cloud, classifier: Classifier) -> Mapping[str, float]:
    return classifier.rank(cloud.working[cloud.sample[: len(cloud.normals)]], cloud.normals)


def _tolerance(config: Config, cloud: Cloud) -> float:
    """In the frame of the cloud, 0 for none."""
    return 0.0 if config.tolerance is None else config.tolerance / cloud.frame.scale


def _next_kind(
    ranking: list[str],
    tries: list[_Try],
    probabilities: Mapping[str, float] | None,
    cloud: Cloud,
    config: Config,
    distances: dict[tuple[str, str], float],
) -> str | None:
    """The first kind, in order, that was not tried and might be the answer, or stand beside it.

    The distances of kinds from the best surface of another are kept for the next question.
    """
    done = {tried.attempt.kind for tried in tries}
    queue = [kind for kind in ranking if kind not in done]
    possible = [tried.claim for tried in tries if tried.claim and not tried.claim.refusal]
    if probabilities is None or not possible:
        return queue[0] if queue else None
    best, tolerance = best_of(possible), _tolerance(config, cloud)
    surface = best.evidence.primitive

    def apart(kind: str) -> float:
        if (kind, best.kind) not in distances:
            rng = np.random.default_rng([config.seed, 2, KINDS.index(kind)])
            distances[kind, best.kind] = distance_to(kind, surface, cloud, rng)
        return distances[kind, best.kind]

    nearly = surface.simpler_kinds(extent=1.0)
    hopeful = (
        kind
        for kind in queue
        if kind in nearly or may_overtake(kind, probabilities[kind], best, cloud, tolerance, apart)
    )
    return next(hopeful, None)


def _attempt(kind: str, cloud: Cloud, config: Config, probabilities: Mapping[str, float] | None) -> _Try:
    probability = probabilities[kind] if probabilities else None
    rng = np.random.default_rng([config.seed, 1, KINDS.index(kind)])
    fit = fit_kind(kind, cloud, config.criterion, rng, config.constraints, config.initial_guess)
    if isinstance(fit, FailedFit):
        return _Try(Attempt(kind, probability, "failed", fit.reason, None, None, None))
    evidence = Evidence.weigh(fit.robust, cloud, Limits.of(config.constraints, kind, cloud.frame))
    error = summarize(fit.primitive, evidence, cloud.points, cloud.diagonal, cloud.frame.scale)
    question = Question(
        config.max_error, _tolerance(config, cloud), len(config.kinds) == 1, config.criterion in COUNTING_ALL
    )
    found = claim(evidence, cloud, probability, error.relative_mean, question)
    attempt = Attempt(
        kind=kind,
        probability=probability,
        outcome="refused" if found.refusal else "accepted",
        reason=found.refusal or found.words,
        primitive=config.constraints.written_into(cloud.frame.restore(fit.primitive.canonical(np.zeros(3)))),
        error=error,
        noise=summarize_noise(evidence, cloud),
    )
    return _Try(attempt, found, fit.primitive)


def _nothing(tries: list[_Try], cloud: Cloud) -> Recognition:
    """The answer where every fit failed."""
    reasons = "; ".join(tried.attempt.reason for tried in tries)
    return Recognition(
        status="no_fit",
        primitive=None,
        alternatives=(),
        error=None,
        noise=None,
        attempts=tuple(tried.attempt for tried in tries),
        message=f"no allowed kind could be fitted: {reasons}",
        n_points=len(cloud.points),
    )


def _answer(decision: Decision, tries: list[_Try], cloud: Cloud, config: Config) -> Recognition:
    tries = [_told(tried, decision) for tried in tries]
    by_kind = {tried.attempt.kind: tried for tried in tries}
    best = by_kind[decision.best.kind]
    primitive = best.attempt.primitive
    assert primitive and best.claim
    evidence = best.claim.evidence
    return Recognition(
        status=decision.status,
        primitive=primitive,
        alternatives=tuple(_alternative(by_kind[rival.kind], cloud, config) for rival in decision.rivals),
        error=best.attempt.error,
        noise=best.attempt.noise,
        attempts=tuple(tried.attempt for tried in tries),
        message=_message(decision),
        n_points=len(cloud.points),
        active_constraints=config.constraints.effects(primitive),
        extents=_extents(best, cloud),
        uncertainty=None if decision.status == "no_fit" else _uncertainty(best, cloud, config),
        inliers=Inliers(cloud.frame.restore(evidence.primitive), cloud.frame.scale * evidence.reach),
    )


def _message(decision: Decision) -> str:
    kind = decision.best.kind
    if decision.status == "no_fit":
        return f"no allowed kind explains the cloud; the best try is a {kind}: {decision.reason}"
    if decision.status == "ambiguous":
        names = " or ".join(each.kind for each in (decision.best, *decision.rivals))
        return f"the cloud may be a {names}: the points do not tell them apart"
    return f"{kind}: {decision.reason}"


def _told(tried: _Try, decision: Decision) -> _Try:
    """The try with what became of it: its evidence beside the best claim's, and why it was refused."""
    if tried.claim is None:
        return tried
    best, evidence = decision.best, None
    if not (tried.claim.evidence.exact.any() or best.evidence.exact.any()):
        evidence = _finite(tried.claim.odds - best.odds)
    attempt = replace(tried.attempt, evidence=evidence)
    chosen = tried.claim is best or tried.claim in decision.rivals
    if not tried.claim.refusal and not (chosen and decision.status != "no_fit"):
        why = decision.reason if chosen else _lost(best, evidence, tried.attempt.reason)
        attempt = replace(attempt, outcome="refused", reason=why)
    return replace(tried, attempt=attempt)


def _finite(odds: float) -> float | None:
    """None for those of a surface that can only be another shape."""
    return odds if np.isfinite(odds) else None


def _lost(best: Claim, evidence: float | None, reason: str) -> str:
    if evidence is None or evidence > 0.0:
        return f"{reason}; a {best.kind} explains the cloud better or more simply"
    return f"{reason}; a {best.kind} is likelier (log odds {-evidence:.1f})"


def _alternative(tried: _Try, cloud: Cloud, config: Config) -> Alternative:
    primitive, error = tried.attempt.primitive, tried.attempt.error
    assert primitive and error
    return Alternative(
        primitive, error, _extents(tried, cloud), _uncertainty(tried, cloud, config), tried.attempt.evidence
    )


def _uncertainty(tried: _Try, cloud: Cloud, config: Config) -> Uncertainty | None:
    assert tried.primitive and tried.claim and tried.attempt.primitive
    return uncertainty_of(
        tried.primitive,
        tried.attempt.primitive,
        tried.claim.evidence,
        cloud,
        config.criterion,
        config.constraints,
    )


def _extents(tried: _Try, cloud: Cloud) -> Extents | None:
    """Those of the answered primitive, from the points that its robust fit did not reject."""
    primitive, claimed = tried.attempt.primitive, tried.claim
    assert primitive and claimed
    evidence = claimed.evidence
    exact = np.count_nonzero(evidence.exact) >= MOSTLY_EXACT * np.count_nonzero(evidence.inlier)
    found = extents_of(
        cloud.frame.bring(primitive),
        cloud.working[evidence.exact if exact else evidence.inlier],
        0.0 if exact else evidence.noise_scale,
    )
    return found and found.restored(cloud.frame)
