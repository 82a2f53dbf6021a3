"""The direct fits that methods end with."""

import tracemalloc

import numpy as np
import pytest

from primfit.fitting.cloud.normals import estimate_normals
from primfit.fitting.guesses.oriented import Oriented
from primfit.fitting.names import KINDS
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.paper.parts.circle import torus_about_circle
from primfit.paper.parts.least_squares import least_squares
from primfit.paper.parts.ransac_cone import ransac_cone
from primfit.paper.parts.sampled import sampled_error
from primfit.paper.parts.sampled_sphere import sampled_sphere
from tests.fitting.clouds import EXAMPLES, sample

LINE = np.outer(np.linspace(0.0, 1.0, 30), [1.0, 2.0, 3.0])


@pytest.mark.parametrize("kind", KINDS)
def test_least_squares_finds_exact_surfaces_with_and_without_a_start(kind):
    points = sample(EXAMPLES[kind], 500)
    for start in (None, EXAMPLES[kind]):
        found = least_squares(kind, points, start)
        assert found is not None and found.kind == kind
        assert np.abs(found.signed_distance(points)).max() < 1e-9


def test_least_squares_counts_every_point_alike():
    points = sample(EXAMPLES["plane"], 300)
    moved = np.vstack([points, points[:30] + EXAMPLES["plane"].normal])
    found = least_squares("plane", moved)
    center = moved.mean(axis=0)
    normal = np.linalg.svd(moved - center)[2][2]
    assert abs(found.normal @ normal) == pytest.approx(1.0)
    assert found.signed_distance(center[None])[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("points", [LINE, LINE[:2], LINE[:0], np.ones((20, 3))], ids=len)
def test_what_points_do_not_determine_is_not_fitted(kind, points):
    assert least_squares(kind, points) is None


def test_least_squares_takes_any_unit():
    points = sample(EXAMPLES["sphere"], 200)
    for scale in (1e-200, 1e200):
        found = least_squares("sphere", scale * points)
        assert found.radius / scale == pytest.approx(EXAMPLES["sphere"].radius)


def test_the_sampled_sphere_is_the_one_that_most_points_are_near_to():
    rng = np.random.default_rng(0)
    truth = Sphere([0.1, 0.0, -0.1], 0.4)
    directions = rng.normal(size=(400, 3))
    points = truth.center + 0.4 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    points[:20] += [0.0, 0.0, 0.5]
    found = sampled_sphere(points, np.random.default_rng(1))
    assert found.radius == pytest.approx(0.4, abs=0.02)
    assert np.linalg.norm(found.center - truth.center) < 0.03


def test_the_samples_of_a_large_cloud_are_not_all_held_at_once():
    points = sample(EXAMPLES["sphere"], 20_000)
    tracemalloc.start()
    try:
        sampled_sphere(points, np.random.default_rng(1))
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 20 * points.nbytes


def test_few_points_and_one_place_have_no_sampled_sphere():
    rng = np.random.default_rng(0)
    with np.errstate(all="ignore"):
        assert sampled_sphere(np.eye(3), rng) is None
        assert sampled_sphere(np.zeros((10, 3)), rng) is None


def test_a_cone_among_other_points_is_found():
    rng = np.random.default_rng(0)
    truth = Cone([0.0, 0.0, -0.4], [0.0, 0.0, 1.0], np.radians(30.0))
    points = truth.surface(rng.uniform(0.0, 6.0, 500), rng.uniform(0.1, 0.8, 500))
    points[:75] = rng.uniform(-0.5, 0.5, (75, 3))
    found = ransac_cone(Oriented(points, estimate_normals(points)), points, rng)
    assert found.half_angle == pytest.approx(truth.half_angle, abs=0.02)
    assert np.linalg.norm(found.apex - truth.apex) < 0.03


def test_two_points_make_no_cone():
    points = np.eye(3)[:2]
    assert ransac_cone(Oriented(points, points), points, np.random.default_rng(0)) is None


def test_the_torus_about_a_circle_has_the_mean_distance():
    rng = np.random.default_rng(0)
    truth = Torus([0.05, 0.0, 0.0], [0.1, 0.0, 1.0], 0.4, 0.08)
    points = truth.surface(*rng.uniform(0.0, 2.0 * np.pi, (2, 4000)))
    found = torus_about_circle(points)
    assert abs(found.axis @ truth.axis) > np.cos(np.radians(1.0))
    assert found.minor_radius == pytest.approx(0.08, rel=0.02)
    assert found.major_radius == pytest.approx(0.4, rel=0.03)
    assert torus_about_circle(points[:2]) is None


@pytest.mark.parametrize("kind", KINDS)
def test_the_sampled_error_of_the_truth_is_that_of_its_samples(kind):
    points = sample(EXAMPLES[kind], 300)
    coarse, fine = (sampled_error(EXAMPLES[kind], points, grid) for grid in (20, 80))
    assert 0.0 < fine < coarse / 2.5
    assert parameters(EXAMPLES[kind])["kind"] == kind
