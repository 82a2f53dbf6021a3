"""Candidates for axes, lines of revolution and circles, under wrong normals and outliers."""

import numpy as np
import pytest

from primfit.fitting.geometry.axes import (
    DIRECTION_GRID,
    Oriented,
    circles,
    profile_circles,
    revolution_axis,
    robust_linear_solve,
    spine_circle,
)
from primfit.fitting.geometry.vectors import Array, around_axis
from tests.fitting.clouds import EXAMPLES, sample


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


def test_circles_shrug_off_a_fifth_of_outliers() -> None:
    rng = np.random.default_rng(1)
    angle = rng.uniform(0.0, 4.0, 200)
    x, y = 2.0 + 0.7 * np.cos(angle), -1.0 + 0.7 * np.sin(angle)
    x[:40], y[:40] = rng.uniform(0.0, 4.0, 40), rng.uniform(-3.0, 1.0, 40)
    found = np.ravel(circles(x[None], y[None]))
    np.testing.assert_allclose(found, [2.0, -1.0, 0.7], atol=0.2)


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


def reference_solve(columns: Array, target: Array, rounds: int) -> Array:
    """One of the systems of `robust_linear_solve`, with NumPy."""
    weight = np.ones(len(target))
    for _ in range(rounds):
        root = np.sqrt(weight)
        solution = np.linalg.lstsq((root * columns).T, root * target, rcond=None)[0]
        residual = solution @ columns - target
        weight = 1.0 / (1.0 + (residual / (np.median(np.abs(residual)) + 1e-12)) ** 2)
    return np.asarray(solution)


@pytest.mark.parametrize("unknowns", [1, 2, 5, 9])
def test_linear_systems_are_solved_as_by_numpy(unknowns: int) -> None:
    rng = np.random.default_rng(unknowns)
    columns = rng.normal(size=(3, unknowns, 101))
    target = np.einsum("kmn,m->kn", columns, rng.normal(size=unknowns)) + 0.1 * rng.normal(size=(3, 101))
    target[:, :20] += rng.uniform(5.0, 9.0, (3, 20))
    found = robust_linear_solve(columns, target)
    expected = [reference_solve(*each, 4) for each in zip(columns, target, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_profiles_are_those_about_each_axis() -> None:
    rng = np.random.default_rng(4)
    points, feet = rng.normal(size=(90, 3)), rng.normal(size=(5, 3))
    axes = rng.normal(size=(5, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    around = [around_axis(points, *each)[1:] for each in zip(feet, axes, strict=True)]
    rho, height = (np.array(each) for each in zip(*around, strict=True))
    np.testing.assert_allclose(profile_circles(points, axes, feet), circles(rho, height), rtol=1e-9)


def reference_spine(
    cylinder: Array, points: Array, normals: Array, rounds: int
) -> tuple[Array, Array, float]:
    """`spine_circle`, with NumPy."""
    radial, rho, _ = around_axis(points, cylinder[3:6], cylinder[:3])
    side = np.where(np.einsum("ij,ij->i", radial, normals) < 0.0, -1.0, 1.0)
    off = np.abs(rho - cylinder[8])
    on_tube = off <= 2.0 * np.median(off)
    spine = points[on_tube] - cylinder[8] * side[on_tube, None] * normals[on_tube]
    center = spine.mean(axis=0)
    _, axes = np.linalg.eigh((spine - center).T @ (spine - center))
    along = (spine - center) @ axes
    x, y, radius = circles(along[None, :, 2], along[None, :, 1], rounds)
    return axes[:, 0], center + x * axes[:, 2] + y * axes[:, 1], float(radius[0])


def test_the_spine_of_a_tube_is_that_of_numpy() -> None:
    rng = np.random.default_rng(7)
    torus = EXAMPLES["torus"]
    points = sample(torus, 200) + rng.normal(scale=0.01, size=(200, 3))
    normals = torus.gradient(points) * rng.choice([-1.0, 1.0], 200)[:, None]
    start = torus.row()
    cylinder = np.concatenate([[1.0, 0.0, 0.0], start[3:6], [0.0, 0.0, start[8]]])
    axis, center, radius = spine_circle(cylinder, points, normals)
    expected = reference_spine(cylinder, points, normals, 4)
    np.testing.assert_allclose(axis * np.sign(axis @ expected[0]), expected[0], atol=1e-12)
    np.testing.assert_allclose(center, expected[1], atol=1e-12)
    assert radius == pytest.approx(expected[2], rel=1e-12)
