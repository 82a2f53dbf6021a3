"""The covariance: a sandwich over points whose noise may be uneven."""

from dataclasses import replace

import numpy as np
import pytest

from primfit.fitting.primitives.sphere import Sphere
from tests.fitting.uncertainty.known import flat, known


def test_uneven_noise_is_weighed_where_it_is() -> None:
    """Noise on one side only makes the centre uncertain along that side."""
    rng, sphere = np.random.default_rng(1), Sphere([0.0, 0.0, 0.0], 1.0)
    points = rng.standard_normal((3000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    sigma = np.where(np.abs(points[:, 2]) > 0.7, 0.02, 0.002)
    found = known(points + (sigma * rng.standard_normal(3000))[:, None] * sphere.gradient(points), "sphere")
    along, across = (found.intervals[f"center.{axis}"].standard_deviation for axis in "zx")
    assert along > 2.0 * across


def test_few_inliers_scatter_by_their_distances_whatever_the_kernel_keeps() -> None:
    linear, _ = flat(20, np.random.default_rng(3))
    inlier = np.arange(20) < 15
    found = replace(linear, pull=0.1 * linear.pull).equal(inlier)
    left = np.where(inlier, 1.0, 0.1) * linear.distance
    assert found is not None and found.noise == pytest.approx(np.sqrt(left @ left / 17))


def test_without_fields_the_covariance_is_the_sandwich() -> None:
    linear, _ = flat(300, np.random.default_rng(3))
    found, bread = linear.uneven(None), np.linalg.inv(linear.rows.T @ linear.rows)
    own = linear.pull**2 / (1.0 - np.sum((linear.rows @ bread) * linear.rows, axis=1))
    assert found is not None and found.effective_points == 300
    expected = bread @ linear.rows.T @ np.diag(own) @ linear.rows @ bread
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-9)
