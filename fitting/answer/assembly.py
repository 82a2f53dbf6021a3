"""From what was tried and decided to the answer."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..cloud.cloud import Cloud
from ..cloud.frame import Frame
from ..extents import extents_of, has_arcs
from ..extents.values import Extents
from ..plain import worded
from ..primitives import SIZES, is_angle
from ..primitives.primitive import Primitive
from ..request.config import Config
from ..search.finished import Finished
from ..solver.refine import distances
from ..uncertainty.appraise import uncertainty_of
from ..uncertainty.values import Uncertainty
from ..verdict.judge import Claim, Decision
from ..words import figure, listed, sentences
from .conformance import Candidate, Conformance, conformance
from .residuals import InlierRule
from .result import Alternative, Attempt, Outcome, Recognition
from .values import ErrorSummary

MOSTLY_EXACT = 0.9
"""Where so large a share of the inliers is exact, the others do not count for the extents."""


CONTRADICTED, AS_NEAR = 2.0, 1.5
"""Constraints are said to contradict the points where these lie so many times as far from the surface as
without them. Of a kind that is not the answer it is said where without them the points would be no farther
than so many times as from the answer. Words only: no decision asks for them."""


@dataclass(frozen=True, eq=False)
class Failed:
    """A kind that could not be fitted."""

    attempt: Attempt


@dataclass(frozen=True, eq=False)
class Fitted:
    """A kind that was fitted.

    Attributes
    ----------
    claim : its claim on the cloud, by its robust fit
    finished : where the criterion ended, in the frame of the cloud
    answered : the primitive of that in input units, fixed values as they were given
    error : the distances of the points from it
    unlimited : where constraints act, the surface of the kind that the search found without them, in the
        frame of the cloud
    """

    attempt: Attempt
    claim: Claim
    finished: Finished
    answered: Primitive
    error: ErrorSummary
    unlimited: Primitive | None = None


Tried = Fitted | Failed


def nothing(tries: Sequence[Tried], n_points: int, config: Config) -> Recognition:
    """The answer where every fit failed."""
    reasons = (tried.attempt.reason for tried in tries)
    return Recognition(
        status="no_fit",
        primitive=None,
        alternatives=(),
        error=None,
        noise=None,
        attempts=tuple(tried.attempt for tried in tries),
        message=sentences("none of the allowed kinds could be fitted", *reasons),
        n_points=n_points,
        conformance=conformance(config.nominal, config.form_tolerance, ()),
        include=config.include,
        unit=config.unit,
    )


def assemble(decision: Decision, tries: Sequence[Tried], config: Config) -> Recognition:
    """The answer to a cloud."""
    about = next(each for each in tries if isinstance(each, Fitted) and each.claim is decision.about)
    why = _about(about, decision.reason, config)
    told = [_told(tried, decision, why, config) for tried in tries]
    fitted = {each.claim.kind: each for each in told if isinstance(each, Fitted)}
    best = fitted[decision.best.kind]
    evidence = best.claim.evidence
    cloud = evidence.cloud
    extents, uncertainty = _parts(best, config.include, decision.status != "no_fit")
    alternatives = tuple(_alternative(fitted[rival.kind], config) for rival in decision.rivals)
    return Recognition(
        status=decision.status,
        primitive=best.answered,
        alternatives=alternatives,
        error=best.error,
        noise=best.attempt.noise,
        attempts=tuple(tried.attempt for tried in told),
        message=_message(decision, fitted, why, config),
        n_points=len(cloud.points),
        active_constraints=config.constraints.effects(best.answered),
        extents=extents,
        uncertainty=uncertainty,
        conformance=_conformance(decision, best, uncertainty, alternatives, config),
        inlier_rule=InlierRule(cloud.frame.restore(evidence.primitive), cloud.frame.scale * evidence.reach),
        include=config.include,
        unit=config.unit,
    )


def _conformance(
    decision: Decision,
    best: Fitted,
    uncertainty: Uncertainty | None,
    alternatives: tuple[Alternative, ...],
    config: Config,
) -> Conformance | None:
    """The verdict on what was asked for; a kind that was refused conforms to nothing."""
    candidates: list[Candidate] = []
    if decision.status != "no_fit":
        candidates.append(Candidate(best.answered, best.error, uncertainty))
        candidates += [Candidate(each.primitive, each.error, each.uncertainty) for each in alternatives]
    return conformance(config.nominal, config.form_tolerance, candidates)


def _message(decision: Decision, fitted: Mapping[str, Fitted], why: list[str], config: Config) -> str:
    best = fitted[decision.best.kind]
    others = [each for each in fitted.values() if each is not best and _would_do(each, best)]
    contradicted = [clause for each in others for clause in _contradiction(each, config)]
    if decision.status == "ambiguous":
        names = listed([f"a {each.kind}" for each in (decision.best, *decision.rivals)], "or")
        return sentences(f"the points may lie on {names}: they do not tell these apart", *contradicted)
    if decision.status == "fitted":
        return sentences(*why, *contradicted)
    none = f"a {best.claim.kind} does not explain the points"
    if len(config.kinds) > 1:
        none = f"none of the allowed kinds explains the points; the best try is a {best.claim.kind}"
    return sentences(none, *why, *contradicted)


def _about(fitted: Fitted, said: str, config: Config) -> list[str]:
    """What is said about a surface, with the constraints that hold it, in clauses."""
    if contradicted := _contradiction(fitted, config):
        return [said, *contradicted]
    held = config.constraints.holding(fitted.answered, config.unit)
    return [f"with {listed(held.values(), 'and')}, {said}" if held else said]


def _would_do(fitted: Fitted, best: Fitted) -> bool:
    """Whether without its constraints a kind would lie about as near to the points as the best one does."""
    if fitted.unlimited is None:
        return False
    cloud = best.claim.evidence.cloud
    nearest = max(_typical(best.claim.evidence.primitive, cloud), cloud.tolerance)
    return _typical(fitted.unlimited, cloud) <= AS_NEAR * nearest


def _contradiction(fitted: Fitted, config: Config) -> list[str]:
    """That its constraints keep a surface from the points, as a clause, where the search has shown it."""
    held = config.constraints.holding(fitted.answered, config.unit)
    if not held or fitted.unlimited is None:
        return []
    kind, cloud = fitted.claim.kind, fitted.claim.evidence.cloud
    kept, free = (_typical(each, cloud) for each in (fitted.claim.evidence.primitive, fitted.unlimited))
    if kept <= max(CONTRADICTED * free, cloud.tolerance):
        return []
    verb, them = ("contradicts", "it") if len(held) == 1 else ("contradict", "them")
    near = "on" if free <= cloud.tolerance else f"within {cloud.frame.told(free)} of"
    sizes = [_size(fitted.unlimited, name, cloud.frame) for name in held if name in SIZES]
    of = f" with a {listed(sizes, 'and a')}" if sizes else ""
    half = f"half of them would lie {near} a {kind}{of}, not within {cloud.frame.told(kept)}"
    return [f"{listed(held.values(), 'and')} {verb} the points: without {them} {half}"]


def _size(primitive: Primitive, name: str, frame: Frame) -> str:
    """A number of a primitive in its frame, in words: `radius of 5.01 mm`."""
    value = float(getattr(primitive, name))
    told = figure(math.degrees(value), "degrees") if is_angle(name) else frame.told(value)
    return f"{worded(name)} of {told}"


def _typical(primitive: Primitive, cloud: Cloud) -> float:
    """The distance that half of the points are within."""
    return float(np.median(np.abs(distances(primitive, cloud.working[cloud.sample]))))


def _told(tried: Tried, decision: Decision, why: list[str], config: Config) -> Tried:
    """With what became of it: its evidence beside that of the best claim, and why it was refused.

    `why` is the reason of the decision, in clauses.
    """
    if isinstance(tried, Failed):
        return tried
    best, claim, evidence = decision.best, tried.claim, None
    if not (claim.evidence.exact.any() or best.evidence.exact.any()):
        evidence = _finite(claim.odds - best.odds)
    chosen = claim is best or claim in decision.rivals
    accepted = chosen and decision.status != "no_fit"
    clauses = _about(tried, tried.attempt.reason, config)
    if claim is best and not accepted:
        clauses = why if decision.about is best else [*clauses, *why]
    elif not (chosen or claim.refusal):
        clauses.append(_lost(decision, evidence))
    outcome: Outcome = "accepted" if accepted else "refused"
    attempt = replace(tried.attempt, evidence=evidence, outcome=outcome, reason=sentences(*clauses))
    return replace(tried, attempt=attempt)


def _finite(odds: float) -> float | None:
    """None for those of a surface that can only be another shape."""
    return odds if np.isfinite(odds) else None


def _lost(decision: Decision, evidence: float | None) -> str:
    """Why a kind that could be is not the answer."""
    best = f"a {decision.best.kind}"
    if decision.status == "no_fit":
        return f"{best} is the better try"
    if evidence is None or evidence > 0.0:
        return f"{best} explains the points better or more simply"
    return f"{best} is likelier"


def _alternative(fitted: Fitted, config: Config) -> Alternative:
    extents, uncertainty = _parts(fitted, config.include)
    effects = config.constraints.effects(fitted.answered)
    return Alternative(fitted.answered, fitted.error, extents, uncertainty, fitted.attempt.evidence, effects)


def _parts(
    fitted: Fitted, include: Collection[str], known: bool = True
) -> tuple[Extents | None, Uncertainty | None]:
    """The extents and the uncertainty, where they are wanted; the latter only where it can be `known`.

    The warnings of the uncertainty need the arcs of the extents: then these are computed, too, and not told.
    """
    told, known = "extents" in include, known and "uncertainty" in include
    extents = _extents(fitted) if told or (known and has_arcs(fitted.claim.kind)) else None
    uncertainty = None
    if known:
        uncertainty = uncertainty_of(fitted.finished, fitted.answered, fitted.claim.evidence, extents)
    return extents if told else None, uncertainty


def _extents(fitted: Fitted) -> Extents | None:
    """Those of the answered primitive, from the points that its robust fit did not reject."""
    evidence = fitted.claim.evidence
    cloud = evidence.cloud
    exact = np.count_nonzero(evidence.exact) >= MOSTLY_EXACT * np.count_nonzero(evidence.inlier)
    found = extents_of(
        cloud.frame.bring(fitted.answered),
        cloud.working[evidence.exact if exact else evidence.inlier],
        0.0 if exact else evidence.noise_scale,
    )
    return found and found.restored(cloud.frame)
