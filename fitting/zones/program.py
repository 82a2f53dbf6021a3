"""The least largest of many linear values in a trust region, by linear programs of few of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array

ROUNDS = 60
"""Programs after which values that violate the solution are let be: the next step meets them."""

ENTERING = 12
"""Points that enter the linear program at a time, the most violated first."""

OUT_OF_REACH = 1e6
"""Values that are farther below the largest than this many radii of the trust region count as so far."""

SLACK = 1e-9
"""Violations and multipliers below this are none, in radii of the trust region."""


@dataclass(frozen=True)
class Linear:
    """The solution of a linear program.

    Attributes
    ----------
    step : (k,)
    promised : what it lowers the largest value by
    active : indices (m,) of the values that are the largest then
    weights : (m,) their multipliers, with sum 1
    candidates : indices of the values that were looked at
    """

    step: Array
    promised: float
    active: NDArray[np.intp]
    weights: Array
    candidates: NDArray[np.intp]

    @property
    def is_vertex(self) -> bool:
        """Whether the active values alone determine the step, so that second derivatives have no say."""
        return len(self.active) > len(self.step)


def linear_program(
    values: Array, slopes: Array, region: float, candidates: NDArray[np.intp]
) -> Linear | None:
    """Least t with  values + slopes . step <= t  and no component of the step beyond the region.

    It is solved for few of the values, to which those are added that violate the solution, until none does.
    None where the solver finds no solution, or values are not finite.
    """
    from scipy.optimize import linprog  # slow to import, and only zones are found by it

    if not np.isfinite(values).all():
        return None
    k, worst = slopes.shape[1], values.max()
    headroom = np.minimum((worst - values) / region, OUT_OF_REACH)
    few = np.union1d(candidates, np.argpartition(headroom, min(ENTERING, len(values) - 1))[:ENTERING])
    for _ in range(ROUNDS):
        found = linprog(
            np.append(np.zeros(k), 1.0),
            A_ub=np.column_stack([slopes[few], -np.ones(len(few))]),
            b_ub=headroom[few],
            bounds=[(-1.0, 1.0)] * k + [(None, None)],
            method="highs-ds",
            options={"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10},
        )
        if found.x is None:
            return None
        excess = slopes @ found.x[:k] - headroom - found.x[k]
        excess[few] = 0.0
        entering = np.argpartition(-excess, min(ENTERING, len(values) - 1))[:ENTERING]
        entering = entering[excess[entering] > SLACK]
        if not len(entering):
            break
        few = np.union1d(few, entering)
    weights = -found.ineqlin.marginals
    kept = weights > SLACK
    return Linear(region * found.x[:k], -region * found.x[k], few[kept], weights[kept], few)
