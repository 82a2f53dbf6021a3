"""Candidates for axes, lines of revolution and circles, under wrong normals and outliers."""

import numpy as np
import pytest

from primfit.fitting.geometry.axes import DIRECTION_GRID, axis_directions, circles, revolution_axis
from tests.fitting.clouds import EXAMPLES, sample


@pytest.mark.parametrize("kind", ["cone", "torus", "cylinder"])
def test_the_axis_is_among_the_candidates(kind: str) -> None:
    primitive = EXAMPLES[kind]
    points = sample(primitive, 400)
    directions = axis_directions(points, primitive.gradient(points))
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


def test_circles_shrug_off_a_fifth_of_outliers() -> None:
    rng = np.random.default_rng(1)
    angle = rng.uniform(0.0, 4.0, 200)
    x, y = 2.0 + 0.7 * np.cos(angle), -1.0 + 0.7 * np.sin(angle)
    x[:40], y[:40] = rng.uniform(0.0, 4.0, 40), rng.uniform(-3.0, 1.0, 40)
    found = np.ravel(circles(x[None], y[None]))
    np.testing.assert_allclose(found, [2.0, -1.0, 0.7], atol=0.2)
