"""Covariance of a step in minimal coordinates about an M-estimate: the sandwich.

With the pulls  p_i = w_i f_i d_i  (w the weight of the kernel, f the factor of the point) and the rows
f_i J_i of the derivatives, the estimate solves  sum p_i f_i J_i = 0,  so that its covariance is

    A^-1 B A^-1,   A = sum rho''_i f_i^2 J_i J_i^T,   B = sum_ij cov(p_i, p_j) f_i f_j J_i J_j^T

Source: Huber and Ronchetti, "Robust statistics", 2nd ed. 2009, section 7.6. With cov(p_i, p_i) from each
point's own pull it holds for noise that differs from point to point: White, Econometrica 48, 1980; divided by
1 - leverage, MacKinnon and White, J. Econometrics 29, 1985 (HC2). Pairs of correlated points: Conley,
J. Econometrics 92, 1999, here patch by patch, with the fields that explain what is left over. Each of these
explanations has its own B; the covariance is the one whose 95% intervals are those of their mixture.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import sqrt
from typing import Self

import numpy as np

from ..cloud.patches import PATCHES
from ..geometry.vectors import Array
from ..noise.kernels import Kernel
from ..noise.student import SHARE, half_interval
from ..primitives import PRIMITIVES
from ..solver.refine import CODES
from . import _covariance
from .agreement import Agreement, Correlation

MOST_LEVERAGE = 0.9
"""A point counts as determining at most this much of its own distance."""

UNDETERMINED = 1e-14
"""Relative size of an eigenvalue of A below which a direction is not determined at all."""


@dataclass(frozen=True, eq=False)
class Cost:
    """The cost  sum rho(f d / scale)  over points (N, 3), with factors f (N,) where they have any."""

    points: Array
    kernel: Kernel
    scale: float
    factors: Array | None


@dataclass(frozen=True, eq=False)
class StepCovariance:
    """Of a step (dof,), from M points.

    Attributes
    ----------
    matrix : (dof, dof), 0 for steps that are held
    bread : (dof, dof) the inverse of A: what it would be under independent noise of variance 1
    noise : standard deviation of a pull
    effective_points : how many independent points tell as much
    estimates : how many squares the noise is estimated from; of patches, where fields are looked for
    correlation : of the noise on the surface, None where it is independent
    """

    matrix: Array
    bread: Array
    noise: float
    effective_points: float
    estimates: float
    correlation: Correlation | None = None


@dataclass(frozen=True, eq=False)
class Linear:
    """The linearized cost at an optimum, on points that stand for `copies` times as many.

    Attributes
    ----------
    rows : (k, M) factors times derivatives, in the free directions
    free : (dof, k) those directions, orthonormal; None where they are the components of a step
    distance : (M,) factors times distances
    pull, slope : (M,) of the kernel
    gain : (M,) the derivative of the pull by the distance of the point
    feet : (3, M) the closest points of the surface
    """

    rows: Array
    free: Array | None
    distance: Array
    pull: Array
    slope: Array
    gain: Array
    feet: Array
    copies: float

    @classmethod
    def of(cls, kind: str, row: Array, cost: Cost, copies: float) -> Self:
        """At the surface of a row (9,), in all directions."""
        table = _covariance.linearized(CODES[kind], row, cost.points, cost.kernel, cost.scale, cost.factors)
        dof = PRIMITIVES[kind].dof
        distance, pull, slope, gain = table[dof : dof + 4]
        return cls(table[:dof], None, distance, pull, slope, gain, table[dof + 4 :], copies)

    def within(self, free: Array) -> Self:
        """In these directions (dof, k), orthonormal, only."""
        return replace(self, rows=free.T @ self.rows, free=free)

    @property
    def steps(self) -> int:
        """How many are free."""
        return len(self.rows)

    @property
    def points(self) -> float:
        """How many those that are looked at stand for."""
        return self.copies * self.rows.shape[1]

    @cached_property
    def square(self) -> Array:
        """A, (k, k)."""
        return self.copies * _covariance.weighted_products(self.rows, self.slope)

    @cached_property
    def bread(self) -> Array | None:
        """The inverse of A in the free directions, or None where the points leave one open."""
        return _covariance.inverted(self.square, UNDETERMINED)

    def known(self, noise: float) -> StepCovariance | None:
        """Under independent noise of a known standard deviation."""
        if self.bread is None:
            return None
        meat = noise**2 * self.copies * (self.rows @ self.rows.T)
        return self._lifted(self.bread @ meat @ self.bread, noise)

    def equal(self, inlier: np.ndarray) -> StepCovariance | None:
        """Under independent noise, the same at each point, estimated from what is left over.

        Where points are few, the core that a kernel keeps may be much narrower than the noise: so the
        inliers count with their distances, whatever the kernel makes of them.
        """
        spare = self.rows.shape[1] - self.steps
        left = np.where(inlier, self.distance, self.pull)
        return self.known(sqrt(left @ left / spare)) if spare > 0 else None

    def uneven(self, agreement: Agreement | None) -> StepCovariance | None:
        """Under noise that may differ from point to point and agree between neighbors."""
        bread = self.bread
        if bread is None:
            return None
        independent, square = _covariance.uneven(
            self.rows, self.pull, self.slope, bread, self.copies, MOST_LEVERAGE
        )
        independent, noise = self.copies * independent, sqrt(square)
        if agreement is None:
            return self._lifted(bread @ independent @ bread, noise)
        estimates, points = min(self.points, float(PATCHES)), self.points
        fields = self.copies**2 * agreement.fields(self.rows, self.gain, self.feet)
        meats = np.concatenate([independent[None], fields])
        free = max(int(estimates) - self.steps, 1)
        matrix, alike = mixed(meats, agreement.shares, agreement.weight, bread, free)
        if agreement.correlation is not None:
            points *= min(alike, 1.0)
        return self._lifted(matrix, noise, points, estimates, agreement.correlation)

    def _lifted(
        self,
        matrix: Array,
        noise: float,
        effective: float | None = None,
        estimates: float | None = None,
        correlation: Correlation | None = None,
    ) -> StepCovariance:
        """In all directions, of covariances in the free ones; figures that are not given are all points."""
        bread, free, points = self.bread, self.free, self.points
        assert bread is not None
        if free is not None:
            matrix, bread = free @ matrix @ free.T, free @ bread @ free.T
        return StepCovariance(matrix, bread, noise, effective or points, estimates or points, correlation)


def mixed(meats: Array, shares: Array, weights: Array, bread: Array, free: int) -> tuple[Array, float]:
    """The covariance (k, k) whose 95% intervals are those of a mixture, in its principal directions.

    One of T covariances holds, each with its probability. A mean of them would not do: an unlikely one that
    is a thousand times as large would make every interval long, while the interval that holds 95% of the
    cases hardly needs it.

    Parameters
    ----------
    meats, shares : (R, k, k) and (T, R); B of an explanation is the sum of its shares of the meats
    weights : (T,) probabilities of the explanations, each of Student's t with `free` degrees of freedom
    bread : (k, k) the inverse of A, about which principal directions of the mean covariance are looked for

    Returns
    -------
    It, and the variance of steps under the first meat alone over that, in the mean over what is known.
    """
    return _covariance.mixed(meats, shares, weights, bread, free, SHARE, half_interval(free))
