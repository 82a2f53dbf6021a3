"""Votes find what most of the values say."""

import numpy as np
import pytest

from primfit.paper.parts.votes import around, half_sphere, peak, voted_axis, voted_normal


def test_the_peak_is_where_most_values_are_and_not_their_mean():
    rng = np.random.default_rng(0)
    values = np.concatenate([2.0 + 1e-3 * rng.normal(size=300), rng.uniform(0.0, 10.0, 200)])
    found, votes = peak(values, 0.0, 10.0)
    assert found == pytest.approx(2.0, abs=1e-3)
    assert 250 <= votes <= 330


def test_values_out_of_bounds_have_no_vote():
    found, votes = peak(np.full(50, 3.0), 4.0, 5.0)
    assert np.isnan(found) and votes == 0


def test_directions_are_units_and_evenly_spread():
    directions = half_sphere(500)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    cosines = directions @ directions.T - 2.0 * np.eye(500)
    assert np.degrees(np.arccos(cosines.max(axis=1))).max() < 7.0


def test_a_grid_of_directions_has_its_middle_and_reaches_as_far_as_asked():
    direction = np.array([0.6, 0.0, 0.8])
    angles = np.arccos((around(direction, 0.1) @ direction).clip(-1.0, 1.0))
    assert angles.min() < 1e-7 and np.tan(angles.max()) == pytest.approx(0.1 * np.sqrt(2.0))


@pytest.mark.parametrize(("lean", "low", "high"), [(0.0, 0.0, 0.15), (0.6, 0.2, 0.98)])
def test_the_axis_is_the_one_that_normals_have_one_angle_with(lean, low, high):
    rng = np.random.default_rng(1)
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    across = np.cross(rng.normal(size=(300, 3)), axis)
    across /= np.linalg.norm(across, axis=1, keepdims=True)
    normals = np.sqrt(1.0 - lean**2) * across + lean * axis
    normals[:60] = rng.normal(size=(60, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    found, cosine = voted_axis(normals, np.ones(300), low, high)
    assert abs(found @ axis) > np.cos(np.radians(1.0))
    assert cosine == pytest.approx(lean, abs=0.02)


def test_the_voted_normal_is_that_of_most_and_not_the_mean():
    rng = np.random.default_rng(3)
    normal = np.array([1.0, 2.0, -2.0]) / 3.0
    normals = normal * rng.choice([-1.0, 1.0], 200)[:, None] + 0.01 * rng.normal(size=(200, 3))
    normals[:80] = [0.0, 0.6, 0.8]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert abs(voted_normal(normals, np.ones(200)) @ normal) > np.cos(np.radians(0.5))
