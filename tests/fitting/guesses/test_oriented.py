"""Candidates for axes and lines of revolution, under wrong normals and outliers, and linear systems."""

import numpy as np
import pytest

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.guesses.oriented import (
    DIRECTION_GRID,
    Oriented,
    revolution_axis,
    robust_linear_solve,
)
from tests.fitting.clouds import EXAMPLES, sample
from tests.fitting.guesses.reference_guesses import solve


@pytest.mark.parametrize("kind", ["cone", "torus", "cylinder"])
def test_the_axis_is_among_the_candidates(kind: str) -> None:
    primitive = EXAMPLES[kind]
    points = sample(primitive, 400)
    directions = Oriented(points, primitive.gradient(points)).directions
    assert np.abs(directions @ primitive.axis).max() > 0.999  # type: ignore[attr-defined]


def test_the_revolution_axis_survives_a_third_of_wrong_normals() -> None:
    torus = EXAMPLES["torus"]
    points, rng = sample(torus, 600), np.random.default_rng(0)
    normals = torus.gradient(points)
    normals[:200] = rng.normal(size=(200, 3))
    normals[:200] /= np.linalg.norm(normals[:200], axis=1)[:, None]
    line = revolution_axis(points, normals, rounds=30)
    assert abs(line.direction @ torus.axis) > 0.9999  # type: ignore[attr-defined]
    across = np.cross(line.point - torus.center, torus.axis)  # type: ignore[attr-defined]
    assert np.linalg.norm(across) < 0.02


def test_the_direction_grid_leaves_no_wide_gap() -> None:
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    closest = np.degrees(np.arccos(np.clip(np.abs(directions @ DIRECTION_GRID.T).max(axis=1), 0.0, 1.0)))
    assert closest.max() < 28.0


def reference_axis(points: Array, normals: Array, rounds: int) -> tuple[Array, Array]:
    """Direction and moment of `revolution_axis`, with NumPy."""
    lines = np.hstack([np.cross(points, normals), normals])
    weights = np.full(len(lines), 1.0 / len(lines))
    for _ in range(rounds):
        scatter = (lines * weights[:, None]).T @ lines
        lower = scatter[3:, 3:] + 1e-12 * np.trace(scatter) * np.eye(3)
        coupling = np.linalg.solve(lower, scatter[3:, :3])
        _, vectors = np.linalg.eigh(scatter[:3, :3] - scatter[:3, 3:] @ coupling)
        direction = vectors[:, 0]
        momentum = -coupling @ direction
        residual = np.abs(lines[:, :3] @ direction + lines[:, 3:] @ momentum)
        weights = 1.0 / (residual + 0.5 * np.sort(residual)[len(residual) // 2] + 1e-12)
        weights /= weights.sum()
    return direction, momentum


@pytest.mark.parametrize("kind", ["cone", "torus", "cylinder"])
def test_the_revolution_axis_is_that_of_numpy(kind: str) -> None:
    rng = np.random.default_rng(2)
    points = sample(EXAMPLES[kind], 150) + rng.normal(scale=0.05, size=(150, 3))
    normals = EXAMPLES[kind].gradient(points)
    found = revolution_axis(points, normals, rounds=4)
    direction, momentum = reference_axis(points, normals, rounds=4)
    sign = np.sign(found.direction @ direction)
    np.testing.assert_allclose(sign * found.direction, direction, atol=1e-7)
    np.testing.assert_allclose(found.point, np.cross(direction, momentum), atol=1e-6)


@pytest.mark.parametrize("unknowns", [1, 2, 5, 9])
def test_linear_systems_are_solved_as_by_numpy(unknowns: int) -> None:
    rng = np.random.default_rng(unknowns)
    columns = rng.normal(size=(3, unknowns, 101))
    target = np.einsum("kmn,m->kn", columns, rng.normal(size=unknowns)) + 0.1 * rng.normal(size=(3, 101))
    target[:, :20] += rng.uniform(5.0, 9.0, (3, 20))
    found = robust_linear_solve(columns, target)
    expected = [solve(*each, 4) for each in zip(columns, target, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
