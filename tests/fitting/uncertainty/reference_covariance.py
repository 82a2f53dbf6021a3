"""The covariance in NumPy, as formulas read: the reference of `primfit.fitting.uncertainty._covariance`."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr, stdtrit

from primfit.fitting.fields.fields import EPS
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import linearize
from primfit.fitting.uncertainty.agreement import Agreement
from primfit.fitting.uncertainty.covariance import MOST_LEVERAGE, Cost

HALVINGS = 100
"""Of the bracket of a quantile."""


def table(primitive: Primitive, cost: Cost) -> Array:
    """As `_covariance.linearized`, (dof + 7, N)."""
    distance, jacobian = linearize(primitive, cost.points)
    feet = cost.points - distance[:, None] * primitive.gradient(cost.points)
    factors = np.ones(len(distance)) if cost.factors is None else cost.factors
    distance, jacobian = factors * distance, factors[:, None] * jacobian
    squared = (distance / cost.scale) ** 2
    slope = cost.kernel.slope(squared)
    return np.vstack(
        [jacobian.T, distance, cost.kernel.weight(squared) * distance, slope, factors * slope, feet.T]
    )


def uneven(rows: Array, pull: Array, slope: Array, bread: Array, copies: float) -> Array:
    """B under noise that differs from point to point, of rows (N, k) that stand for so many points each."""
    leverage = copies * slope * np.einsum("ij,ij->i", rows @ bread, rows)
    squared = pull**2 / (1.0 - np.clip(leverage, 0.0, MOST_LEVERAGE))
    return copies * (rows.T @ (squared[:, None] * rows))


@dataclass(frozen=True, eq=False)
class Patches:
    """Sums of rows (P, k) over patches, their counts (P,), their distances (P, P) over the extent."""

    total: Array
    count: Array
    apart: Array

    @classmethod
    def of(cls, agreement: Agreement, rows: Array, feet: Array) -> "Patches":
        """Of rows (M, k) and feet (M, 3)."""
        seen = agreement.seen
        _, place, count = np.unique(agreement.patch[seen], return_inverse=True, return_counts=True)
        total, middle = (
            np.stack([np.bincount(place, column) for column in each[seen].T], axis=1) for each in (rows, feet)
        )
        middle /= count[:, None]
        apart = np.sqrt(np.sum((middle[:, None] - middle) ** 2, axis=2)) / agreement.extent
        return cls(total, count, apart)


def meats(agreement: Agreement, independent: Array, rows: Array, feet: Array) -> Array:
    """Covariances (T, k, k) of the sum of the rows (M, k), from the one under independent noise."""
    patches = Patches.of(agreement, rows, feet)
    total, count = patches.total, patches.count
    middled = total - np.outer(count / count.sum(), total.sum(axis=0))
    found = []
    for own, rough, rough_range, smooth, smooth_range in zip(
        agreement.own,
        agreement.rough,
        agreement.rough_range,
        agreement.smooth,
        agreement.smooth_range,
        strict=True,
    ):
        meat = own * independent
        if rough_range:
            meat = meat + rough * (total.T @ np.exp(-patches.apart / rough_range) @ total)
        if smooth_range:
            some = middled if smooth_range >= 1.0 else total  # a part deviates by 0 in the mean
            meat = meat + smooth * (some.T @ np.exp(-0.5 * (patches.apart / smooth_range) ** 2) @ some)
        found.append(meat)
    return np.array(found)


def mixed(covariances: Array, weights: Array, unit: Array, free: float) -> Array:
    """The covariance (k, k) whose 95% intervals are those of a mixture of (T, k, k), weights (T,)."""
    sizes = np.sqrt(unit.diagonal())
    values, vectors = np.linalg.eigh(unit / np.outer(sizes, sizes))
    stretch = np.sqrt(np.maximum(values, EPS))
    root, inverse = sizes[:, None] * vectors * stretch, (vectors / stretch).T / sizes
    mean = np.einsum("t,tij->ij", weights, covariances)
    across = inverse.T @ np.linalg.eigh(inverse @ mean @ inverse.T)[1]
    deviations = np.sqrt(np.maximum(np.einsum("ik,tij,jk->tk", across, covariances, across), 0.0))
    turn = np.linalg.eigh(inverse @ mean @ inverse.T)[1]
    half = root @ turn * (ends(deviations, weights, free) / stdtrit(free, 0.975))
    return np.asarray(half @ half.T)


def ends(deviations: Array, weights: Array, free: float) -> Array:
    """Upper ends (k,) of the 95% intervals about 0 of mixtures of standard deviations (T, k)."""
    each = stdtrit(free, 0.975) * deviations
    low, high = each.min(axis=0), each.max(axis=0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        scores = np.divide(middle, deviations, out=np.full_like(each, np.inf), where=deviations > 0.0)
        within = weights @ stdtr(free, scores) >= 0.975
        low, high = np.where(within, low, middle), np.where(within, middle, high)
    return np.asarray(high)
