"""Robust kernels: how much a residual of `x` noise scales costs, and how much it pulls."""

from enum import IntEnum

from fitting import _descent
from fitting.geometry import Array


class Kernel(IntEnum):
    """What refinement minimises is  sum rho(d / scale);  the numbers are those of `fitting._descent`.

    `LEAST_SQUARES`: rho = x^2 / 2. `GEMAN_MCCLURE`: x^2 / 2 / (1 + x^2), redescending and never quite zero,
    the kernel of the annealed search. `TUKEY`: the biweight, zero beyond 6 scales.
    Source of the forms: Zhang, "Parameter estimation techniques", Image and Vision Computing 15, 1997,
    table 1.
    """

    LEAST_SQUARES = 0
    GEMAN_MCCLURE = 1
    TUKEY = 2

    def rho(self, squared: Array) -> Array:
        """Cost (N,) of squared residuals in units of the scale; near 0 it is half of them."""
        return _descent.costs(self, squared)[0]

    def weight(self, squared: Array) -> Array:
        """rho'(x) / x: 1 at 0, the weight of a residual in a least squares step."""
        return _descent.costs(self, squared)[1]
