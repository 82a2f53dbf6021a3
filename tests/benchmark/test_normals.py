"""The normals that others are given."""

import numpy as np

from primfit.benchmark.normals import estimate_normals
from primfit.fitting.cloud import normals


def test_they_are_those_that_primfit_had():
    points = np.random.default_rng(0).normal(size=(200, 3)) * [1.0, 1.0, 0.05]
    frozen, now = estimate_normals(points), normals.estimate_normals(points)
    np.testing.assert_allclose(np.abs(np.sum(frozen * now, axis=1)), 1.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(frozen, axis=1), 1.0)


def test_two_points_have_some():
    assert estimate_normals(np.eye(3)[:2]).tolist() == [[0.0, 0.0, 1.0]] * 2
