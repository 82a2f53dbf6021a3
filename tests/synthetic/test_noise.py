"""Noise, mixed pixels, outliers and rounding, each by its law."""

import numpy as np
import pytest

from primfit.synthetic.noise import correlated, edges, gross_outliers, rounded, sigma_weights


def test_noise_grows_with_range_and_incidence():
    distance, cosine = np.array([1.0, 2.0, 1.0, 1.0]), np.array([1.0, 1.0, 0.5, 0.1])
    weights = sigma_weights(distance, cosine)
    assert np.sqrt(np.mean(weights**2)) == pytest.approx(1.0)
    assert weights[1] == pytest.approx(2 * weights[0])
    assert weights[0] < weights[2] < weights[3]
    # tan 60 degrees = sqrt 3.
    assert weights[2] / weights[0] == pytest.approx(np.sqrt(1 + 3 / 4))


def test_white_noise_is_white_and_correlated_noise_is_correlated():
    white = correlated(np.random.default_rng(0), 300, 300, 0.0)
    assert abs(np.mean(white[:, 1:] * white[:, :-1])) < 0.02
    field = correlated(np.random.default_rng(0), 400, 400, 5.0)
    # 400^2 points in cells of about 5^2 * pi / 2: 4,000 that are independent; four standard deviations.
    assert abs(field.std() - 1.0) < 0.06
    for gap in (2, 5, 10):
        expected = np.exp(-((gap / 5.0) ** 2))
        assert abs(np.mean(field[:, gap:] * field[:, :-gap]) - expected) < 0.08
        assert abs(np.mean(field[gap:] * field[:-gap]) - expected) < 0.08


def test_edges_are_hits_beside_a_miss():
    seen = np.zeros((6, 7), dtype=bool)
    seen[1:5, 1:6] = True
    inside = np.zeros_like(seen)
    inside[2:4, 2:5] = True
    assert np.array_equal(edges(seen), seen & ~inside)
    assert np.array_equal(edges(np.ones((3, 3), bool)), np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool))


def test_outliers_fill_the_doubled_box():
    points = np.random.default_rng(1).uniform([0, 0, 0], [1, 2, 3], (500, 3))
    stray = gross_outliers(np.random.default_rng(2), points, 20_000, "box")
    np.testing.assert_allclose(stray.min(axis=0), [-0.5, -1, -1.5], atol=0.05)
    np.testing.assert_allclose(stray.max(axis=0), [1.5, 3, 4.5], atol=0.05)
    # Standard deviation of a uniform law: width / sqrt 12.
    np.testing.assert_allclose(stray.std(axis=0), np.array([2, 4, 6]) / np.sqrt(12), rtol=0.02)


def test_a_neighbouring_surface_touches_the_cloud():
    points = np.random.default_rng(3).normal(size=(500, 3))
    for seed in range(10):
        stray = gross_outliers(np.random.default_rng(seed), points, 400, "neighbour")
        center = stray.mean(axis=0)
        normal = np.linalg.svd(stray - center)[2][2]
        assert np.abs((stray - center) @ normal).max() < 1e-9
        height = (points - center) @ normal
        # All of the cloud on one side, its outermost point in the plane.
        assert min(abs(height.min()), abs(height.max())) < 1e-9


def test_rounded_output():
    points = np.random.default_rng(4).uniform(-5, 5, (1000, 3))
    same, step = rounded(points, 0.0)
    assert step == 0.0 and np.array_equal(same, points)
    grid, step = rounded(points, 1e-3)
    assert step == 1e-3 and np.abs(grid - points).max() <= 5.01e-4
    assert np.abs(grid / step - np.round(grid / step)).max() < 1e-9
    single, step = rounded(points, None)
    assert np.array_equal(single, points.astype(np.float32)) and single.dtype == np.float64
    assert 1e-7 < step < 1e-6
