"""Covariance of a step in minimal coordinates about an M-estimate: the sandwich.

With the pulls  p_i = w_i f_i d_i  (w the weight of the kernel, f the factor of the point) and the rows
f_i J_i of the derivatives, the estimate solves  sum p_i f_i J_i = 0,  so that its covariance is

    A^-1 B A^-1,   A = sum rho''_i f_i^2 J_i J_i^T,   B = sum_ij cov(p_i, p_j) f_i f_j J_i J_j^T

Source: Huber and Ronchetti, "Robust statistics", 2nd ed. 2009, section 7.6. With cov(p_i, p_i) from each
point's own pull it holds for noise that differs from point to point: White, Econometrica 48, 1980; divided by
1 - leverage, MacKinnon and White, J. Econometrics 29, 1985 (HC2). Pairs of correlated points: Conley,
J. Econometrics 92, 1999, here patch by patch, with the fields that explain what is left over. Each of these
explanations has its own B; the covariance is the one whose 95 % intervals are those of their mixture.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ..cloud.patches import PATCHES
from ..geometry.vectors import Array
from ..primitives.primitive import Primitive
from .agreement import Agreement, Correlation
from .mixture import mixed
from .profile import Cost

MOST_LEVERAGE = 0.9
"""A point counts as determining at most this much of its own distance."""

UNDETERMINED = 1e-14
"""Relative size of an eigenvalue of A below which a direction is not determined at all."""


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
    """The linearised cost at an optimum, on points that stand for `copies` times as many.

    Attributes
    ----------
    feet : (M, 3) the closest points of the surface
    rows : (M, k) factors times derivatives, in the free directions
    free : (dof, k) those directions, orthonormal
    distance : (M,) factors times distances
    pull, slope : (M,) of the kernel
    gain : (M,) the derivative of the pull by the distance of the point
    """

    feet: Array
    rows: Array
    free: Array
    distance: Array
    pull: Array
    slope: Array
    gain: Array
    copies: float

    @classmethod
    def of(cls, primitive: Primitive, cost: Cost, distance: Array, jacobian: Array, copies: float) -> Self:
        """In all directions, from the distances (M,) of the points and their derivatives (M, dof)."""
        feet = cost.points - distance[:, None] * primitive.gradient(cost.points)
        if cost.factors is not None:
            distance, jacobian = cost.factors * distance, cost.factors[:, None] * jacobian
        squared = (distance / cost.scale) ** 2
        pull, slope = cost.kernel.weight(squared) * distance, cost.kernel.slope(squared)
        gain = slope if cost.factors is None else cost.factors * slope
        return cls(feet, jacobian, np.eye(primitive.dof), distance, pull, slope, gain, copies)

    def within(self, free: Array) -> Self:
        """In these directions (dof, k), orthonormal, only."""
        return replace(self, rows=self.rows @ free, free=free)

    def bread(self) -> Array | None:
        """The inverse of A in the free directions, or None where the points leave one open."""
        square = self.copies * (self.rows.T @ (self.slope[:, None] * self.rows))
        sizes = np.sqrt(np.maximum(square.diagonal(), 0.0))
        if not (sizes > 0.0).all():
            return None
        if not len(sizes):  # nothing is free, and nothing uncertain
            return square
        units = sizes[:, None] * sizes
        scaled = square / units
        if not np.linalg.eigvalsh(scaled)[0] > UNDETERMINED:
            return None
        inverse = np.linalg.inv(scaled) / units
        return np.asarray(0.5 * (inverse + inverse.T))

    def known(self, noise: float) -> StepCovariance | None:
        """Under independent noise of a known standard deviation."""
        bread = self.bread()
        if bread is None:
            return None
        meat = noise**2 * self.copies * (self.rows.T @ self.rows)
        return self._lifted(bread @ meat @ bread, bread, noise, self.copies * len(self.rows))

    def equal(self, inlier: np.ndarray) -> StepCovariance | None:
        """Under independent noise, the same at each point, estimated from what is left over.

        Where points are few, the core that a kernel keeps may be much narrower than the noise: so the
        inliers count with their distances, whatever the kernel makes of them.
        """
        spare = len(self.rows) - self.rows.shape[1]
        left = np.where(inlier, self.distance, self.pull)
        return self.known(float(np.sqrt(left @ left / spare))) if spare > 0 else None

    def uneven(self, agreement: Agreement | None) -> StepCovariance | None:
        """Under noise that may differ from point to point and agree between neighbours."""
        bread = self.bread()
        if bread is None:
            return None
        leverage = self.copies * self.slope * np.einsum("ij,ij->i", self.rows @ bread, self.rows)
        squared = self.pull**2 / (1.0 - np.clip(leverage, 0.0, MOST_LEVERAGE))
        independent = self.copies * (self.rows.T @ (squared[:, None] * self.rows))
        noise, points = float(np.sqrt(squared.mean())), self.copies * len(self.rows)
        if agreement is None:
            return self._lifted(bread @ independent @ bread, bread, noise, points)
        estimates = float(min(points, PATCHES))
        meats = agreement.meats(independent, self.copies * self.gain[:, None] * self.rows, self.feet)
        free = max(estimates - self.rows.shape[1], 1.0)
        matrix, count = mixed(bread @ meats @ bread, agreement.weight, bread, free), points
        if agreement.correlation is not None:
            count = min(points * _alike(bread @ independent @ bread, matrix, bread), points)
        found = self._lifted(matrix, bread, noise, count)
        return replace(found, correlation=agreement.correlation, estimates=estimates)

    def _lifted(
        self,
        matrix: Array,
        bread: Array,
        noise: float,
        effective: float,
    ) -> StepCovariance:
        free = self.free
        return StepCovariance(
            free @ matrix @ free.T, free @ bread @ free.T, noise, effective, self.copies * len(self.rows)
        )


def _alike(independent: Array, found: Array, bread: Array) -> float:
    """The variance of steps under independent noise over what was found, in the mean over what is known."""
    known = np.linalg.inv(bread)
    total = float(np.sum(found * known))
    return float(np.sum(independent * known)) / total if total > 0.0 else 1.0
