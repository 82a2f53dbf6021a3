"""What to beware of in an answer, in words with the figures in them."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..plain import worded
from ..primitives import direction_of

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
"""Half-width of the 95 % cone about an axis or normal [rad] beyond which it is weakly determined."""

MOST_TURNED = float(np.pi / 2)
"""Largest half-width of that cone: an axis or normal that is a right angle off is not determined."""

WEAK_SIZE = 0.1
"""Half-width of the 95 % interval of a radius or half-angle beyond which it is, as a share of its value."""

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
    sizes : 95 % intervals of the sizes that are not held, with the values between their ends
    axis_95 : half-width of the cone about the axis [rad], or None
    correlation_length, effective_points : of correlated noise, or None
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


def warnings_of(found: Findings) -> tuple[Warning, ...]:
    """All that apply, the gravest first."""
    return (
        *_points(found),
        *_arcs(found),
        *_sizes(found),
        *_axis(found),
        *_correlation(found),
    )


def _points(found: Findings) -> Iterator[Warning]:
    if found.n_points <= found.dof:
        message = (
            f"{found.n_points} points determine the {found.kind} and leave none to tell the noise from: "
            "nothing is known of its uncertainty"
        )
        yield Warning("minimal_sample", message)
    elif not found.determined:
        yield Warning(
            "undetermined", f"the points leave the {found.kind} open: its numbers have no intervals"
        )
    elif found.few:
        message = (
            f"{found.n_points} points for {found.dof} parameters: the noise is estimated from "
            f"{found.n_points - found.dof} degrees of freedom, and no point is rejected as an outlier"
        )
        yield Warning("few_points", message)


def _arcs(found: Findings) -> Iterator[Warning]:
    for counted, degrees in found.arcs.items():
        where = "a cap" if counted == "cap" else "an arc"
        seen = f"the points cover {where} of {degrees:.0f} degrees"
        seen += "" if counted == "cap" else f" {counted}"
        if degrees < SHORT_ARC:
            told = "; ".join(f"{worded(name)} {_range(ends)}" for name, (_, ends) in found.sizes.items())
            weakly = "its curvature there is weakly determined"
            yield Warning("short_arc", f"{seen}: {weakly}" + (f" ({told})" if told else ""))
        elif degrees < HALF_TURN:
            yield Warning("one_sided", f"{seen}: its sizes and its position depend on each other")


def _sizes(found: Findings) -> Iterator[Warning]:
    for name, (value, (low, high)) in found.sizes.items():
        if low is None or high is None or max(high - value, value - low) > WEAK_SIZE * value:
            yield Warning("weak_size", f"the {worded(name)} is weakly determined: {_range((low, high))}")


def _axis(found: Findings) -> Iterator[Warning]:
    if found.axis_95 is not None and found.axis_95 > WEAK_AXIS:
        name = direction_of(found.kind)
        within = f"known to within {np.degrees(found.axis_95):.2g} degrees only"
        told = "not determined" if found.axis_95 >= MOST_TURNED else within
        yield Warning("weak_axis", f"the {name} is {told}")


def _correlation(found: Findings) -> Iterator[Warning]:
    if found.correlation_length is not None:
        message = (
            f"the noise of neighbours agrees over about {found.correlation_length:.3g}: {found.n_points:,} "
            f"points tell as much as {found.effective_points:,.0f} with independent noise"
        )
        yield Warning("correlated_noise", message)


def _range(ends: Ends) -> str:
    low, high = ends
    if low is None:
        return "not bounded at all" if high is None else f"at most {high:.3g}"
    return f"at least {low:.3g}" if high is None else f"{low:.3g} to {high:.3g}"
