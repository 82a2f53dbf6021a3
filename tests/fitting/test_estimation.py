"""The parts of the estimator one by one: frame, normals, axes, kernels, noise, search."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from primfit.fitting.cloud.cloud import Cloud
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.cloud.normals import estimate_normals
from primfit.fitting.geometry.axes import DIRECTION_GRID, axis_directions, circles, revolution_axis
from primfit.fitting.noise.exact import exact_points
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.noise.rounding import rounding_of
from primfit.fitting.noise.scale import core_scale, is_normal
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.search.anneal import anneal
from primfit.fitting.search.kind import Fit, fit_kind
from primfit.fitting.solver.refine import refine, stepped
from primfit.fitting.trial.trial import Trial
from tests.fitting.clouds import EXAMPLES, noisy, sample

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


@pytest.mark.parametrize("scale", [1e-300, 1e-12, 1e-4, 1.0, 1e4, 1e9, 1e90])
def test_the_frame_centres_and_scales_without_rounding(scale: float) -> None:
    points = scale * sample(EXAMPLES["cylinder"], 500)
    frame = Frame.of(points)
    inside = frame.normalize(points)
    assert np.abs(inside.mean(axis=0)).max() < 1e-9
    assert 0.5 < np.sqrt(np.mean(np.sum(inside**2, axis=1))) < 2.0
    assert np.log2(frame.scale) == np.round(np.log2(frame.scale))


def test_the_frame_subtracts_a_far_origin_exactly() -> None:
    points = np.round(sample(EXAMPLES["sphere"], 300) * 1024) / 1024 + 2.0**20
    frame = Frame.of(points)
    np.testing.assert_array_equal(frame.normalize(points) * frame.scale + frame.center, points)


@examples
def test_normals_follow_the_surface(primitive: Primitive) -> None:
    points = sample(primitive, 4000)
    agreement = np.abs(np.einsum("ij,ij->i", estimate_normals(points), primitive.gradient(points)))
    assert np.median(agreement) > 0.999


@pytest.mark.parametrize("kind", ["cone", "torus", "cylinder"])
def test_the_axis_is_among_the_candidates(kind: str) -> None:
    primitive = EXAMPLES[kind]
    points = sample(primitive, 400)
    directions = axis_directions(points, primitive.gradient(points))
    assert np.abs(directions @ primitive.axis).max() > 0.999  # type: ignore[attr-defined]


def test_the_revolution_axis_survives_a_third_of_wrong_normals() -> None:
    torus = EXAMPLES["torus"]
    points, rng = sample(torus, 600), np.random.default_rng(0)
    normals = torus.gradient(points)
    normals[:200] = rng.normal(size=(200, 3))
    normals[:200] /= np.linalg.norm(normals[:200], axis=1)[:, None]
    line = revolution_axis(points, normals, rounds=30)
    assert abs(line.direction @ torus.axis) > 0.9999  # type: ignore[attr-defined]
    across = np.cross(line.point - torus.center, torus.axis)  # type: ignore[attr-defined]
    assert np.linalg.norm(across) < 0.02


def test_the_direction_grid_leaves_no_wide_gap() -> None:
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(20_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    closest = np.degrees(np.arccos(np.clip(np.abs(directions @ DIRECTION_GRID.T).max(axis=1), 0.0, 1.0)))
    assert closest.max() < 28.0


def test_circles_shrug_off_a_fifth_of_outliers() -> None:
    rng = np.random.default_rng(1)
    angle = rng.uniform(0.0, 4.0, 200)
    x, y = 2.0 + 0.7 * np.cos(angle), -1.0 + 0.7 * np.sin(angle)
    x[:40], y[:40] = rng.uniform(0.0, 4.0, 40), rng.uniform(-3.0, 1.0, 40)
    found = np.ravel(circles(x[None], y[None]))
    np.testing.assert_allclose(found, [2.0, -1.0, 0.7], atol=0.2)


@pytest.mark.parametrize("kernel", Kernel, ids=lambda kernel: kernel.name.lower())
def test_weights_are_the_derivative_of_the_cost(kernel: Kernel) -> None:
    x = np.linspace(0.01, 8.0, 200)
    slope = (kernel.rho((x + 1e-6) ** 2) - kernel.rho((x - 1e-6) ** 2)) / 2e-6
    np.testing.assert_allclose(kernel.weight(x**2), slope / x, atol=1e-6)
    assert kernel.weight(np.zeros(1))[0] == 1.0


@examples
def test_refine_agrees_with_scipy(primitive: Primitive) -> None:
    """The same minimum as `scipy.optimize.least_squares` finds from the truth, on noisy points."""
    points = noisy(primitive, 300, 0.03)
    center = points.mean(axis=0)
    start = primitive.transformed(np.eye(3), -center, 1.0)
    ours = refine(start, points - center)
    theirs = least_squares(
        lambda step: stepped(start, step).signed_distance(points - center),
        np.zeros(primitive.dof),
        xtol=1e-14,
    )
    assert ours.cost <= theirs.cost * (1.0 + 1e-10)


@pytest.mark.parametrize(
    ("points", "expected"),
    [
        (np.round(sample(EXAMPLES["sphere"], 300), 3), 1e-3),
        (np.round(1e4 * sample(EXAMPLES["sphere"], 300)), 1.0),
        (np.round(sample(EXAMPLES["sphere"], 300), 3) + 5e5, 1e-3),
        (np.round(9.0 * sample(EXAMPLES["sphere"], 300) / 0.005) * 0.005, 0.005),
        (np.round(sample(EXAMPLES["sphere"], 300) / 0.00025) * 0.00025 + 0.0001, 0.00025),
        (4.0 * np.round(sample(EXAMPLES["sphere"], 300), 3), 0.004),
        (np.round(400.0 * sample(EXAMPLES["sphere"], 30_000) / 0.25) * 0.25, 0.25),
    ],
    ids=["decimals", "integers", "georeferenced", "five of a thousand", "offset", "scaled", "quarters"],
)
def test_quantised_coordinates_are_noticed(points: np.ndarray, expected: float) -> None:
    assert rounding_of(points).size == expected
    assert rounding_of(points).step == expected


def test_a_grid_has_the_step_of_all_its_points() -> None:
    grid = np.stack(np.meshgrid(np.arange(512.0), np.arange(512.0), [0.0]), axis=-1).reshape(-1, 3)
    assert rounding_of(grid).step == 1.0
    assert rounding_of(grid).size < 1e-2, "that is its lattice"


def test_the_resolution_of_full_and_single_precision() -> None:
    points = sample(EXAMPLES["sphere"], 300)
    assert rounding_of(points).size < 1e-13
    assert 1e-8 < rounding_of(points.astype(np.float32).astype(np.float64)).size < 1e-5
    lattice = np.stack(np.meshgrid(*[np.arange(6.0)] * 3), axis=-1).reshape(-1, 3)
    assert rounding_of(lattice).size < 1e-4


@pytest.mark.parametrize("outliers", [0, 1500])
def test_the_scale_is_that_of_the_core(outliers: int) -> None:
    rng = np.random.default_rng(0)
    distance = np.abs(rng.normal(0.0, 0.02, 5000))
    distance[:outliers] = rng.uniform(0.0, 3.0, outliers)
    assert core_scale(distance) == pytest.approx(0.02, rel=0.05)


def test_normal_noise_is_told_from_heavy_tails_outliers_and_uneven_noise() -> None:
    rng = np.random.default_rng(4)
    noise = rng.normal(0.0, 0.3, (40, 2000))
    uneven = noise * rng.uniform(0.3, 3.0, 2000)
    assert np.mean([is_normal(each, 6.0 * 0.3) for each in noise]) > 0.9
    assert not any(is_normal(each, 6.0 * 0.3) for each in uneven / 2.0)
    assert not is_normal(np.append(noise[0], 1.9), 1.8), "one point beyond the largest is an outlier"
    heavy = [np.clip(rng.standard_t(5, 2000), -8.0, 8.0) for _ in range(10)]
    assert not any(is_normal(each, 8.0) for each in heavy)
    assert not is_normal(np.zeros(10), 1.0), "of exact points nothing is known"


def test_least_squares_ends_the_robust_fit_where_the_noise_is_normal() -> None:
    """Isotropic noise has tails hardly heavier than normal ones; with outliers the biweight stays."""
    points = noisy(EXAMPLES["sphere"], 600, 0.01)
    rng = np.random.default_rng(0)

    def costs(cloud: Cloud) -> tuple[float, float]:
        fit = fit_kind(Trial("sphere", cloud), "least_squares", rng)
        assert isinstance(fit, Fit)
        each = (fit.primitive, fit.robust)
        return tuple(float(np.sum(p.signed_distance(cloud.points) ** 2)) for p in each)  # type: ignore[return-value]

    plain, robust = costs(Cloud.prepare(points, None, rng))
    assert robust == pytest.approx(plain, rel=1e-12)
    points[:20] += 0.5
    plain, robust = costs(Cloud.prepare(points, None, rng))
    assert robust > 1.01 * plain


def test_exact_points_are_told_from_accidents() -> None:
    rng = np.random.default_rng(0)
    noise = np.abs(rng.normal(0.0, 1.0, 1000))
    assert not exact_points(noise, 0.05, dof=5).any()
    half = noise.copy()
    half[:300] = 1e-16
    assert exact_points(half, 1e-13, dof=5).sum() == 300
    assert exact_points(np.zeros(6), 1e-13, dof=5).all()
    interpolated = noise.copy()
    interpolated[:5] = 0.0
    assert not exact_points(interpolated, 1e-13, dof=5).any()


def test_annealing_locks_on_a_quarter_of_exact_points() -> None:
    cylinder = EXAMPLES["cylinder"]
    points = sample(cylinder, 500)
    points[:375] += np.random.default_rng(3).uniform(-0.15, 0.15, (375, 3))
    cloud = Cloud.prepare(points, None, np.random.default_rng(0))
    start = refine(stepped(cloud.frame.bring(cylinder), np.full(5, 0.05)), cloud.working)
    found = anneal(Trial("cylinder", cloud), start.primitive.row(), cloud.working)
    assert found.exact_share == pytest.approx(0.25, abs=0.01)


@examples
def test_each_kind_is_fitted_to_its_own_exact_cloud(primitive: Primitive) -> None:
    rng = np.random.default_rng(0)
    points = sample(primitive, 700)
    cloud = Cloud.prepare(points, None, rng)
    found = fit_kind(Trial(primitive.kind, cloud), "robust", rng)
    assert isinstance(found, Fit)
    assert np.abs(cloud.frame.restore(found.primitive).signed_distance(points)).max() < 1e-13


@examples
def test_noise_costs_no_more_than_least_squares_on_the_truth(primitive: Primitive) -> None:
    """Robust refinement of a cloud without outliers is within a few per cent of the plain optimum."""
    rng = np.random.default_rng(0)
    points = noisy(primitive, 800, 0.01)
    cloud = Cloud.prepare(points, None, rng)
    fit = fit_kind(Trial(primitive.kind, cloud), "least_squares", rng)
    assert isinstance(fit, Fit)
    cost_robust, cost_plain = (
        np.sum(each.signed_distance(cloud.points) ** 2) for each in (fit.robust, fit.primitive)
    )
    assert cost_plain <= (1.0 + 1e-12) * cost_robust <= 1.01 * cost_plain


def test_a_third_of_gross_outliers_moves_a_cylinder_little() -> None:
    rng = np.random.default_rng(4)
    cylinder = EXAMPLES["cylinder"]
    points = noisy(cylinder, 900, 0.005)
    points[:300] = rng.uniform(points.min(axis=0) - 1.0, points.max(axis=0) + 1.0, (300, 3))
    cloud = Cloud.prepare(points, None, rng)
    found = fit_kind(Trial("cylinder", cloud), "robust", rng)
    assert isinstance(found, Fit) and isinstance(found.primitive, Cylinder)
    restored = cloud.frame.restore(found.primitive)
    assert restored.radius == pytest.approx(0.8, abs=0.005)
    assert abs(restored.axis @ cylinder.axis) > 0.9999  # type: ignore[attr-defined]
