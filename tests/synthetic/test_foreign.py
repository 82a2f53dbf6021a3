"""Foreign shapes: their points and normals belong together, and they are seen from outside."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from primfit.synthetic import RECIPES, ForeignRecipe, cloud, clouds
from primfit.synthetic.foreign import LARGEST_PART, PARTS, SURFACES, largest_share, seen
from primfit.synthetic.recipes import SHAPES, Range

DEFAULT = RECIPES["foreign"]


@pytest.mark.parametrize("shape", SURFACES)
def test_normals_are_those_of_the_surface(shape):
    for seed in range(3):
        points, normals = SURFACES[shape](np.random.default_rng(seed), 20_000)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-12)
        _, near = cKDTree(points).query(points[:300], k=12)
        offsets = points[near] - points[:300, None]
        local = np.linalg.svd(offsets - offsets.mean(axis=1, keepdims=True))[2][:, 2]
        # Neighbours across an edge of a box or of a flat cap have no common normal.
        assert np.median(np.abs(np.einsum("ij,ij->i", local, normals[:300]))) > 0.999


@pytest.mark.parametrize("shape", SURFACES)
def test_only_what_faces_a_station_is_seen(shape):
    view = seen(np.random.default_rng(1), shape, 500)
    assert len(view.points) == 500
    assert len(np.unique(view.points, axis=0)) == 500
    assert view.cosines.min() > 0.08
    np.testing.assert_allclose(
        view.stations[view.station] + view.distances[:, None] * view.rays, view.points, atol=1e-9
    )


@pytest.mark.parametrize("shape", PARTS)
def test_no_surface_of_several_has_over_three_quarters(shape):
    for seed in range(40):
        view = seen(np.random.default_rng(seed), shape, 400)
        assert largest_share(PARTS[shape](view.points)) <= LARGEST_PART == 0.75


def test_the_parts_of_a_shape_are_its_surfaces():
    """Points of one part have normals of one face, or of the side, or of one end."""
    points, normals = SURFACES["corner"](np.random.default_rng(0), 500)
    for face in range(3):
        assert np.ptp(normals[PARTS["corner"](points) == face], axis=0).max() == 0.0
    for seed in range(4):
        points, normals = SURFACES["capped_cylinder"](np.random.default_rng(seed), 500)
        part = PARTS["capped_cylinder"](points)
        assert set(part) == {-1, 0, 1} and np.array_equal(part == 0, normals[:, 2] == 0.0)
        assert np.array_equal(np.sign(normals[:, 2]), part)


def test_a_corner_shows_more_than_one_face():
    for seed in range(20):
        view = seen(np.random.default_rng(seed), "corner", 400)
        faces = np.sort((np.abs(view.points) < 1e-12).sum(axis=0))
        assert faces[1] >= 20


def test_capped_cylinders_show_a_cap():
    for seed in range(20):
        view = seen(np.random.default_rng(seed), "capped_cylinder", 400)
        on_side = np.abs(np.hypot(view.points[:, 0], view.points[:, 1]) - 1.0) < 1e-9
        assert np.count_nonzero(~on_side) >= 12


def test_shapes_take_turns_and_have_no_truth():
    drawn = list(clouds(DEFAULT, 60))
    assert Counter(c.kind for c in drawn) == dict.fromkeys(SHAPES, 10)
    assert all(c.primitive is None and c.family == "foreign" for c in drawn)
    assert all(200 <= len(c.points) <= 10_000 and np.isfinite(c.points).all() for c in drawn)
    assert all(1e-4 <= c.noise / c.extent <= 0.01 * (1 + 1e-9) for c in drawn)
    assert all(c.outlier_share <= 0.1 + 1e-3 for c in drawn)


def test_a_cloud_depends_on_recipe_and_index_only():
    for index in range(len(SHAPES)):
        again = cloud(ForeignRecipe(), index)
        assert np.array_equal(cloud(DEFAULT, index).points, again.points)
        assert not np.array_equal(cloud(replace(DEFAULT, seed=2), index).points, again.points)


def test_two_primitives_share_the_points():
    recipe = ForeignRecipe(shapes=("two_primitives",), points=Range(400, 600), without_outliers=1.0)
    for c in clouds(recipe, 12):
        assert 0.25 < np.mean(c.station == 0) < 0.75


def test_recipes_refuse_unknown_shapes():
    with pytest.raises(ValueError, match="shapes must be some of"):
        ForeignRecipe(shapes=("teapot",))
