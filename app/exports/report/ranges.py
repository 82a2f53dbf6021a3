"""From where to where a picture reaches: a few points that lie far away do not squeeze the others."""

import numpy as np

from primfit.fitting.answer.residuals import Residuals
from primfit.fitting.geometry.vectors import Array

from ..colors import color_limit

INNER = 5.0
"""Per cent of the values at either end that may be far away."""

BESIDE = 1.0
"""How far beyond the others they are shown, as a share of the range of these."""


def robust_range(values: Array) -> tuple[Array, Array]:
    """The lowest and the highest (D,) of values (N, D), without those that are far from the others."""
    low, high = np.percentile(values, (INNER, 100.0 - INNER), axis=0)
    return _reached(values, low, high, BESIDE * (high - low))


def range_about(values: Array, shown: Array, margin: float) -> tuple[Array, Array]:
    """The range (D,) of what is shown (K, D), and of values (N, D) as far as the margin about it."""
    low, high = shown.min(axis=0), shown.max(axis=0)
    from_, to = _reached(values, low, high, margin)
    return np.minimum(low, from_), np.maximum(high, to)


def _reached(values: Array, low: Array, high: Array, margin: Array | float) -> tuple[Array, Array]:
    """How far values go between bounds that a margin has moved."""
    return np.maximum(values.min(axis=0), low - margin), np.minimum(values.max(axis=0), high + margin)


def above(value: float, least: float) -> float:
    """The value, or 0 where it is no more than the least one: than rounding."""
    return value if abs(value) > least else 0.0


def color_reach(residuals: Residuals, least: float) -> float:
    """The residual at which the colors of a report end; 0 where it is no more than the least one."""
    inlying = residuals.distance[residuals.inlier]
    if not len(inlying):
        return 0.0
    limit = min(color_limit(residuals), float(np.abs(robust_range(inlying)).max()))
    return above(limit, least)
