"""The pipeline: check, normalise, rank, and for each kind guess, refine, judge, until one is accepted."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fitting.appraise import uncertainty_of
from fitting.classifier import Classifier
from fitting.cloud import Cloud
from fitting.config import COUNTING_ALL, EXTREME, Config, takes_no
from fitting.errors import InvalidPointCloudError
from fitting.extents import Extents, extents_of
from fitting.geometry import Array
from fitting.judge import (
    ROUNDING_NOISE,
    STRONG_EVIDENCE,
    Evidence,
    Standing,
    better,
    judge,
    judge_all,
    points_alike,
    summarize,
    summarize_noise,
)
from fitting.limits import Limits, dof_within
from fitting.nesting import intervals
from fitting.primitives import KINDS, PRIMITIVES, Primitive
from fitting.reach import check_reach
from fitting.residuals import Inliers
from fitting.result import Alternative, Attempt, FailedFit, Recognition
from fitting.search import fit_kind
from fitting.uncertainty import Uncertainty

DEFAULT_CONFIG = Config()

DOUBT = 0.02
FEW, FEW_DOUBT = 60, 0.004
"""Kinds whose share of the probability is below the doubt are not held against an acceptable one; it is their
share of what that kind and all that were not tried yet have together. In a cloud of few points, where a
general kind may explain the noise, the lower one holds for simpler kinds."""

MOSTLY_EXACT = 0.9
"""Where so large a share of the inliers is exact, the others do not count for the extents."""


@dataclass(frozen=True)
class _Try:
    """An attempt with the evidence behind it, which is missing where the fit failed."""

    attempt: Attempt
    evidence: Evidence | None = None
    standing: Standing = Standing.REFUSED
    primitive: Primitive | None = None
    """As the criterion has it, in the frame of the cloud."""

    @property
    def acceptable(self) -> bool:
        return self.standing > Standing.SUSPECT


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
    while queue := _worth_trying(ranking, tries, probabilities, len(cloud.working)):
        tries.append(_attempt(queue[0], cloud, config, probabilities))
    nested = _nested(tries, cloud)
    done = {tried.attempt.kind for tried in tries}
    missing = [kind for kind in ranking if kind in nested and kind not in done]
    tries += [_attempt(kind, cloud, config, probabilities) for kind in missing]
    recognition = _conclude(tries, {kind for kind, is_open in nested.items() if is_open}, cloud)
    if recognition.primitive is None:
        return recognition
    return replace(
        recognition,
        active_constraints=config.constraints.effects(recognition.primitive),
        uncertainty=_uncertainty(recognition, tries, cloud, config),
    )


def _check_count(cloud: Cloud, config: Config) -> None:
    """Raise `InvalidPointCloudError` where the points determine none of the kinds."""
    fewest = min(dof_within(kind, Limits.of(config.constraints, kind, cloud.frame)) for kind in config.kinds)
    if len(cloud.points) < fewest:
        kinds = " or ".join(config.kinds)
        within = " within these constraints" if config.constraints.given else ""
        raise InvalidPointCloudError(
            f"{len(cloud.points)} points given; a {kinds}{within} needs at least {fewest}"
        )


def _uncertainty(
    recognition: Recognition, tries: list[_Try], cloud: Cloud, config: Config
) -> Uncertainty | None:
    """Of the answer; a primitive that does not explain the cloud has none."""
    if recognition.status == "no_fit" or recognition.primitive is None:
        return None
    best = next(tried for tried in tries if tried.attempt.primitive is recognition.primitive)
    assert best.primitive and best.evidence
    return uncertainty_of(
        best.primitive, recognition.primitive, best.evidence, cloud, config.criterion, config.constraints
    )


def _worth_trying(
    ranking: list[str], tries: list[_Try], probabilities: Mapping[str, float] | None, n_points: int
) -> list[str]:
    """The kinds, in order, that may explain the cloud better than what was found; `Standing` says which."""
    done = {tried.attempt.kind for tried in tries}
    queue = [kind for kind in ranking if kind not in done]
    acceptable = [tried for tried in tries if tried.acceptable]
    if not probabilities or not acceptable:
        return queue
    best = _best(acceptable)
    assert best.evidence
    primitive = best.evidence.primitive
    nearly = primitive.simpler_kinds(extent=1.0)
    left = probabilities[primitive.kind] + sum(probabilities[kind] for kind in queue)

    def worth(kind: str, probability: float) -> bool:
        simpler = PRIMITIVES[kind].dof < primitive.dof
        doubt = FEW_DOUBT if simpler and n_points < FEW else DOUBT
        probable = probability >= doubt * left or best.standing == Standing.DOUBTFUL
        asked = best.standing < Standing.CLEAR or (simpler and best.standing < Standing.CERTAIN)
        return kind in nearly or (probable and asked)

    return [kind for kind in queue if worth(kind, probabilities[kind])]


def _nested(tries: list[_Try], cloud: Cloud) -> dict[str, bool]:
    """More general kinds than the best try's for which the points speak; True where they leave it open."""
    acceptable = [tried for tried in tries if tried.acceptable]
    if not acceptable:
        return {}
    best = _best(acceptable)
    evidence = best.evidence
    assert evidence
    if best.standing == Standing.CERTAIN or evidence.exact.any():
        return {}
    near, alike = evidence.inlier, points_alike(evidence.correlation)
    scale = max(evidence.noise_scale, ROUNDING_NOISE * evidence.rounding)
    found = intervals(evidence.primitive, cloud.working[near], evidence.distance[near], scale, cloud.extent)
    return {
        kind: any(interval.is_open for interval in ways)
        for kind, ways in found.items()
        if any(interval.is_open or interval.is_significant(alike) for interval in ways)
    }


def _rank(cloud: Cloud, classifier: Classifier) -> Mapping[str, float]:
    return classifier.rank(cloud.working[cloud.sample[: len(cloud.normals)]], cloud.normals)


def _attempt(kind: str, cloud: Cloud, config: Config, probabilities: Mapping[str, float] | None) -> _Try:
    probability = probabilities[kind] if probabilities else None
    rng = np.random.default_rng([config.seed, 1, KINDS.index(kind)])
    fit = fit_kind(kind, cloud, config.criterion, rng, config.constraints, config.initial_guess)
    if isinstance(fit, FailedFit):
        return _Try(Attempt(kind, probability, "failed", fit.reason, None, None, None))
    limits = Limits.of(config.constraints, kind, cloud.frame)
    evidence, only = Evidence.weigh(fit.robust, cloud, limits), len(config.kinds) == 1
    error = summarize(fit.primitive, evidence, cloud.points, cloud.diagonal, cloud.frame.scale)
    if config.criterion in COUNTING_ALL:
        verdict = judge_all(evidence, cloud, error.relative_mean, config.max_error, only)
    else:
        verdict = judge(evidence, cloud, config.max_error, only)
    attempt = Attempt(
        kind=kind,
        probability=probability,
        outcome="accepted" if verdict.standing > Standing.SUSPECT else "refused",
        reason=verdict.reason,
        primitive=config.constraints.written_into(cloud.frame.restore(fit.primitive.canonical(np.zeros(3)))),
        error=error,
        noise=summarize_noise(evidence, cloud),
    )
    return _Try(attempt, evidence, verdict.standing, fit.primitive)


def _conclude(tries: list[_Try], open_kinds: set[str], cloud: Cloud) -> Recognition:
    """Choose among the acceptable tries, or name the best of the others; open kinds compete with it."""
    if any(tried.acceptable for tried in tries):
        tries = [_reconsidered(tried) for tried in tries]
    fits = [tried for tried in tries if tried.evidence]
    acceptable = [tried for tried in fits if tried.acceptable]
    if not fits:
        message = "no allowed kind could be fitted: " + "; ".join(tried.attempt.reason for tried in tries)
        return _recognition("no_fit", None, [], tries, message, cloud)
    best = _best(acceptable or fits)
    if not acceptable:
        name = best.attempt.kind
        message = f"no allowed kind explains the cloud; the best try is a {name}: {best.attempt.reason}"
        return _recognition("no_fit", best, [], tries, message, cloud)
    rivals = [t for t in acceptable if t is not best and _rivals(best, t)]
    rivals += [
        t for t in fits if t.attempt.kind in open_kinds and t not in (best, *rivals) and _equals(best, t)
    ]
    tries = [
        _second(tried, best)
        if tried.acceptable and not any(tried is kept for kept in (best, *rivals))
        else tried
        for tried in tries
    ]
    if rivals:
        names = " or ".join(t.attempt.kind for t in (best, *rivals))
        message = f"the cloud may be a {names}: the points do not tell them apart"
        return _recognition("ambiguous", best, rivals, tries, message, cloud)
    return _recognition("fitted", best, [], tries, f"{best.attempt.kind}: {best.attempt.reason}", cloud)


def _reconsidered(tried: _Try) -> _Try:
    """The try as one that competes if it was only suspect."""
    if tried.standing != Standing.SUSPECT:
        return tried
    return replace(tried, attempt=replace(tried.attempt, outcome="accepted"), standing=Standing.DOUBTFUL)


def _best(candidates: list[_Try]) -> _Try:
    best = candidates[0]
    for tried in candidates[1:]:
        if _advantage(tried, best) > 0.0:
            best = tried
    return best


def _advantage(a: _Try, b: _Try) -> float:
    assert a.evidence and b.evidence
    return better(a.evidence, b.evidence)


def _rivals(best: _Try, other: _Try) -> bool:
    """Whether the better try is no simpler and too little better to be proven."""
    assert best.evidence and other.evidence
    simpler = best.evidence.primitive.dof < other.evidence.primitive.dof
    return not simpler and _advantage(best, other) < STRONG_EVIDENCE


def _equals(best: _Try, other: _Try) -> bool:
    """Whether the other try, of a more general kind, is about as likely as the best."""
    assert best.evidence and other.evidence
    return best.evidence.noise.log_likelihood - other.evidence.noise.log_likelihood < STRONG_EVIDENCE / 2.0


def _second(tried: _Try, best: _Try) -> _Try:
    """The try with its attempt marked as refused because another kind explains the cloud better."""
    advantage = _advantage(best, tried)
    how = f" (BIC lower by {advantage:.0f})" if np.isfinite(advantage) else ""
    reason = f"{tried.attempt.reason}; a {best.attempt.kind} explains the cloud better or more simply{how}"
    return replace(tried, attempt=replace(tried.attempt, outcome="refused", reason=reason))


def _recognition(
    status: str, best: _Try | None, rivals: list[_Try], tries: list[_Try], message: str, cloud: Cloud
) -> Recognition:
    return Recognition(
        status=status,  # type: ignore[arg-type]
        primitive=best.attempt.primitive if best else None,
        alternatives=tuple(_alternative(tried, cloud) for tried in rivals),
        error=best.attempt.error if best else None,
        noise=best.attempt.noise if best else None,
        extents=_extents(best, cloud) if best else None,
        attempts=tuple(tried.attempt for tried in tries),
        message=message,
        n_points=len(cloud.points),
        inliers=_inliers(best, cloud) if best else None,
    )


def _alternative(tried: _Try, cloud: Cloud) -> Alternative:
    primitive, error = tried.attempt.primitive, tried.attempt.error
    assert primitive and error
    return Alternative(primitive, error, _extents(tried, cloud), None, tried.attempt.evidence)


def _inliers(best: _Try, cloud: Cloud) -> Inliers:
    assert best.evidence
    return Inliers(cloud.frame.restore(best.evidence.primitive), cloud.frame.scale * best.evidence.reach)


def _extents(best: _Try, cloud: Cloud) -> Extents | None:
    """Those of the answered primitive, from the points that its robust fit did not reject."""
    primitive, evidence = best.attempt.primitive, best.evidence
    assert primitive and evidence
    exact = np.count_nonzero(evidence.exact) >= MOSTLY_EXACT * np.count_nonzero(evidence.inlier)
    found = extents_of(
        cloud.frame.bring(primitive),
        cloud.working[evidence.exact if exact else evidence.inlier],
        0.0 if exact else evidence.noise_scale,
    )
    return found and found.restored(cloud.frame)
