"""Robust kernels: how much a residual of `x` noise scales costs, and how much it pulls.

Each kernel wraps any primitive's distances; refinement minimises  sum rho(d / scale).
Source of the forms: Zhang, "Parameter estimation techniques", Image and Vision Computing 15, 1997, table 1.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fitting.geometry import Array


class Kernel(Protocol):
    def rho(self, squared: Array) -> Array:
        """Cost of squared residuals in units of the scale; near 0 it is half of them."""
        ...

    def weight(self, squared: Array) -> Array:
        """rho'(x) / x: 1 at 0, the weight of a residual in a least squares step."""
        ...


@dataclass(frozen=True)
class LeastSquares:
    """rho = x^2 / 2."""

    def rho(self, squared: Array) -> Array:
        return 0.5 * squared

    def weight(self, squared: Array) -> Array:
        return np.ones_like(squared)


@dataclass(frozen=True)
class GemanMcClure:
    """rho = x^2 / 2 / (1 + x^2): redescending, never quite zero; the kernel of the annealed search."""

    def rho(self, squared: Array) -> Array:
        return 0.5 * squared / (1.0 + squared)

    def weight(self, squared: Array) -> Array:
        return 1.0 / (1.0 + squared) ** 2


@dataclass(frozen=True)
class Tukey:
    """Tukey's biweight, zero beyond `cutoff` scales."""

    cutoff: float = 6.0

    def rho(self, squared: Array) -> Array:
        inside = np.clip(1.0 - squared / self.cutoff**2, 0.0, None)
        return self.cutoff**2 / 6.0 * (1.0 - inside**3)

    def weight(self, squared: Array) -> Array:
        return np.clip(1.0 - squared / self.cutoff**2, 0.0, None) ** 2
