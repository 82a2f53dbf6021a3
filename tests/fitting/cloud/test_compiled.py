"""What is compiled is what `reference` defines, on clouds of all sorts."""

import numpy as np
import pytest

from primfit.fitting.cloud import _passes, _pieces
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.cloud.normals import local_planes
from primfit.fitting.cloud.order import canonical_order, distance_keys, shuffled
from primfit.fitting.cloud.patches import Halved
from primfit.fitting.geometry.vectors import bounds, principal
from primfit.fitting.noise.rounding import rounding_of
from primfit.synthetic import BenchmarkRecipe, ScannerRecipe, SensorRecipe, cloud
from tests.fitting.cloud import reference
from tests.fitting.clouds import EXAMPLES, noisy

GRID = np.stack(np.meshgrid(*[np.arange(-4.0, 5.0)] * 3), axis=-1).reshape(-1, 3)
CLOUDS = {
    "noise": np.random.default_rng(0).normal(size=(3001, 3)) * [3.0, 2.0, 0.01],
    "a few points": np.random.default_rng(1).normal(size=(5, 3)),
    "tiny and far": 1e-6 * noisy(EXAMPLES["torus"], 700, 0.01) + [3.0, -2.0, 5.0],
    "grid": GRID,
    "repeated": np.repeat(noisy(EXAMPLES["cone"], 200, 0.02), 3, axis=0),
    "single precision": noisy(EXAMPLES["sphere"], 900, 0.01).astype(np.float32).astype(np.float64),
    "millimeters": np.round(noisy(EXAMPLES["cylinder"], 900, 0.01), 3),
    "huge": 1e90 * noisy(EXAMPLES["sphere"], 100, 0.01),
    "large": noisy(EXAMPLES["cylinder"], 25_000, 0.01),
} | {
    f"{type(recipe).__name__} {index}": np.ascontiguousarray(cloud(recipe, index).points)
    for recipe in (BenchmarkRecipe(seed=7), ScannerRecipe(seed=7), SensorRecipe(seed=7))
    for index in range(4)
}
every_cloud = pytest.mark.parametrize("points", CLOUDS.values(), ids=CLOUDS.keys())


@every_cloud
def test_keys_orders_and_samples(points: np.ndarray) -> None:
    keys = distance_keys(points, bounds(points))
    expected = reference.distance_keys(points)
    assert np.mean(keys != expected) < 0.01, "a key at the edge may round the other way"
    order = canonical_order(points, keys)
    np.testing.assert_array_equal(points[order], points[np.lexsort((*points.T[::-1], keys))])
    ordered = keys[order]
    np.testing.assert_array_equal(
        shuffled(ordered, 300, np.random.default_rng(3)),
        reference.shuffled(ordered, np.random.default_rng(3))[:300],
    )
    np.testing.assert_array_equal(
        _passes.firsts(points[order]),
        np.flatnonzero(np.append(True, (points[order][1:] != points[order][:-1]).any(axis=1))),
    )


@pytest.mark.parametrize("n", [0, 1, 2, 300, 40_000])
@pytest.mark.parametrize("values", [1, 3, 2**20, 2**63])
def test_the_smallest_hashes_and_all_in_order(n: int, values: int) -> None:
    """Also of hashes that are not spread evenly, so that what is below the first guess is too little."""
    keys = np.random.default_rng(n).integers(0, values, n, dtype=np.uint64) << np.uint64(1)
    keys += np.uint64(2**64 - 2 * values)
    expected = np.argsort(keys, kind="stable")
    order, ties = _passes.sorted_places(keys)
    np.testing.assert_array_equal(order, expected)
    assert ties == (len(np.unique(keys)) < n)
    for count in (1, 256, 20_000):
        np.testing.assert_array_equal(_passes.smallest(keys, count), expected[:count])
        spread = _passes.hashed(np.arange(n, dtype=np.uint64), 12345)
        np.testing.assert_array_equal(_passes.smallest(spread, count), np.argsort(spread)[:count])


def test_hashes() -> None:
    keys = np.random.default_rng(0).integers(0, 2**64 - 1, 1000, dtype=np.uint64)
    np.testing.assert_array_equal(_passes.hashed(keys, 2**63 - 25), reference.hashed(keys, 2**63 - 25))


@every_cloud
def test_bounds_and_frames(points: np.ndarray) -> None:
    np.testing.assert_array_equal(bounds(points), [points.min(axis=0), points.max(axis=0)])
    center, scale = reference.frame(points)
    frame = Frame.of(points)
    assert frame.scale == scale
    np.testing.assert_allclose(frame.center, center, rtol=0.0, atol=2.0 * np.spacing(np.abs(points).max()))
    np.testing.assert_array_equal(frame.normalize(points), (points - frame.center) / scale)
    np.testing.assert_array_equal(frame.normalize(points[0]), frame.normalize(points)[0])


@every_cloud
def test_principal_axes(points: np.ndarray) -> None:
    """Axes of either sign; those of extents that are hardly apart may be turned among themselves."""
    points = Frame.of(points).normalize(points)
    sizes, axes = principal(points)
    _, expected, _ = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)
    np.testing.assert_allclose(sizes * np.sqrt(len(points)), expected, atol=1e-13 * expected[0])
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-14)
    along = (points - points.mean(axis=0)) @ axes
    np.testing.assert_allclose(np.linalg.norm(along, axis=0), expected, atol=1e-13 * expected[0])


def test_a_thin_extent_is_told_to_the_rounding_of_the_widest() -> None:
    """The scatter would lose one below a 10^-8 of it."""
    points = np.random.default_rng(2).normal(size=(500, 3)) * [1.0, 1e-4, 1e-12]
    assert principal(points)[0][2] == pytest.approx(1e-12, rel=0.1)
    assert principal(points[:2])[0][1:] == pytest.approx(0.0, abs=1e-15)


@every_cloud
def test_patches_and_grains(points: np.ndarray) -> None:
    halved = Halved.of(points)
    if len(points) <= 64:
        assert np.array_equal(halved.patches(), np.arange(len(points)))
        assert np.array_equal(halved.grains(), np.arange(len(points)))
        return
    np.testing.assert_array_equal(halved.patches(), reference.halves(points, 6))
    depth = max(64, len(points) // 8).bit_length() - 1
    np.testing.assert_array_equal(halved.grains(), reference.halves(points, depth))


@every_cloud
@pytest.mark.parametrize("k", [3, 16, 40])
def test_normals_and_scatter(points: np.ndarray, k: int) -> None:
    """Wherever it is clear which points are the nearest, and which plane they lie about."""
    k = min(k, len(points))
    points = Frame.of(points).normalize(points)
    at = np.vstack([points[:200], points[:50] + 0.1, [[9.0, 9.0, 9.0]]])
    normals, *spread = local_planes(points, Halved.of(points), at, k)
    expected, *expected_spread = reference.local_planes(points, at, k)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-14)
    clear = np.flatnonzero(is_clear(points, at, k))
    for found, each in zip(spread, expected_spread, strict=True):
        np.testing.assert_allclose(found[clear], each[clear], rtol=1e-6, atol=1e-7)
    alike = np.abs(np.einsum("ij,ij->i", normals[clear], expected[clear]))
    np.testing.assert_allclose(alike, 1.0, atol=1e-12)


def is_clear(points: np.ndarray, at: np.ndarray, k: int) -> np.ndarray:
    squared = np.sort(((at[:, None] - points) ** 2).sum(axis=2), axis=1)
    apart = squared[:, k] - squared[:, k - 1] > 1e-12 * squared[:, k] if k < len(points) else np.True_
    near = points[np.argsort(((at[:, None] - points) ** 2).sum(axis=2), axis=1)[:, :k]]
    values = np.linalg.svd(near - near.mean(axis=1, keepdims=True), compute_uv=False) ** 2
    return apart & (values[:, 1] - values[:, 2] > 1e-3 * values[:, 0])


def test_scatter_far_below_the_spread_is_told() -> None:
    """Where eigenvalues by LAPACK are as good as the rounding of the largest, here the smallest."""
    points = np.random.default_rng(4).normal(size=(16, 3)) * [1.0, 1.0, 1e-8]
    scatter = local_planes(points, Halved.of(points), points[:1], 16)[1]
    sizes = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    assert scatter[0] == pytest.approx(sizes[2] / np.sqrt(13.0), rel=1e-6)


def test_a_point_on_many_is_among_as_many_neighbors_as_asked_for() -> None:
    points = np.vstack([np.zeros((500, 3)), np.eye(3), -np.eye(3)])
    normals, scatter, _ = local_planes(points, Halved.of(points), points[[0, 503]], 16)
    assert scatter[0] == 0.0 and np.isfinite(normals).all()


def test_of_neighbors_that_are_as_far_the_earlier_count() -> None:
    flat = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for last in (np.arange(4), np.array([0, 3, 2, 1])):
        normals = local_planes(flat[last], Halved.of(flat), flat[:1], 3)[0]
        assert abs(normals[0, last[3] - 1]) == 1.0


@every_cloud
def test_rounding(points: np.ndarray) -> None:
    found = rounding_of(points)
    assert (found.size, found.step) == reference.rounding(points)


def test_order_of_other_lengths_is_refused() -> None:
    with pytest.raises(ValueError, match="neighbors"):
        _pieces.local_planes(GRID, np.arange(5), 0, GRID, 16)
