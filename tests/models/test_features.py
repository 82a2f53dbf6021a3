"""Features: invariant, finite for poor input, and each block says what it should."""

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.models.features import (
    BLOCKS,
    N_FEATURES,
    PAIR_POINTS,
    SAMPLE_POINTS,
    features,
    normal_features,
    pair_features,
    representatives,
    shape_features,
)
from primfit.models.training.dataset import seen
from primfit.synthetic import BenchmarkRecipe, cloud
from primfit.synthetic.poses import rotation_about_axes
from tests.models import reference_features as reference

RECIPE = BenchmarkRecipe(seed=31)


def example(index):
    return seen(cloud(RECIPE, index), np.random.default_rng(index))


def blocks(row):
    parts = np.split(row, np.cumsum(list(BLOCKS.values()))[:-1])
    return dict(zip(BLOCKS, parts, strict=True))


@pytest.mark.parametrize("index", range(10))
def test_order_changes_no_bit(index):
    points, normals = example(index)
    order = np.random.default_rng(1).permutation(len(points))
    assert np.array_equal(features(points, normals), features(points[order], normals[order]))


def test_order_changes_no_bit_where_distances_to_the_centroid_are_equal():
    side = np.linspace(-1, 1, 31)
    points = np.stack(np.meshgrid(side, side, [0.0]), axis=-1).reshape(-1, 3)
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    order = np.random.default_rng(2).permutation(len(points))
    assert np.array_equal(features(points, normals), features(points[order], normals[order]))


@pytest.mark.parametrize("index", range(10))
def test_signs_of_normals_change_nothing(index):
    points, normals = example(index)
    signs = np.random.default_rng(3).choice([-1.0, 1.0], len(points))[:, None]
    np.testing.assert_allclose(features(points, signs * normals), features(points, normals), atol=1e-12)


@pytest.mark.parametrize("index", range(15))
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e4])
def test_rigid_motions_and_scale_change_rounding_only(index, scale):
    points, normals = example(index)
    rng = np.random.default_rng(4)
    # A generic cloud: no ties in the distances to the centroid that rounding could order anew.
    points = points + rng.normal(0, 1e-3, points.shape)
    rotation = rotation_about_axes(rng.uniform(0, 2 * np.pi, 3))
    moved = scale * (points @ rotation.T + rng.normal(0, 5, 3))
    before, after = blocks(features(points, normals)), blocks(features(moved, normals @ rotation.T))
    np.testing.assert_allclose(after["shape"], before["shape"], atol=1e-9)
    for name in ("normals", "pair_normals", "pair_directions"):
        # Values on the edge of a bin may fall on its other side, one or two in a histogram.
        assert np.abs(after[name] - before[name]).max() <= 2.0 / SAMPLE_POINTS
    np.testing.assert_allclose(after["gauss_map"], before["gauss_map"], atol=1e-6)
    # Planes and spheres have no axis of their own, so that rounding has a say in where their fits start.
    if KINDS[index % 5] not in ("plane", "sphere"):
        np.testing.assert_allclose(after["rough_fits"], before["rough_fits"], atol=1e-3)


def test_all_points_of_a_large_cloud_are_represented():
    points = np.random.default_rng(5).normal(size=(20_000, 3)) * [3.0, 2.0, 1.0]
    chosen, normals = representatives(points, points)
    assert chosen.shape == normals.shape == (SAMPLE_POINTS, 3)
    np.testing.assert_allclose(chosen.mean(axis=0), 0.0, atol=1e-12)
    assert np.mean(np.sum(chosen**2, axis=1)) == pytest.approx(1.0)
    spread = shape_features(chosen)
    np.testing.assert_allclose(spread / spread[2], [1 / 3, 2 / 3, 1.0], atol=0.06)


def test_normals_of_a_cylinder_avoid_its_axis_and_those_of_a_plane_are_one():
    angle = np.linspace(0, 2 * np.pi, 200, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    by_axis = normal_features(ring)[1].reshape(3, -1)
    assert by_axis[0, 0] == 1.0
    by_axis = normal_features(np.tile([0.0, 0.0, 1.0], (50, 1)))[1].reshape(3, -1)
    assert by_axis[2, -1] == 1.0 and by_axis[0, 0] == 1.0


def test_pairs_of_a_sphere_lie_on_one_curve():
    """On a sphere |d . n| = |x1 - x2| / 2r whatever the pair: far pairs never see a flank."""
    points = np.random.default_rng(6).normal(size=(60, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    _, directions = pair_features(points, points)
    by_distance = directions.reshape(-1, 4)
    assert by_distance.sum() == pytest.approx(1.0)
    # Distances in [4/3, 2) mean |d . n| in [2/3, 1).
    assert by_distance[:5, 2].sum() == 0.0
    assert by_distance[5:, 2].sum() > 0.3


def test_histograms_are_shares():
    parts = blocks(features(*example(3)))
    assert parts["normals"].reshape(3, -1).sum(axis=1) == pytest.approx([1.0] * 3)
    assert parts["pair_normals"].sum() == pytest.approx(1.0)
    assert parts["pair_directions"].sum() == pytest.approx(1.0)


@pytest.mark.parametrize("n", [3, 4, 7, 30])
@pytest.mark.parametrize("extent", [1e-12, 1.0, 1e9])
def test_small_flat_repeated_and_coplanar_clouds_have_finite_features(n, extent):
    rng = np.random.default_rng(n)
    line = np.outer(np.arange(n), [1.0, 0.0, 0.0])
    flat = rng.normal(size=(n, 3)) * [1.0, 1.0, 0.0]
    twice = np.repeat(rng.normal(size=(n, 3)), 2, axis=0)
    same = np.ones((n, 3))
    for points in (line, flat, twice, same, rng.normal(size=(n, 3))):
        normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        row = features(extent * points, normals)
        assert row.shape == (N_FEATURES,)
        assert np.isfinite(row).all()


@pytest.mark.parametrize("index", range(20))
def test_compiled_features_are_those_of_numpy(index):
    """But for a value at the edge of a bin, which may fall on its other side."""
    points, normals = example(index)
    if index >= 10:
        points, normals = points[: 2 * index], normals[: 2 * index]
    chosen, its_normals = reference.representatives(points, normals)
    for found, expected in zip(representatives(points, normals), (chosen, its_normals), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(shape_features(chosen), reference.shape_features(chosen), atol=1e-8)
    values, shares = normal_features(its_normals)
    np.testing.assert_allclose(values, reference.gauss_map_features(its_normals), atol=1e-10)
    assert np.abs(shares - reference.normal_features(its_normals)).max() <= 1.0 / len(chosen)
    n = min(len(chosen), PAIR_POINTS)
    for found, expected in zip(
        pair_features(chosen, its_normals), reference.pair_features(chosen, its_normals), strict=True
    ):
        assert np.abs(found - expected).max() <= 2.0 / (n * (n - 1))


def test_kinds_differ():
    """The middle of each kind is farther from the others than rounding would explain."""
    rows = np.array([features(*example(index)) for index in range(50)])
    middles = np.array([rows[kind::5].mean(axis=0) for kind in range(len(KINDS))])
    gaps = np.linalg.norm(middles[:, None] - middles[None], axis=-1)
    assert gaps[np.triu_indices(5, 1)].min() > 0.1
