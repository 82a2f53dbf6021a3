"""How far one number of a surface may go before the points object, the others following: a profile.

On short arcs the interval of a radius is not symmetric: much larger ones fit nearly as well, and much
smaller ones do not.
Source: Bates and Watts, "Nonlinear regression analysis and its applications", 1988, section 6.1.
"""

from dataclasses import dataclass

import numpy as np

from fitting.geometry import Array
from fitting.kernels import Kernel
from fitting.limits import Limits
from fitting.primitives import PRIMITIVES, Primitive
from fitting.refine import refine

ROUNDS = 12
CLOSE = 0.01
"""An end is found when the root of the rise of the cost is this close to what is asked, relatively."""

FLATTEST = 1e-3
"""An end beyond which the curvature is this share of what was found, or an angle that close to its limits, is
not bounded by the points."""


@dataclass(frozen=True, eq=False)
class Cost:
    """The cost of a surface and what it is a sum over; limits are those that hold anyhow."""

    points: Array
    kernel: Kernel
    scale: float
    factors: Array | None
    limits: Limits | None

    def of(self, primitive: Primitive) -> float:
        distance = primitive.signed_distance(self.points)
        if self.factors is not None:
            distance = self.factors * distance
        return float(self.kernel.rho((distance / self.scale) ** 2).sum())


@dataclass(frozen=True)
class Path:
    """The surfaces at the two ends of the profile of a number; None where the points do not end it."""

    low: Primitive | None
    high: Primitive | None


def path_of(
    primitive: Primitive, name: str, deviation: float, quantile: float, rise: float, cost: Cost
) -> Path:
    """The profile of a number to where the cost has risen.

    Parameters
    ----------
    primitive : the optimum
    name : of the number, a radius or half-angle
    deviation : its standard deviation by linearisation
    quantile : of the interval, in standard deviations
    rise : of the cost at its ends
    """
    follow = _Follower(primitive, name, cost)
    step = quantile * follow.deviation(deviation)
    ends = [_end(follow, sign * step, float(np.sqrt(rise))) for sign in (-1.0, 1.0)]
    return Path(*(ends if name == "half_angle" else ends[::-1]))


class _Follower:
    """The surface by a coordinate in which its cost is nearly a parabola: 1 / r of a radius, a half-angle."""

    def __init__(self, primitive: Primitive, name: str, cost: Cost) -> None:
        self.start, self.name, self.cost = primitive, name, cost
        self.least = cost.of(primitive)
        value = getattr(primitive, name)
        self.middle = value if name == "half_angle" else 1.0 / value
        self.lowest = FLATTEST * (1.0 if name == "half_angle" else self.middle)
        self.highest = np.pi / 2 - FLATTEST if name == "half_angle" else np.inf
        self.limits = cost.limits or Limits.free(primitive.kind)

    def deviation(self, of_number: float) -> float:
        return of_number if self.name == "half_angle" else of_number * self.middle**2

    def at(self, coordinate: float, near: Primitive) -> tuple[Primitive, float]:
        """The best surface there, and the root of the rise of its cost."""
        value = coordinate if self.name == "half_angle" else 1.0 / coordinate
        limits = self.limits.holding(self.name, value)
        kind, cost = near.kind, self.cost
        start = PRIMITIVES[kind].from_row(limits.impose(near.row(), cost.points))
        found = refine(start, cost.points, cost.kernel, cost.scale, factors=cost.factors, limits=limits)
        return found.primitive, float(np.sqrt(max(found.cost - self.least, 0.0)))


def _end(follow: _Follower, step: float, target: float) -> Primitive | None:
    """Where the root of the rise is what is asked, by the secant method; None where it never is."""
    near, before, reached = follow.start, follow.middle, 0.0
    coordinate = follow.middle + step
    for _ in range(ROUNDS):
        coordinate = min(max(coordinate, follow.lowest), follow.highest)
        near, root = follow.at(coordinate, near)
        if root <= (1.0 + CLOSE) * target and coordinate in (follow.lowest, follow.highest):
            return None
        if abs(root - target) <= CLOSE * target:
            return near
        slope = (root - reached) / (coordinate - before) if coordinate != before else 0.0
        before, reached = coordinate, root
        move = (target - root) / slope if slope * step > 0.0 else step
        coordinate += float(np.clip(move, -abs(step), abs(step)))
    return near
