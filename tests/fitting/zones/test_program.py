"""The least largest value in a box: against all values in one program, and against equioscillation."""

import numpy as np
import pytest
from scipy.optimize import linprog

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.zones.program import linear_program


def in_one(values: Array, slopes: Array, region: float) -> float:
    """By what the largest value is lowered, with every value in one program."""
    k = slopes.shape[1]
    found = linprog(
        np.append(np.zeros(k), 1.0),
        A_ub=np.column_stack([slopes, -np.ones(len(values))]),
        b_ub=-values,
        bounds=[(-region, region)] * k + [(None, None)],
        method="highs-ipm",
    )
    return float(values.max() - found.x[k])


@pytest.mark.parametrize("region", [1e-3, 0.1, 10.0])
@pytest.mark.parametrize("k", [1, 4, 7])
def test_few_values_at_a_time_come_to_the_optimum_of_all(k: int, region: float) -> None:
    rng = np.random.default_rng(k)
    values, slopes = rng.normal(size=2000), rng.normal(size=(2000, k))
    found = linear_program(values, slopes, region)
    assert found is not None
    assert found.promised == pytest.approx(in_one(values, slopes, region), rel=1e-6, abs=1e-9)
    after = values + slopes @ found.step
    assert values.max() - after.max() == pytest.approx(found.promised, rel=1e-7, abs=1e-9)
    assert np.abs(found.step).max() <= region * (1.0 + 1e-9)


def test_multipliers_balance_the_slopes_of_active_values() -> None:
    rng = np.random.default_rng(1)
    values, slopes = rng.uniform(size=500), rng.normal(size=(500, 4))
    found = linear_program(values, slopes, 1e3)
    assert found is not None and found.is_vertex
    assert found.weights.sum() == pytest.approx(1.0) and (found.weights > 0.0).all()
    np.testing.assert_allclose(found.weights @ slopes[found.active], 0.0, atol=1e-9)
    after = values + slopes @ found.step
    np.testing.assert_allclose(after[found.active], after.max(), atol=1e-9)


def test_the_best_line_of_a_parabola_equioscillates() -> None:
    """Of all lines 1/2 is the nearest to x^2 on [-1, 1], off by 1/2 at both ends and in the middle."""
    x = np.linspace(-1.0, 1.0, 201)
    values = np.concatenate([x**2, -(x**2)])
    slopes = np.concatenate([-np.column_stack([np.ones(201), x]), np.column_stack([np.ones(201), x])])
    found = linear_program(values, slopes, 10.0)
    assert found is not None
    np.testing.assert_allclose(found.step, [0.5, 0.0], atol=1e-9)
    assert found.promised == pytest.approx(0.5)
    assert sorted(x[found.active % 201].round(9)) == [-1.0, 0.0, 1.0]


def test_values_that_are_no_numbers_have_no_solution() -> None:
    assert linear_program(np.array([1.0, np.nan]), np.ones((2, 1)), 1.0) is None
    assert linear_program(np.array([1.0, np.inf]), np.ones((2, 1)), 1.0) is None
