"""Robust kernels: how much a residual of `x` noise scales costs, and how much it pulls."""

from enum import IntEnum
from math import erf, exp, pi, sqrt

import numpy as np

from ..geometry.vectors import Array
from . import _noise

CUTOFF = 6.0
"""Scales beyond which `TUKEY` is constant."""

HUBER_95, TUKEY_95 = 1.345, 4.685
"""Corner of Huber's kernel and cut-off of Tukey's, in standard deviations, that leave them 95% of the
efficiency of least squares under normal noise. Source: Holland and Welsch, Comm. Statist. A6, 1977."""


class Kernel(IntEnum):
    """What refinement minimizes is  sum rho(d / scale);  the numbers are those of `noise/kernels.h`.

    `LEAST_SQUARES`: rho = x^2 / 2. `GEMAN_MCCLURE`: x^2 / 2 / (1 + x^2), redescending and never quite zero,
    the kernel of the annealed search. `TUKEY`: the biweight, rho = 6 (1 - (1 - x^2 / 36)^3), constant beyond
    6 scales. `HUBER`: x^2 / 2, |x| - 1 / 2 beyond one scale.
    Source of the forms: Zhang, "Parameter estimation techniques", Image and Vision Computing 15, 1997,
    table 1.
    """

    LEAST_SQUARES = 0
    GEMAN_MCCLURE = 1
    TUKEY = 2
    HUBER = 3

    def rho(self, squared: Array) -> Array:
        """Cost (N,) of squared residuals in units of the scale; near 0 it is half of them."""
        return self.rho_and_weight(squared)[0]

    def weight(self, squared: Array) -> Array:
        """rho'(x) / x: 1 at 0, the weight of a residual in a least squares step."""
        return self.rho_and_weight(squared)[1]

    def rho_and_weight(self, squared: Array) -> tuple[Array, Array]:
        """Both, at the price of one."""
        return _noise.costs(self, squared)

    def slope(self, squared: Array) -> Array:
        """rho''(x): what the pull of a residual grows by, 1 at 0 and negative where the kernel redescends."""
        if self == Kernel.LEAST_SQUARES:
            return np.ones_like(squared)
        if self == Kernel.HUBER:
            return np.asarray(squared <= 1.0, np.float64)
        if self == Kernel.TUKEY:
            share = squared / CUTOFF**2
            return np.where(share < 1.0, (1.0 - share) * (1.0 - 5.0 * share), 0.0)
        return (1.0 - 3.0 * squared) / (1.0 + squared) ** 3


def biweight_deviation(cutoff: float) -> float:
    """Standard deviation of a unit normal variable x under the weights (1 - (x / cutoff)^2)^2.

    From the moments of exp(-x^2 / 2) between 0 and the cut-off, each from the one before by parts.
    """
    edge = exp(-0.5 * cutoff**2)
    moments = [sqrt(0.5 * pi) * erf(cutoff / sqrt(2.0))]
    for power in (1, 3, 5):
        moments.append(power * moments[-1] - cutoff**power * edge)
    weights, squares = (a - 2.0 * b / cutoff**2 + c / cutoff**4 for a, b, c in (moments[:3], moments[1:]))
    return sqrt(squares / weights)
