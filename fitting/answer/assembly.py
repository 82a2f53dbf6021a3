"""From what was tried and decided to the answer."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..extents import extents_of, has_arcs
from ..extents.values import Extents
from ..primitives.primitive import Primitive
from ..request.config import Config
from ..search.finished import Finished
from ..uncertainty.appraise import uncertainty_of
from ..uncertainty.values import Uncertainty
from ..verdict.judge import Claim, Decision
from .residuals import InlierRule
from .result import Alternative, Attempt, Recognition
from .values import ErrorSummary

MOSTLY_EXACT = 0.9
"""Where so large a share of the inliers is exact, the others do not count for the extents."""


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
    """

    attempt: Attempt
    claim: Claim
    finished: Finished
    answered: Primitive
    error: ErrorSummary


Tried = Fitted | Failed


def nothing(tries: Sequence[Tried], n_points: int, config: Config) -> Recognition:
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
        n_points=n_points,
        include=config.include,
    )


def assemble(decision: Decision, tries: Sequence[Tried], config: Config) -> Recognition:
    """The answer to a cloud."""
    told = [_told(tried, decision) for tried in tries]
    fitted = {each.claim.kind: each for each in told if isinstance(each, Fitted)}
    best = fitted[decision.best.kind]
    evidence = best.claim.evidence
    cloud = evidence.cloud
    extents, uncertainty = _parts(best, config.include, decision.status != "no_fit")
    return Recognition(
        status=decision.status,
        primitive=best.answered,
        alternatives=tuple(_alternative(fitted[rival.kind], config.include) for rival in decision.rivals),
        error=best.error,
        noise=best.attempt.noise,
        attempts=tuple(tried.attempt for tried in told),
        message=_message(decision),
        n_points=len(cloud.points),
        active_constraints=config.constraints.effects(best.answered),
        extents=extents,
        uncertainty=uncertainty,
        inlier_rule=InlierRule(cloud.frame.restore(evidence.primitive), cloud.frame.scale * evidence.reach),
        include=config.include,
    )


def _message(decision: Decision) -> str:
    kind = decision.best.kind
    if decision.status == "no_fit":
        return f"no allowed kind explains the cloud; the best try is a {kind}: {decision.reason}"
    if decision.status == "ambiguous":
        names = " or ".join(each.kind for each in (decision.best, *decision.rivals))
        return f"the cloud may be a {names}: the points do not tell them apart"
    return f"{kind}: {decision.reason}"


def _told(tried: Tried, decision: Decision) -> Tried:
    """With what became of it: its evidence beside that of the best claim, and why it was refused."""
    if isinstance(tried, Failed):
        return tried
    best, claim, evidence = decision.best, tried.claim, None
    if not (claim.evidence.exact.any() or best.evidence.exact.any()):
        evidence = _finite(claim.odds - best.odds)
    attempt = replace(tried.attempt, evidence=evidence)
    chosen = claim is best or claim in decision.rivals
    if not claim.refusal and not (chosen and decision.status != "no_fit"):
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


def _alternative(fitted: Fitted, include: Collection[str]) -> Alternative:
    return Alternative(fitted.answered, fitted.error, *_parts(fitted, include), fitted.attempt.evidence)


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
