"""What is drawn from a cloud, and so its answer, does not depend on how its points are listed or repeated."""

import numpy as np
import pytest

from primfit.fitting.cloud.order import canonical_order, canonical_sample, distance_keys, shuffled
from primfit.fitting.geometry.vectors import bounds
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import parameters
from primfit.fitting.recognize import recognize
from tests.fitting.clouds import EXAMPLES, noisy, rotation, sample

GRID = np.stack(np.meshgrid(*[np.arange(-4.0, 5.0)] * 3), axis=-1).reshape(-1, 3)
CLOUDS = pytest.mark.parametrize(
    "points", [noisy(EXAMPLES["torus"], 900, 0.02), GRID], ids=["noisy torus", "symmetric grid"]
)


def in_order(points: np.ndarray) -> np.ndarray:
    return canonical_order(points, distance_keys(points, bounds(points)))


def drawn(points: np.ndarray, count: int, seed: int, repeated: bool = False) -> np.ndarray:
    keys = distance_keys(points, bounds(points))
    return canonical_sample(points, keys, count, np.random.default_rng(seed), repeated)


def listed_anew(points: np.ndarray, seed: int = 5) -> np.ndarray:
    return points[np.random.default_rng(seed).permutation(len(points))]


@CLOUDS
def test_any_listing_is_put_in_the_same_order(points: np.ndarray) -> None:
    other = listed_anew(points)
    np.testing.assert_array_equal(points[in_order(points)], other[in_order(other)])


def test_turned_and_moved_points_are_put_in_the_same_order() -> None:
    points = noisy(EXAMPLES["torus"], 900, 0.02)
    moved = 3.0 * points @ rotation(2).T + 40.0
    np.testing.assert_array_equal(in_order(points), in_order(moved))


@CLOUDS
def test_any_listing_gives_the_same_sample(points: np.ndarray) -> None:
    other = listed_anew(points)
    one, two = (each[drawn(each, 100, 8)] for each in (points, other))
    np.testing.assert_array_equal(one, two)
    assert len(np.unique(one, axis=0)) == 100


def test_another_seed_gives_another_sample_and_all_parts_are_drawn_alike() -> None:
    points = np.random.default_rng(0).normal(size=(20_000, 3))
    one, two = (drawn(points, 5000, seed) for seed in (1, 2))
    assert 1000 < len(np.intersect1d(one, two)) < 1500, "a quarter of a quarter would be 1250"
    quarters = np.searchsorted(np.quantile(points[:, 0], [0.25, 0.5, 0.75]), points[one, 0])
    assert np.bincount(quarters) == pytest.approx(1250, abs=150)


@pytest.mark.parametrize("kind", KINDS)
def test_any_listing_gives_the_same_answer_to_the_last_bit(kind: str) -> None:
    points = noisy(EXAMPLES[kind], 1200, 0.01)
    one, two = (recognize(each).primitive for each in (points, listed_anew(points)))
    assert one is not None and two is not None
    assert parameters(one) == parameters(two)


def test_normals_and_weights_follow_their_points() -> None:
    points = noisy(EXAMPLES["cylinder"], 900, 0.01)
    normals = EXAMPLES["cylinder"].gradient(points)
    weights = np.random.default_rng(1).uniform(0.5, 2.0, len(points))
    order = np.random.default_rng(5).permutation(len(points))
    one = recognize(points, normals=normals, weights=weights).primitive
    two = recognize(points[order], normals=normals[order], weights=weights[order]).primitive
    assert one is not None and two is not None
    assert parameters(one) == parameters(two)


def test_a_listing_of_a_large_cloud_does_not_show() -> None:
    """Over 20,000 points a sample is searched; sums over all points round differently."""
    points = sample(EXAMPLES["sphere"], 30_000) + np.random.default_rng(3).normal(0.0, 0.01, (30_000, 3))
    one, two = (recognize(each).primitive for each in (points, listed_anew(points)))
    assert one is not None and two is not None
    assert np.abs(one.signed_distance(points) - two.signed_distance(points)).max() < 1e-12


@pytest.mark.parametrize(
    ("kind", "n"), [*((kind, n) for kind in KINDS for n in (900, 15_000)), ("torus", 30_000)]
)
def test_repeated_points_change_nothing(kind: str, n: int) -> None:
    """15,000 points twice are more than are searched in a whole."""
    points = noisy(EXAMPLES[kind], n, 0.01)
    points[: n // 10] = np.random.default_rng(2).uniform(-3.0, 3.0, (n // 10, 3))
    one, two = (recognize(each) for each in (points, listed_anew(np.vstack([points, points]))))
    assert one.primitive is not None and two.primitive is not None
    assert np.abs(one.primitive.signed_distance(points) - two.primitive.signed_distance(points)).max() < 1e-9
    assert [attempt.outcome for attempt in one.attempts] == [attempt.outcome for attempt in two.attempts]


def test_a_sample_is_one_of_the_different_points() -> None:
    points = np.random.default_rng(0).normal(size=(500, 3))
    thrice = listed_anew(np.vstack([points, points, points]))
    one, two = (drawn(each, 400, 8) for each in (points, thrice))
    np.testing.assert_array_equal(points[one], thrice[two])
    np.testing.assert_array_equal(
        np.sort(thrice[drawn(thrice, 600, 8)], axis=0),
        np.sort(points, axis=0),
    )
    some = thrice[drawn(thrice, 600, 8, repeated=True)]
    assert len(np.unique(some, axis=0)) < len(some) == 600


def test_points_that_come_and_go_leave_the_others_in_their_random_order() -> None:
    keys = np.sort(np.random.default_rng(0).integers(0, 400, 1000).astype(np.uint64))
    order = keys[shuffled(keys, 1000, np.random.default_rng(1))]
    without = np.delete(keys, np.flatnonzero(keys == keys[500])[-1])
    np.testing.assert_array_equal(
        order[order != keys[500]],
        (left := without[shuffled(without, 999, np.random.default_rng(1))])[left != keys[500]],
    )
    same = shuffled(np.zeros(1000, np.uint64), 1000, np.random.default_rng(1))
    assert abs(np.corrcoef(same, np.arange(1000))[0, 1]) < 0.1
    np.testing.assert_array_equal(np.sort(same), np.arange(1000))
