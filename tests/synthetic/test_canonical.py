"""Canonical segments: parameters in their ranges, points on the surface, spans and cuts by their laws."""

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.synthetic import canonical
from primfit.synthetic.canonical import (
    GRID,
    KEPT_SHARE,
    SAMPLERS,
    TORUS_GRID,
    WHOLE_SPAN,
    cut,
    sample_segment,
    span,
)
from primfit.synthetic.recipes import Range


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
        assert KEPT_SHARE[kind].quantiles[0] * 6400 - 1 <= len(points) <= 8100


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


@pytest.mark.parametrize("kind", KINDS)
def test_the_share_kept_follows_the_training_sizes(kind):
    law, rng = KEPT_SHARE[kind], np.random.default_rng(8)
    shares = np.array([law.draw(rng) for _ in range(4000)])
    # Four standard deviations of a share, and the deciles of those that are cut to 5% of the grid.
    assert abs(np.mean(shares == 1.0) - law.uncut) < 4 * 0.5 / np.sqrt(4000)
    deciles = np.quantile(shares[shares < 1.0], np.linspace(0.0, 1.0, len(law.quantiles)))
    np.testing.assert_allclose(deciles, law.quantiles, atol=0.05)


@pytest.mark.parametrize("count", [1, 400, 4999, 5000])
def test_cuts_leave_exactly_so_many_points_of_the_cloud_in_their_order(count):
    points = np.arange(5000.0)[:, None] + np.random.default_rng(4).uniform(0, 0.5, (5000, 3))
    kept = cut(np.random.default_rng(5), points, count)
    places = kept[:, 0].astype(int)
    assert len(kept) == count
    assert np.array_equal(kept, points[places]) and (np.diff(places) > 0).all()


def test_one_cut_leaves_one_side_of_a_plane(monkeypatch):
    monkeypatch.setattr(canonical, "MOST_CUTS", 1)
    points = np.random.default_rng(4).uniform(-1, 1, (5000, 3))
    kept = cut(np.random.default_rng(5), points, 3000)
    removed = points[~np.isin(points[:, 0], kept[:, 0])]
    rng = np.random.default_rng(5)
    rng.integers(1, 1, endpoint=True), rng.dirichlet([1.0]), rng.multinomial(2000, [1.0])
    direction = rng.standard_normal(3)
    assert len(removed) == 2000
    assert (kept @ direction).min() > (removed @ direction).max()


def test_half_of_the_spans_are_whole_and_the_others_lie_within():
    rng = np.random.default_rng(6)
    spans = np.array([span(rng, -1.0, 3.0) for _ in range(2000)])
    width = spans[:, 1] - spans[:, 0]
    assert spans.min() >= -1.0 and spans.max() <= 3.0
    # Four standard deviations of a share of one half among 2000; parts are uniform in 20 to 100 %.
    assert abs(np.mean(width == 4.0) - WHOLE_SPAN) < 0.045
    np.testing.assert_allclose(np.quantile(width[width < 4.0], [0.0, 0.5, 1.0]), [0.8, 2.4, 4.0], atol=0.2)


def test_a_range_is_ordered():
    with pytest.raises(ValueError, match="low <= high"):
        Range(2.0, 1.0)
