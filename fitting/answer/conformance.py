"""Whether what was measured is what it should be: form and parameters held against their tolerances.

The rule is that of ISO 14253-1: a deviation conforms if its whole 95% interval lies within the tolerance,
and does not if the interval lies outside; in between nothing is proven.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np

from ..geometry.vectors import Array, unit
from ..names import KindName
from ..primitives import DIRECTIONS, VECTORS, direction_of, parameters
from ..primitives.primitive import Primitive
from ..request.nominal import Nominal, Target
from ..uncertainty.values import Interval, Uncertainty
from ..uncertainty.warnings import MOST_TURNED
from .values import ErrorSummary

Verdict = Literal["within", "beyond", "undecided"]
Ends = tuple[float, float]


@dataclass(frozen=True)
class Check:
    """One quantity beside what it should be.

    Attributes
    ----------
    name : `form`, or a parameter
    nominal : what it should be; 0 of the form error
    measured : what it is
    deviation : of a number measured less nominal; of a direction the angle [rad] up to sign; of a position
        the distance, of a `point` that across the axis or plane
    low, high : 95% interval of the deviation; None where it is not known, or not bounded
    lower, upper : deviations that are allowed; None where no tolerance was given
    verdict : `within`, `beyond`, or `undecided` where the interval reaches over a limit; None without a
        tolerance

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> nominal = {"kind": "sphere", "radius": {"value": 2.1, "tolerance": 0.05}}
    >>> found = primfit.fit(points, nominal=nominal).conformance
    >>> found.checks[0].name, round(found.checks[0].deviation, 9), found.checks[0].verdict
    ('radius', -0.1, 'beyond')
    """

    name: str
    nominal: float | tuple[float, ...]
    measured: float | tuple[float, ...]
    deviation: float
    low: float | None
    high: float | None
    lower: float | None
    upper: float | None
    verdict: Verdict | None


@dataclass(frozen=True)
class Conformance:
    """What was measured beside what was asked for.

    Attributes
    ----------
    verdict : `beyond` if one of the checks is, or the kind is another one or none; else `undecided` if one
        is, else `within`; None where no tolerance was given
    kind : whose parameters are compared
    checks : the form first, then the parameters

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> nominal = {"kind": "sphere", "radius": {"value": 2.1, "tolerance": 0.05}}
    >>> found = primfit.fit(points, nominal=nominal).conformance
    >>> found.verdict, found.kind, len(found.checks)
    ('beyond', 'sphere', 1)
    """

    verdict: Verdict | None
    kind: KindName | None
    checks: tuple[Check, ...]


@dataclass(frozen=True, eq=False)
class Candidate:
    """A primitive of the answer, with its error and, where it is known, its uncertainty."""

    primitive: Primitive
    error: ErrorSummary
    uncertainty: Uncertainty | None


def conformance(
    nominal: Nominal | None, form_tolerance: float | None, candidates: Sequence[Candidate]
) -> Conformance | None:
    """The verdict on an answer; None where nothing was asked for.

    Parameters
    ----------
    form_tolerance : largest form error allowed [length], or None
    candidates : the primitives of the answer, the likeliest first; none with `no_fit`
    """
    if nominal is None and form_tolerance is None:
        return None
    wanted = [each for each in candidates if nominal is None or each.primitive.kind == nominal.kind]
    if not wanted:
        return Conformance("beyond", None, ())
    found = wanted[0]
    checks = [] if form_tolerance is None else [_form(found.error.inlier_zone, form_tolerance)]
    checks += _parameters(found, nominal) if nominal else []
    return Conformance(
        _worst([check.verdict for check in checks]), cast(KindName, found.primitive.kind), tuple(checks)
    )


def _worst(verdicts: Sequence[Verdict | None]) -> Verdict | None:
    order: tuple[Verdict, ...] = ("beyond", "undecided", "within")
    return next((verdict for verdict in order if verdict in verdicts), None)


def _form(zone: float, tolerance: float) -> Check:
    verdict = _verdict((zone, zone), 0.0, tolerance)
    return Check("form", 0.0, zone, zone, None, None, 0.0, tolerance, verdict)


def _parameters(found: Candidate, nominal: Nominal) -> Iterator[Check]:
    measured = parameters(found.primitive)
    for name, target in nominal.targets.items():
        deviation = _deviation(found.primitive, name, target)
        ends = _ends(found, name, target, deviation)
        value: Any = measured[name]
        yield Check(
            name=name,
            nominal=target.value,
            measured=tuple(value) if isinstance(value, list) else value,
            deviation=deviation,
            low=None if ends is None else _finite(ends[0]),
            high=None if ends is None else _finite(ends[1]),
            lower=target.lower,
            upper=target.upper,
            verdict=_verdict(ends or (deviation, deviation), target.lower, target.upper),
        )


def _deviation(primitive: Primitive, name: str, target: Target) -> float:
    value, wanted = getattr(primitive, name), target.value
    if name not in VECTORS:
        return float(value) - float(wanted)  # type: ignore[arg-type]
    if name in DIRECTIONS:
        toward = unit(np.asarray(wanted))
        across = np.linalg.norm(np.cross(value, toward))
        return math.atan2(float(across), abs(float(value @ toward)))
    if name != "point":
        return float(np.linalg.norm(np.asarray(wanted) - value))
    return _across_and_along(primitive, target)[0]


def _across_and_along(primitive: Primitive, target: Target) -> tuple[float, float]:
    """How far a nominal `point` is from the measured one across an axis or a plane, and how far along it."""
    name = str(direction_of(primitive.kind))
    direction: Array = getattr(primitive, name)
    off: Array = np.asarray(target.value) - primitive.point  # type: ignore[attr-defined]
    height = float(off @ direction)
    beside = float(np.linalg.norm(off - height * direction))
    return (abs(height), beside) if name == "normal" else (beside, abs(height))


def _ends(found: Candidate, name: str, target: Target, deviation: float) -> Ends | None:
    """The 95% interval of a deviation, infinite where the points do not bound it; None if it is not known."""
    known = found.uncertainty
    if known is None:
        return None
    if name in VECTORS:
        reach = _reach(found.primitive, known, name, target)
        return None if reach is None else (max(0.0, deviation - reach), deviation + reach)
    if name not in known.intervals:
        return None
    interval, value = known.intervals[name], float(getattr(found.primitive, name))
    low = -math.inf if interval.low is None else deviation + interval.low - value
    return low, math.inf if interval.high is None else deviation + interval.high - value


def _reach(primitive: Primitive, known: Uncertainty, name: str, target: Target) -> float | None:
    """How far off a direction or position may be in 95 of 100 cases."""
    if name in DIRECTIONS:
        return None if known.direction is None else known.direction.radius_95
    if name == "point":
        return _reach_of_point(primitive, known, target)
    halves = [
        _longer_half(float(value), known.intervals.get(f"{name}.{letter}"))
        for letter, value in zip("xyz", getattr(primitive, name), strict=True)
    ]
    return None if None in halves else math.hypot(*cast(list[float], halves))


def _reach_of_point(primitive: Primitive, known: Uncertainty, target: Target) -> float | None:
    """That of the position, and of the direction where the nominal point is far from the measured one.

    An axis turns about the middle of its points: where these are far away, it is known less well.
    """
    if known.position is None or known.direction is None:
        return None
    turned = known.direction.radius_95
    lever = _across_and_along(primitive, target)[1]
    swing = math.inf if turned >= MOST_TURNED else lever * math.tan(turned)
    return math.hypot(known.position.radius_95, swing)


def _longer_half(value: float, interval: Interval | None) -> float | None:
    """Of the interval of a coordinate, infinite where an end is open; None if it is not known."""
    if interval is None:
        return None
    if interval.low is None or interval.high is None:
        return math.inf
    return max(value - interval.low, interval.high - value)


def _finite(end: float) -> float | None:
    return end if math.isfinite(end) else None


def _verdict(ends: Ends, lower: float | None, upper: float | None) -> Verdict | None:
    """Of the interval of a deviation."""
    if lower is None or upper is None:
        return None
    if lower <= ends[0] and ends[1] <= upper:
        return "within"
    return "beyond" if ends[0] > upper or ends[1] < lower else "undecided"
