"""Canonical segments: parameters in their ranges, points on the surface, cuts that leave a half-space."""

import numpy as np
import pytest

from fitting.primitives import KINDS
from synthetic.canonical import GRID, SAMPLERS, SMALLEST_CUT, TORUS_GRID, cut, sample_segment
from synthetic.recipes import Range


@pytest.mark.parametrize("kind", KINDS)
def test_uncut_grids_have_the_benchmark_sizes_and_lie_on_the_surface(kind):
    primitive, points = SAMPLERS[kind](np.random.default_rng(1))
    assert primitive.kind == kind
    assert points.shape == ((TORUS_GRID if kind == "torus" else GRID) ** 2, 3)
    # A dozen roundings at coordinates of at most 15.
    assert np.abs(primitive.signed_distance(points)).max() < 1e-14


@pytest.mark.parametrize("kind", KINDS)
def test_segments_stay_on_the_surface_and_keep_enough_points(kind):
    rng = np.random.default_rng(2)
    for _ in range(20):
        primitive, points = sample_segment(rng, kind)
        assert np.abs(primitive.signed_distance(points)).max() < 1e-14
        assert SMALLEST_CUT <= len(points) <= 8100


def test_parameters_follow_the_laws_of_the_training_set():
    rng = np.random.default_rng(3)
    radii = [SAMPLERS["sphere"](rng)[0].radius for _ in range(300)]
    tori = [SAMPLERS["torus"](rng)[0] for _ in range(300)]
    angles = [SAMPLERS["cone"](rng)[0].half_angle for _ in range(300)]
    assert 1.0 <= min(radii) and max(radii) <= 4.0
    assert all(0.5 <= torus.minor_radius <= torus.major_radius <= 4.0 for torus in tori)
    assert np.pi / 6 <= min(angles) and max(angles) <= np.pi / 3
    # The mean of 300 uniform draws has standard deviation (high - low) / sqrt(12 * 300): four of them.
    assert abs(np.mean(radii) - 2.5) < 4 * 3.0 / 60
    assert abs(np.mean(angles) - np.pi / 4) < 4 * (np.pi / 6) / 60


def test_a_cut_leaves_one_side_of_a_plane():
    points = np.random.default_rng(4).uniform(-1, 1, (5000, 3))
    kept = cut(np.random.default_rng(5), points, 1)
    removed = (
        points[~(points[:, None] == kept[None]).all(-1).any(1)] if len(kept) < len(points) else points[:0]
    )
    assert SMALLEST_CUT <= len(kept) < len(points)
    assert len(kept) + len(removed) == len(points)
    direction = np.random.default_rng(5).standard_normal(3)
    assert (kept @ direction).min() > (removed @ direction).max()


def test_cuts_never_leave_too_few_points():
    points = np.random.default_rng(6).uniform(-1, 1, (SMALLEST_CUT + 50, 3))
    assert len(cut(np.random.default_rng(7), points, 30)) >= SMALLEST_CUT


def test_a_range_is_ordered():
    with pytest.raises(ValueError, match="low <= high"):
        Range(2.0, 1.0)
