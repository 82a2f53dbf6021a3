"""Half a 95% interval in standard deviations: of a normal distribution, and of Student's t.

SciPy has the latter, but takes ten times as long to import as a fit takes.
"""

from functools import cache, lru_cache
from math import atan, cos, exp, lgamma, pi, sqrt, tan

import numpy as np

from ..geometry.vectors import Array

SHARE = 0.95
"""Of the cases an interval holds."""

NORMAL = 1.959963984540054
"""Half the interval where the standard deviation is known."""

MANY = 300.0
"""Degrees of freedom from which on the series in their inverse has 12 digits, as the quadrature has below."""

NODES = 64
"""Of the quadrature."""

STEPS = 50
"""Of Newton's method; five to seven are usual."""

AT_REST = 1e-15
"""Share of the angle by which the last step moves it at most."""


@lru_cache(1024)
def half_interval(free: float | None) -> float:
    """Half a 95% interval for an estimate of `free` >= 1 degrees of freedom; None for a known deviation."""
    if free is None:
        return NORMAL
    return _series(free) if free >= MANY else _solved(free)


def _series(free: float) -> float:
    """Abramowitz and Stegun, Handbook of Mathematical Functions, 1964, 26.7.5."""
    z = NORMAL
    terms = (
        z * (z**2 + 1.0) / 4.0,
        z * (5.0 * z**4 + 16.0 * z**2 + 3.0) / 96.0,
        z * (3.0 * z**6 + 19.0 * z**4 + 17.0 * z**2 - 15.0) / 384.0,
        z * (79.0 * z**8 + 776.0 * z**6 + 1482.0 * z**4 - 1920.0 * z**2 - 945.0) / 92160.0,
    )
    return z + sum(term / free**power for power, term in enumerate(terms, 1))


def _solved(free: float) -> float:
    """With t = sqrt(free) tan a the density is cos(a)^(free - 1) over its integral from 0 to pi / 2.

    That integral is sqrt(pi) / 2 Gamma(free / 2) / Gamma((free + 1) / 2); Newton's method finds the angle up
    to which there is the `SHARE` of it.
    """
    nodes, weights = _quadrature()
    wanted = SHARE * 0.5 * sqrt(pi) * exp(lgamma(0.5 * free) - lgamma(0.5 * (free + 1.0)))
    angle = atan(NORMAL / sqrt(free))
    for _ in range(STEPS):
        integral = 0.5 * angle * float(weights @ np.cos(0.5 * angle * (1.0 + nodes)) ** (free - 1.0))
        step = (wanted - integral) / cos(angle) ** (free - 1.0)
        angle = min(angle + step, 0.5 * (angle + 0.5 * pi))  # it stays below pi / 2
        if abs(step) <= AT_REST * angle:
            break
    return sqrt(free) * tan(angle)


@cache
def _quadrature() -> tuple[Array, Array]:
    """Nodes in [-1, 1] and weights of Gauss and Legendre."""
    return np.polynomial.legendre.leggauss(NODES)
