"""The least largest of many linear values in a trust region, by the exchange of one value at a time.

Some k + 1 values and bounds of the region, whose weights balance, determine a step and the level that they
have in common after it. The value or bound that is exceeded most enters, and the one whose weight is the
first to vanish leaves: the level rises until nothing is exceeded. It is the revised simplex method on the
dual program, which has about as few rows as the step has numbers.

Source: Stiefel, "Note on Jordan elimination, linear programming and Tchebycheff approximation", Numerische
Mathematik 2, 1960; Bland, "New finite pivoting rules for the simplex method", Mathematics of Operations
Research 2, 1977.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array

EXCHANGES = 200
"""After so many, about ten times what it takes, what is still exceeded is let be. The weights balance in each
exchange, so the step promises no less than the optimum: nothing is proven by it that is not so."""

STALLED = 12
"""Exchanges in a row that do not raise the level, after which Bland's rule chooses: it runs in no circles."""

OUT_OF_REACH = 1e6
"""Values that are farther below the largest than this many radii of the trust region count as so far."""

SLACK = 1e-9
"""Violations and weights below this are none, in radii of the trust region."""

LEAST_PIVOT = 1e-9
"""A share of the largest entry of an exchange, below which rounding hides that an entry is not 0."""


@dataclass(frozen=True)
class Linear:
    """The solution of a linear program.

    Attributes
    ----------
    step : (k,)
    promised : what it lowers the largest value by
    active : indices (m,) of the values that are the largest then
    weights : (m,) their multipliers, with sum 1
    """

    step: Array
    promised: float
    active: NDArray[np.intp]
    weights: Array

    @property
    def is_vertex(self) -> bool:
        """Whether the active values alone determine the step, so that second derivatives have no say."""
        return len(self.active) > len(self.step)


def linear_program(values: Array, slopes: Array, region: float) -> Linear | None:
    """Least t with  values + slopes . step <= t  and no component of the step beyond the region.

    None where values are not finite.
    """
    if not np.isfinite(values).all():
        return None
    n, k = slopes.shape
    worst = int(np.argmax(values))
    headroom = np.minimum((values[worst] - values) / region, OUT_OF_REACH)
    # In radii of the region: row i < n is for  slopes_i . x - headroom_i <= t,  the others for  +-x_j <= 1.
    rows = np.zeros((n + 2 * k, k + 1))
    rows[:n, :k], rows[:n, k] = slopes, -1.0
    rows[n : n + k, :k], rows[n + k :, :k] = np.eye(k), -np.eye(k)
    right = np.concatenate([headroom, np.ones(2 * k)])
    # The steepest descent of the largest value to the corner of the region.
    basis = np.append(n + np.arange(k) + k * (slopes[worst] > 0.0), worst)
    found, weights = _exchanged(rows, right, basis)
    is_value = (basis < n) & (weights > SLACK)
    order = np.argsort(basis[is_value], kind="stable")
    active, weights = basis[is_value][order], weights[is_value][order]
    return Linear(region * found[:k], -region * float(found[k]), active, weights)


def _exchanged(rows: Array, right: Array, basis: NDArray[np.intp]) -> tuple[Array, Array]:
    """The optimum (x, t) (k + 1,), and the weights (k + 1,) of its basis, which the given one becomes."""
    unit = np.zeros(len(basis))
    unit[-1] = -1.0
    stalled, level = 0, -np.inf
    for _ in range(EXCHANGES):
        square = rows[basis]
        found = np.asarray(np.linalg.solve(square, right[basis]), np.float64)
        weights = np.asarray(np.linalg.solve(square.T, unit), np.float64)
        excess = rows @ found - right
        excess[basis] = 0.0
        stalled = 0 if found[-1] > level + SLACK else stalled + 1
        level = max(level, float(found[-1]))
        entering = int(np.argmax(excess if stalled < STALLED else excess > SLACK))
        if excess[entering] <= SLACK:
            break
        entry = np.linalg.solve(square.T, rows[entering])
        pivots = np.flatnonzero(entry > LEAST_PIVOT * np.abs(entry).max())
        ratios = np.maximum(weights[pivots], 0.0) / entry[pivots]
        first = pivots[ratios <= ratios.min() + SLACK * SLACK]
        leaving = first[np.argmax(entry[first])] if stalled < STALLED else first[np.argmin(basis[first])]
        basis[leaving] = entering
    return found, weights
