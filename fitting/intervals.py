"""95 % intervals of the numbers of an answer, and of its direction and position."""

import numpy as np

from fitting.coordinates import DIRECTIONS, SIZES
from fitting.covariance import StepCovariance
from fitting.geometry import Array, basis
from fitting.optimum import Optimum
from fitting.primitives import Primitive
from fitting.profile import Path, path_of
from fitting.uncertainty import Interval, Spread

CURVED = 0.05
"""Half-width of the linearised interval of a radius or half-angle, as a share of its value, from which it is
profiled. A radius is one over a curvature, so the second-order term is as large a share of the first."""

FOLLOWS = 0.05
"""Share of the variance of another number that goes with the profiled one from which it is profiled, too."""

HELD = 1e-9
"""A standard deviation of this share of the largest one is rounding: the number is held."""

ONE_SIDED = 0.84
"""Quantile of a one-sided 95 % interval over that of a two-sided one (1.645 / 1.960)."""

RATIOS = np.linspace(0.0, 1.0, 11)
CIRCLES = (1.9600, 1.9625, 1.9704, 1.9842, 2.0051, 2.0359, 2.0813, 2.1460, 2.2303, 2.3318, 2.4477)
"""Radii of the circles that hold 95 % of a normal law in two dimensions, in its larger standard deviation, by
the smaller over the larger one."""


def intervals_of(
    optimum: Optimum, steps: StepCovariance, names: tuple[str, ...], values: Array, covariance: Array
) -> dict[str, Interval]:
    """By name, of all numbers but the components of a direction."""
    quantile = optimum.quantile(steps)
    deviations = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    ends = np.stack([values - quantile * deviations, values + quantile * deviations], axis=1)
    profiled = np.zeros(len(names), bool)
    size = _most_curved(names, values, quantile * deviations)
    if size is not None and not optimum.exact:
        path = _path(optimum, steps, names[size], size, quantile)
        ends, profiled = _along(optimum, path, size, values, covariance, quantile)
    held = deviations <= HELD * deviations.max()
    found = {}
    for i, name in enumerate(names):
        if name.split(".")[0] in DIRECTIONS:
            continue
        if held[i]:
            found[name] = Interval(float(values[i]), float(values[i]), 0.0, "held")
            continue
        low, high = (float(end) if np.isfinite(end) else None for end in ends[i])
        found[name] = Interval(low, high, float(deviations[i]), "profile" if profiled[i] else "linear")
    return found | _at_bounds(optimum, names, values, quantile)


def _most_curved(names: tuple[str, ...], values: Array, half: Array) -> int | None:
    """The size whose linearised interval is the widest for its value, where that is too wide."""
    sizes = [i for i, name in enumerate(names) if name in SIZES]
    worst = max(sizes, key=lambda i: half[i] / values[i], default=None)
    return None if worst is None or half[worst] <= CURVED * values[worst] else worst


def _path(optimum: Optimum, steps: StepCovariance, name: str, place: int, quantile: float) -> Path:
    """The profile of a size, to where the cost has risen as much as at the ends of the linearised interval.

    There it has by  1/2 (q s)^2 / (A^-1)_gg,  which is what noise that is correlated, uneven or cut off by a
    kernel makes of half a squared quantile.
    """
    row = optimum.by_step()[place]
    variance, bread = row @ steps.matrix @ row, row @ steps.bread @ row
    rise = 0.5 * quantile**2 * variance / bread / optimum.cost.scale**2 / optimum.copies
    unit = 1.0 if name == "half_angle" else optimum.cloud.frame.scale
    return path_of(optimum.primitive, name, float(np.sqrt(variance)) / unit, quantile, rise, optimum.cost)


def _along(
    optimum: Optimum, path: Path, size: int, values: Array, covariance: Array, quantile: float
) -> tuple[Array, np.ndarray]:
    """Ends (P, 2), infinite where they are open, and which numbers (P,) follow the profile.

    A number moves with the profiled size, and what varies beside that is added in squares.
    """
    slope = covariance[size] / covariance[size, size]
    together = slope * covariance[size]
    variances = np.diag(covariance)
    follows = together > FOLLOWS * variances
    beside = quantile**2 * np.maximum(variances - together, 0.0)
    moves = np.zeros((2, len(values)))
    for side, (surface, sign) in enumerate(((path.low, -1.0), (path.high, 1.0))):
        if surface is not None:
            moves[side] = optimum.numbers(surface) - values
        else:
            moves[side] = np.where(follows, np.copysign(np.inf, sign * slope), 0.0)
    down = np.sqrt(np.minimum(moves.min(axis=0), 0.0) ** 2 + beside)
    up = np.sqrt(np.maximum(moves.max(axis=0), 0.0) ** 2 + beside)
    linear = quantile * np.sqrt(variances)
    ends = np.stack(
        [values - np.where(follows, down, linear), values + np.where(follows, up, linear)], axis=1
    )
    return ends, follows


def _at_bounds(
    optimum: Optimum, names: tuple[str, ...], values: Array, quantile: float
) -> dict[str, Interval]:
    """One-sided intervals of the sizes that stand at a bound, from what they would vary by without it."""
    found: dict[str, Interval] = {}
    if optimum.limits is None:
        return found
    for name, (fixed, upper) in optimum.limits.active(optimum.primitive.row()).items():
        steps = None if fixed else optimum.released(name)
        if steps is None:
            continue
        place = names.index(name)
        row, value = optimum.by_step()[place], float(values[place])
        deviation = float(np.sqrt(row @ steps.matrix @ row))
        reach = ONE_SIDED * quantile * deviation
        ends = (max(value - reach, 0.0), value) if upper else (value, value + reach)
        found[name] = Interval(*ends, deviation, "bound")
    return found


def direction_of(kind: str, steps: StepCovariance, quantile: float) -> Spread | None:
    """Of the axis or normal; a sphere has none."""
    return None if kind == "sphere" else spread(steps.matrix[:2, :2], quantile)


def position_of(
    answer: Primitive, names: tuple[str, ...], covariance: Array, quantile: float
) -> Spread | None:
    """Of the axis of a cylinder, or of a plane, across it at its `point`."""
    if answer.kind not in ("cylinder", "plane"):
        return None
    first = names.index("point.x")
    of_point = covariance[first : first + 3, first : first + 3]
    along = answer.axis if answer.kind == "cylinder" else answer.normal  # type: ignore[attr-defined]
    across = np.array(basis(along)) if answer.kind == "cylinder" else along[None]
    return spread(across @ of_point @ across.T, quantile)


def spread(covariance: Array, quantile: float) -> Spread:
    """Of an offset with a covariance (1, 1) or (2, 2)."""
    deviations = np.sqrt(np.maximum(np.linalg.eigvalsh(covariance)[::-1], 0.0))
    ratio = deviations[1] / deviations[0] if len(deviations) == 2 and deviations[0] > 0.0 else 0.0
    circle = float(np.interp(ratio, RATIOS, CIRCLES)) / CIRCLES[0]
    return Spread(quantile * circle * float(deviations[0]), tuple(deviations.tolist()))
