"""95 % of a mixture: one of several covariances holds, each with its probability.

A mean of the covariances would not do: an unlikely one that is a thousand times as large would make every
interval long, while the interval that holds 95 % of the cases hardly needs it.
"""

import numpy as np

from ..geometry.vectors import Array
from ..noise.fields import EPS

UPPER = 0.975
"""Share of the cases that are below the upper end of a 95 % interval."""

HALVINGS = 30
"""Of the bracket of a quantile, which spans some decades: to six digits."""


def mixed(covariances: Array, weights: Array, unit: Array, free: float) -> Array:
    """The covariance (k, k) whose 95 % intervals are those of a mixture, in its principal directions.

    Parameters
    ----------
    covariances, weights : (T, k, k) and (T,) of its parts, of Student's t with `free` degrees of freedom
    unit : (k, k) the covariance that principal directions of the mean one are looked for about
    """
    from scipy.special import stdtrit

    sizes = np.sqrt(unit.diagonal())
    values, vectors = np.linalg.eigh(unit / np.outer(sizes, sizes))
    stretch = np.sqrt(np.maximum(values, EPS))
    root, inverse = sizes[:, None] * vectors * stretch, (vectors / stretch).T / sizes
    mean = np.einsum("t,tij->ij", weights, covariances)
    turn = np.linalg.eigh(inverse @ mean @ inverse.T)[1]
    across = inverse.T @ turn
    deviations = np.sqrt(np.maximum(np.einsum("ik,tij,jk->tk", across, covariances, across), 0.0))
    half = root @ turn * (_quantiles(deviations, weights, free) / stdtrit(free, UPPER))
    return np.asarray(half @ half.T)


def _quantiles(deviations: Array, weights: Array, free: float) -> Array:
    """Upper ends (k,) of the 95 % intervals about 0 of mixtures of standard deviations (T, k)."""
    from scipy.special import stdtr, stdtrit

    ends = stdtrit(free, UPPER) * deviations
    low, high = ends.min(axis=0), ends.max(axis=0)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        scores = np.divide(middle, deviations, out=np.full_like(ends, np.inf), where=deviations > 0.0)
        within = weights @ stdtr(free, scores) >= UPPER
        low, high = np.where(within, low, middle), np.where(within, middle, high)
    return np.asarray(high)
