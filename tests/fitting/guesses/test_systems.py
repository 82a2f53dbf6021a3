"""Many small linear systems at once: least squares at first, and then deaf to outliers."""

import numpy as np
import pytest

from primfit.fitting.guesses._guesses import cylinders, solve_linear


@pytest.mark.parametrize("m", [1, 3, 7])
def test_one_round_is_least_squares(m: int) -> None:
    rng = np.random.default_rng(m)
    columns, target = rng.normal(size=(6, m, 40)), rng.normal(size=(6, 40))
    found = solve_linear(columns, target, 1)
    for solution, each, right in zip(found, columns, target, strict=True):
        np.testing.assert_allclose(solution, np.linalg.lstsq(each.T, right)[0], rtol=1e-8, atol=1e-10)


def test_rounds_come_to_what_most_rows_say() -> None:
    """A tenth of the rows are off by as much as the values are large."""
    rng = np.random.default_rng(2)
    truth, columns = np.array([1.0, -2.0, 0.5]), rng.normal(size=(1, 3, 200))
    target = truth @ columns + 1e-3 * rng.normal(size=(1, 200))
    target[0, :20] += 5.0
    once, often = (solve_linear(columns, target, rounds)[0] for rounds in (1, 12))
    assert np.abs(often - truth).max() < 1e-3 < 0.1 < np.abs(once - truth).max()


def test_a_system_is_solved_as_it_would_be_alone() -> None:
    rng = np.random.default_rng(3)
    columns, target = rng.normal(size=(5, 4, 30)), rng.normal(size=(5, 30))
    together = solve_linear(columns, target, 5)
    alone = [solve_linear(columns[i : i + 1], target[i : i + 1], 5)[0] for i in range(5)]
    np.testing.assert_array_equal(together, alone)


def test_circles_shrug_off_a_fifth_of_outliers() -> None:
    rng = np.random.default_rng(1)
    angle = rng.uniform(0.0, 4.0, 200)
    points = np.column_stack([2.0 + 0.7 * np.cos(angle), -1.0 + 0.7 * np.sin(angle), angle])
    points[:40, :2] = rng.uniform([0.0, -3.0], [4.0, 1.0], (40, 2))
    found = cylinders(np.array([[0.0, 0.0, 1.0]]), points, 4)[0]
    np.testing.assert_allclose(found[[3, 4, 8]], [2.0, -1.0, 0.7], atol=0.2)


def test_more_unknowns_than_there_is_room_for_are_refused() -> None:
    with pytest.raises(ValueError, match="at most"):
        solve_linear(np.zeros((1, 12, 20)), np.zeros((1, 20)), 1)
