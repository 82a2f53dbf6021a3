"""What to beware of in an answer, in words with the figures in them."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..plain import worded
from ..primitives import direction_of, is_angle
from ..words import between, digits, figure, sentences

WarningCode = Literal[
    "minimal_sample",
    "undetermined",
    "few_points",
    "short_arc",
    "one_sided",
    "weak_axis",
    "weak_size",
    "correlated_noise",
]

SHORT_ARC, HALF_TURN = 60.0, 180.0
"""Degrees of arc below which a curved surface is weakly determined, and below which one side is missing."""

WEAK_AXIS = np.radians(2.0)
"""Half-width of the 95% cone about an axis or normal [rad] beyond which it is weakly determined."""

MOST_TURNED = float(np.pi / 2)
"""Largest half-width of that cone: an axis or normal that is a right angle off is not determined."""

WEAK_SIZE = 0.1
"""Half-width of the 95% interval of a radius or half-angle beyond which it is, as a share of its value."""

Ends = tuple[float | None, float | None]


@dataclass(frozen=True)
class Warning:
    """One thing to beware of."""

    code: WarningCode
    message: str


@dataclass(frozen=True)
class Findings:
    """What the warnings are about.

    Attributes
    ----------
    kind : of the answer
    n_points, dof : points that were counted, and parameters that are not held
    determined : the points leave none of its numbers open
    few : fewer than are needed to reject any of them
    arcs : degrees that they cover, by how they are counted
    sizes : 95% intervals of the sizes that are not held, with the values between their ends
    axis_95 : half-width of the cone about the axis [rad], or None
    correlation_length, effective_points : of correlated noise, or None
    unit : name of the unit of length, where one is known
    """

    kind: str
    n_points: int
    dof: int
    determined: bool
    few: bool
    arcs: Mapping[str, float]
    sizes: Mapping[str, tuple[float, Ends]]
    axis_95: float | None
    correlation_length: float | None
    effective_points: float
    unit: str | None


def warnings_of(found: Findings) -> tuple[Warning, ...]:
    """All that apply, the gravest first."""
    told = (*_points(found), *_arcs(found), *_sizes(found), *_axis(found), *_correlation(found))
    return tuple(Warning(code, sentences(clause)) for code, clause in told)


Told = Iterator[tuple[WarningCode, str]]
"""Codes and clauses."""


def _points(found: Findings) -> Told:
    if found.n_points <= found.dof:
        none_left = "leave none to estimate the noise from, so its uncertainty is unknown"
        yield "minimal_sample", f"{found.n_points} points determine the {found.kind} and {none_left}"
    elif not found.determined:
        simpler = "a simpler kind explains them as well, so there are no intervals"
        yield "undetermined", f"the points do not determine all parameters of the {found.kind}: {simpler}"
    elif found.few:
        left = f"the noise is estimated from {found.n_points - found.dof} degrees of freedom"
        counted = f"there are {found.n_points} points for {found.dof} free parameters"
        yield "few_points", f"{counted}: {left}, and no point is rejected as an outlier"


def _arcs(found: Findings) -> Told:
    for counted, degrees in found.arcs.items():
        where = "a cap" if counted == "cap" else "an arc"
        seen = f"the points cover {where} of {degrees:.0f} degrees" + (
            "" if counted == "cap" else f" {counted}"
        )
        if degrees < SHORT_ARC:
            known = [f"{worded(name)} {_range(name, found)}" for name in found.sizes]
            told = f" ({', '.join(known)})" if known else ""
            yield "short_arc", f"{seen} only, so the curvature is weakly determined{told}"
        elif degrees < HALF_TURN:
            yield "one_sided", f"{seen} only, so errors of size and position go together"


def _sizes(found: Findings) -> Told:
    for name, (value, (low, high)) in found.sizes.items():
        if low is None or high is None or max(high - value, value - low) > WEAK_SIZE * value:
            yield "weak_size", f"the {worded(name)} is weakly determined: {_range(name, found)}"


def _axis(found: Findings) -> Told:
    if found.axis_95 is not None and found.axis_95 > WEAK_AXIS:
        within = f"known to within {digits(float(np.degrees(found.axis_95)), 2)} degrees only"
        told = "not determined" if found.axis_95 >= MOST_TURNED else within
        yield "weak_axis", f"the {direction_of(found.kind)} is {told}"


def _correlation(found: Findings) -> Told:
    if found.correlation_length is not None:
        span = figure(found.correlation_length, found.unit)
        n_alone = round(found.effective_points)
        alone = f"{n_alone:,} independent ones" if n_alone > 1 else "one alone"
        equal = f"{found.n_points:,} points tell no more than {alone}"
        yield "correlated_noise", f"neighboring points deviate alike over about {span}: {equal}"


def _range(name: str, found: Findings) -> str:
    """The interval of a size, of an angle in degrees."""
    ends = found.sizes[name][1]
    if is_angle(name):
        low, high = (None if end is None else math.degrees(end) for end in ends)
        return between(low, high, "degrees")
    return between(*ends, found.unit)
