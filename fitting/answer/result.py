"""What `recognize` hands back: values, never exceptions, for every expected outcome."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import orjson

from ..extents.values import Extents
from ..names import ANSWER_PARTS, Unit
from ..plain import plain
from ..primitives import parameters
from ..primitives.primitive import Primitive
from ..uncertainty.values import Uncertainty
from ..verdict.judge import Status
from .conformance import Conformance
from .residuals import Inliers
from .summary import summary
from .values import ErrorSummary, NoiseSummary

Outcome = Literal["accepted", "refused", "failed"]


@dataclass(frozen=True)
class Attempt:
    """One kind that was tried: what it reached and why it was accepted, refused, or failed.

    Attributes
    ----------
    reason : why, in sentences
    probability : what the classifier gave it; None where it was not asked
    evidence : natural logarithm of the kind's probability over that of the best kind: 0 for that one,
        negative for the others, but for those refused by themselves or equal within `tolerance`; None if the
        kind was not weighed
    """

    kind: str
    probability: float | None
    outcome: Outcome
    reason: str
    primitive: Primitive | None
    error: ErrorSummary | None
    noise: NoiseSummary | None
    evidence: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values, as in `attempts` of the body of `POST /fit`."""
        return {
            "kind": self.kind,
            "probability": plain(self.probability),
            "outcome": self.outcome,
            "reason": self.reason,
            "primitive": self.primitive and parameters(self.primitive),
            "error": plain(self.error),
            "noise": plain(self.noise),
            "evidence": plain(self.evidence),
        }


@dataclass(frozen=True)
class Alternative:
    """Another kind that explains an ambiguous cloud, too.

    Attributes
    ----------
    extents : where it begins and ends; None if its points span no surface, or where they were not asked for
    uncertainty : how well its parameters are known; None where that was not asked for
    evidence : natural logarithm of its probability over that of the best kind, as in its attempt: 0 for that
        one, negative for the others, but for those refused by themselves or equal within `tolerance`; None if
        the kind was not weighed
    """

    primitive: Primitive
    error: ErrorSummary
    extents: Extents | None
    uncertainty: Uncertainty | None
    evidence: float | None

    def to_dict(self) -> dict[str, Any]:
        """The parameters, with what stands beside `primitive` in the answer."""
        return {
            **parameters(self.primitive),
            "error": plain(self.error),
            "extents": self.extents and self.extents.values(),
            "uncertainty": plain(self.uncertainty),
            "evidence": plain(self.evidence),
        }


@dataclass(frozen=True)
class Recognition:
    """The answer for one cloud; `print` shows it in words and aligned numbers.

    Attributes
    ----------
    status : `fitted`; `ambiguous`: `alternatives` explain the cloud as well; `no_fit`: nothing is good enough
    primitive : the accepted one; the first of several of an `ambiguous` cloud, the best try with `no_fit`,
        and None only if every attempt failed
    alternatives : the other kinds that explain an `ambiguous` cloud, the likelier first: of each its
        parameters, error, extents, uncertainty and evidence
    attempts : every kind that was tried, in order
    message : the status in sentences, with lengths in the unit of the input; for people, as texts may change
    active_constraints : how each constraint acts on `primitive`, by its name: `at its upper bound 5.0`, or
        `not applicable: a plane has no radius` where its kind has no such parameter
    extents : where `primitive` begins and ends; None without one, if its points span no surface, or where
        they were not asked for (`include`)
    uncertainty : how well `primitive` is known; None with `no_fit`, and with `minimum_zone`,
        `minimum_circumscribed` and `maximum_inscribed`, or where it was not asked for (`include`)
    conformance : `form_tolerance` and `nominal` held against what was found; None where neither was given
    inliers : which points belong to `primitive`; None without one
    include : which of the parts `extents` and `uncertainty` were asked for
    warnings : what to know of the points, as that some are missing, a sentence each
    unit : of all lengths, where it is known
    """

    status: Status
    primitive: Primitive | None
    alternatives: tuple[Alternative, ...]
    error: ErrorSummary | None
    noise: NoiseSummary | None
    attempts: tuple[Attempt, ...]
    message: str
    n_points: int
    active_constraints: Mapping[str, str] = field(default_factory=dict)
    extents: Extents | None = None
    uncertainty: Uncertainty | None = None
    conformance: Conformance | None = None
    inliers: Inliers | None = None
    include: tuple[str, ...] = ANSWER_PARTS
    warnings: tuple[str, ...] = ()
    unit: Unit | None = None

    def to_dict(self) -> dict[str, Any]:
        """Plain values: the body of `POST /fit` without its receipt."""
        return {
            "status": self.status,
            "primitive": self.primitive and parameters(self.primitive),
            "alternatives": [other.to_dict() for other in self.alternatives],
            "message": self.message,
            "warnings": list(self.warnings),
            "extents": self.extents and self.extents.values(),
            "uncertainty": plain(self.uncertainty),
            "error": plain(self.error),
            "noise": plain(self.noise),
            "active_constraints": dict(self.active_constraints),
            "conformance": plain(self.conformance),
            "attempts": [attempt.to_dict() for attempt in self.attempts],
        }

    def to_json(self) -> str:
        """`to_dict` in one line of JSON; numbers read back to the same float64."""
        return orjson.dumps(self.to_dict()).decode()

    def __str__(self) -> str:
        return summary(self.to_dict() | {"receipt": {"n_points": self.n_points, "unit": self.unit}})

    def __repr__(self) -> str:
        found = (self.primitive, *(other.primitive for other in self.alternatives))
        kinds = " or ".join(each.kind for each in found if each)
        best = "best try " if kinds and self.status == "no_fit" else ""
        said = [self.status, best + kinds, f"{self.n_points} points"]
        return f"<Recognition: {', '.join(filter(None, said))}>"
