"""Poses: half of the axes stay exactly z, half of the positions exactly where they were."""

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.synthetic.canonical import sample_segment
from primfit.synthetic.poses import place, rotation_about_axes


def test_rotations_are_rotations():
    rng = np.random.default_rng(0)
    for _ in range(20):
        rotation = rotation_about_axes(rng.uniform(0, 2 * np.pi, 3))
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-15)
        assert np.linalg.det(rotation) == pytest.approx(1.0)


def test_axes_have_the_quantiles_of_the_training_axes():
    angles = np.random.default_rng(1).uniform(0, 2 * np.pi, (4000, 3))
    axes = np.abs([rotation_about_axes(row)[:, 2] for row in angles])
    # Quartiles of |z| and |x| over the turned cylinders of the training set; sampling error 0.01.
    np.testing.assert_allclose(np.quantile(axes[:, 2], [0.25, 0.5, 0.75]), [0.136, 0.351, 0.642], atol=0.03)
    np.testing.assert_allclose(np.quantile(axes[:, 0], [0.25, 0.5, 0.75]), [0.278, 0.538, 0.803], atol=0.03)


@pytest.mark.parametrize("kind", KINDS)
def test_points_move_with_their_primitive(kind):
    rng = np.random.default_rng(2)
    for _ in range(10):
        primitive, points = place(rng, *sample_segment(rng, kind))
        # Rounding at coordinates of at most 50.
        assert np.abs(primitive.signed_distance(points)).max() < 1e-13


def test_half_of_the_axes_and_positions_are_kept_exactly():
    rng = np.random.default_rng(3)
    tori = [place(rng, *sample_segment(rng, "torus"))[0] for _ in range(400)]
    upright = np.mean([np.array_equal(torus.axis, [0.0, 0.0, 1.0]) for torus in tori])
    centered = np.mean([np.array_equal(torus.center, np.zeros(3)) for torus in tori])
    # Four standard deviations of a share of one half among 400.
    assert abs(upright - 0.5) < 0.1
    assert abs(centered - 0.5) < 0.1


def test_planes_are_always_turned_and_spread_widely():
    rng = np.random.default_rng(4)
    planes = [place(rng, *sample_segment(rng, "plane")) for _ in range(200)]
    assert not any(abs(plane.normal[2]) == 1.0 for plane, _ in planes)
    centroids = np.array([points.mean(axis=0) for _, points in planes])
    assert np.quantile(centroids, 0.95) > 15
