"""95% intervals of the numbers of an answer, and of its direction and position."""

from dataclasses import dataclass, replace
from math import hypot, sqrt
from typing import Self

import numpy as np

from ..geometry.vectors import Array, basis
from ..primitives import direction_of as name_of_direction
from ..primitives import parameters_of
from ..primitives.primitive import Primitive
from . import _profile
from .covariance import StepCovariance
from .optimum import Optimum
from .values import Interval, Spread
from .warnings import MOST_TURNED

CURVED = 0.05
"""Half-width of the linearized interval of a radius or half-angle, as a share of its value, from which all
numbers are profiled: a radius is one over a curvature, so the second-order term is as large a share of the
first. The same for the tip of a cone along its axis, as a share of the height at which the points begin."""

HELD = 1e-9
"""A standard deviation of this share of the largest one, both in the frame, is rounding: the number is
held."""

ONE_SIDED = 0.84
"""Quantile of a one-sided 95% interval over that of a two-sided one (1.645 / 1.960)."""

RATIOS = np.linspace(0.0, 1.0, 11)
CIRCLES = (1.9600, 1.9625, 1.9704, 1.9842, 2.0051, 2.0359, 2.0813, 2.1460, 2.2303, 2.3318, 2.4477)
"""Radii of the circles that hold 95% of a normal law in two dimensions, in its larger standard deviation, by
the smaller over the larger one."""


@dataclass(frozen=True, eq=False)
class Profiles:
    """Ends of the profiles of numbers of an optimum, each looked for from the farthest surface seen so far.

    The cost there has risen by  1/2 (q s)^2 / (A^-1)_gg  for a number g, which is what noise that is
    correlated, uneven or cut off by a kernel makes of half a squared quantile q.
    """

    optimum: Optimum
    steps: StepCovariance
    quantile: float
    region: _profile.Region

    @classmethod
    def of(cls, optimum: Optimum, steps: StepCovariance) -> Self | None:
        """None where linearized intervals are near enough."""
        quantile = optimum.quantile(steps)
        if optimum.exact or not _is_curved(optimum, steps, quantile):
            return None
        profiles = cls(optimum, steps, quantile, optimum.region())
        profiles._look_around()
        return profiles

    def _look_around(self) -> None:
        """Ends of the sizes, and of positions along their least certain directions."""
        by_step = self.optimum.numbers[1]
        covariance = by_step @ self.steps.matrix @ by_step.T
        for numbers in self.optimum.layout.vectors:
            among = covariance[numbers, numbers]
            if among.max() > 0.0:
                weights = np.zeros(len(covariance))
                weights[numbers] = np.linalg.eigh(among)[1][:, -1] if len(among) > 1 else 1.0
                self.ends(weights)

    def ends(self, weights: Array) -> tuple[Array | None, Array | None]:
        """The numbers (P,), in the frame of the steps, where their sum with these weights (P,) is least, and
        where it is largest; None for an open end."""
        row = weights @ self.optimum.numbers[1]
        variance, bread = float(row @ self.steps.matrix @ row), float(row @ self.steps.bread @ row)
        noise = max(variance / bread, self.steps.noise**2) / self.optimum.copies
        rise = 0.5 * self.quantile**2 * noise / self.optimum.cost.scale**2
        return self.region.ends(weights, self.quantile * sqrt(variance), rise)


def _is_curved(optimum: Optimum, steps: StepCovariance, quantile: float) -> bool:
    """Whether the second-order term of a number matters."""
    values, by_step = optimum.numbers
    half = quantile * np.sqrt(np.maximum(np.sum((by_step @ steps.matrix) * by_step, axis=1), 0.0))
    if any(half[i] > CURVED * values[i] for i in optimum.layout.sizes):
        return True
    found = optimum.primitive.most_curved(optimum.full.feet.T)
    if found is None:
        return False
    weights, length = found
    along = weights @ by_step
    return bool(quantile * np.sqrt(along @ steps.matrix @ along) > CURVED * length)


def intervals_of(
    optimum: Optimum, values: Array, covariance: Array, quantile: float, profiles: Profiles | None
) -> dict[str, Interval]:
    """By name, of all numbers (P,) but the components of a direction."""
    deviations = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
    in_frame = deviations / optimum.units
    held = in_frame <= HELD * in_frame.max()
    found, layout = {}, optimum.layout
    for i in (i for numbers in layout.vectors for i in range(numbers.start, numbers.stop)):
        name, value, deviation = layout.names[i], float(values[i]), float(deviations[i])
        if held[i]:
            found[name] = Interval(value, value, 0.0, "held")
        elif profiles is None:
            reach = quantile * deviation
            found[name] = Interval(value - reach, value + reach, deviation, "linear")
        else:
            ends = profiles.ends(np.eye(len(values))[i])
            low, high = (None if end is None else float(optimum.given(end)[i]) for end in ends)
            found[name] = Interval(low, high, deviation, "profile")
    return found | _at_bounds(optimum, values, quantile)


def _at_bounds(optimum: Optimum, values: Array, quantile: float) -> dict[str, Interval]:
    """One-sided intervals of the sizes that stand at a bound, from what they would vary by without it."""
    found: dict[str, Interval] = {}
    if optimum.limits is None:
        return found
    for name, (fixed, upper) in optimum.limits.active(optimum.row).items():
        steps = None if fixed else optimum.released(name)
        if steps is None:
            continue
        place = optimum.layout.names.index(name)
        row, value = optimum.by_step[place], float(values[place])
        deviation = sqrt(row @ steps.matrix @ row)
        reach = ONE_SIDED * quantile * deviation
        ends = (max(value - reach, 0.0), value) if upper else (value, value + reach)
        found[name] = Interval(*ends, deviation, "bound")
    return found


def direction_of(
    optimum: Optimum, steps: StepCovariance, quantile: float, profiles: Profiles | None
) -> Spread | None:
    """Of the axis or normal, which has no sign and is a right angle off at most; a sphere has none."""
    if not optimum.primitive.chart.tilts:
        return None
    found = spread(steps.matrix[:2, :2], quantile)
    if profiles is not None and found.standard_deviations[0] > 0.0:
        found = _widened(found, optimum, steps, quantile, profiles)
    return replace(found, radius_95=min(found.radius_95, MOST_TURNED))


def _widened(
    found: Spread, optimum: Optimum, steps: StepCovariance, quantile: float, profiles: Profiles
) -> Spread:
    """The spread of a direction, wider by as much as its profile along its larger principal direction.

    One open end tells nothing: a cone that may be a cylinder turns on beyond it, with its apex at the other
    side.
    """
    first, direction = optimum.layout.direction, optimum.row[:3]
    assert first is not None
    weights = np.zeros(len(optimum.layout.names))
    weights[first : first + 3] = np.linalg.eigh(steps.matrix[:2, :2])[1][:, -1] @ np.array(basis(direction))
    if all(end is None for end in profiles.ends(weights)):
        return replace(found, radius_95=MOST_TURNED)
    cosines = np.abs(profiles.region.rows[:, :3] @ direction)
    angle = float(np.arccos(np.minimum(cosines, 1.0)).max())
    wider = max(1.0, angle / (quantile * found.standard_deviations[0]))
    return replace(found, radius_95=wider * found.radius_95)


def position_of(
    answer: Primitive, names: tuple[str, ...], covariance: Array, quantile: float
) -> Spread | None:
    """Of the axis of a cylinder, or of a plane, across it at its `point`."""
    name = name_of_direction(answer.kind)
    if name is None or "point" not in parameters_of(answer.kind):
        return None
    first = names.index("point.x")
    of_point = covariance[first : first + 3, first : first + 3]
    along = getattr(answer, name)
    across = along[None] if name == "normal" else np.array(basis(along))
    return spread(across @ of_point @ across.T, quantile)


def spread(covariance: Array, quantile: float) -> Spread:
    """Of an offset with a covariance (1, 1) or (2, 2)."""
    if len(covariance) == 1:
        deviation = sqrt(max(float(covariance[0, 0]), 0.0))
        return Spread(quantile * deviation, (deviation,))
    (first, mixed), (_, second) = covariance.tolist()
    middle, half = 0.5 * (first + second), hypot(0.5 * (first - second), mixed)
    larger, smaller = (sqrt(max(square, 0.0)) for square in (middle + half, middle - half))
    circle = float(np.interp(smaller / larger if larger > 0.0 else 0.0, RATIOS, CIRCLES)) / CIRCLES[0]
    return Spread(quantile * circle * larger, (larger, smaller))
