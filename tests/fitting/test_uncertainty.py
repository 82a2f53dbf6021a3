"""Intervals and warnings: derivatives against differences, shares against counts, and what must be so."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares, minimize_scalar
from scipy.spatial.distance import cdist
from scipy.special import stdtrit

from primfit.benchmark.coverage import waves
from primfit.fitting.cloud.patches import patches_of
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives import names_of, values_of
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.solver.refine import stepped
from primfit.fitting.uncertainty.agreement import Agreement
from primfit.fitting.uncertainty.covariance import Linear
from primfit.fitting.uncertainty.intervals import spread
from primfit.fitting.uncertainty.values import Uncertainty
from tests.fitting.clouds import EXAMPLES, noisy, sample

KINDS = tuple(EXAMPLES)


def known(points: Array, kind: str, **options: object) -> Uncertainty:
    found = recognize(points, Config(kinds=(kind,), **options)).uncertainty
    assert found is not None
    return found


def codes(found: Uncertainty) -> set[str]:
    return {warning.code for warning in found.warnings}


def arc(degrees: float, n: int, sigma: float, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    half = np.radians(degrees) / 2
    cylinder = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    points = cylinder.surface(rng.uniform(-half, half, n), rng.uniform(-1.0, 1.0, n))
    return points + sigma * rng.standard_normal((n, 1)) * cylinder.gradient(points)


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_of_the_numbers_are_their_differences(kind: str) -> None:
    center, step = np.array([0.3, -0.2, 0.1]), 1e-6
    surface = EXAMPLES[kind].canonical(np.zeros(3))
    found = surface.derivative(center)
    for i, unit in enumerate(step * np.eye(surface.dof)):
        ends = [values_of(stepped(surface, sign * unit).canonical(center)) for sign in (1.0, -1.0)]
        np.testing.assert_allclose(found[:, i], (ends[0] - ends[1]) / (2.0 * step), atol=1e-8)


@pytest.mark.parametrize("kernel", Kernel)
def test_the_slope_of_a_kernel_is_that_of_its_pull(kernel: Kernel) -> None:
    x, step = np.array([0.0, 0.3, 0.9, 1.7, 4.0, 5.5, 7.0]), 1e-6
    pulls = [kernel.weight((x + sign * step) ** 2) * (x + sign * step) for sign in (1.0, -1.0)]
    np.testing.assert_allclose(kernel.slope(x**2), (pulls[0] - pulls[1]) / (2.0 * step), atol=1e-8)


@pytest.mark.parametrize("ratio", [0.0, 0.35, 1.0])
def test_the_radius_of_a_spread_holds_95_of_100_offsets(ratio: float) -> None:
    offsets = np.random.default_rng(0).standard_normal((400_000, 2)) * [2.0, 2.0 * ratio]
    radius = spread(np.diag([4.0, (2.0 * ratio) ** 2]), 1.959964).radius_95
    # a share of 0.95 among 400,000 is known to 0.0004
    assert np.mean(np.linalg.norm(offsets, axis=1) <= radius) == pytest.approx(0.95, abs=0.0015)


@pytest.mark.parametrize("kind", KINDS)
def test_most_intervals_hold_the_truth(kind: str) -> None:
    truth, held = EXAMPLES[kind], []
    names = names_of(kind)
    for seed in range(20):
        found = recognize(noisy(truth, 400, 0.01, seed), Config(kinds=(kind,)))
        assert found.uncertainty and found.primitive
        center = noisy(truth, 400, 0.01, seed).mean(axis=0)
        true = dict(zip(names, values_of(truth.canonical(center)), strict=True))
        held += [each.low <= true[name] <= each.high for name, each in found.uncertainty.intervals.items()]
    # 5 % are missed; if the numbers of a cloud went all together, 0.85 would be two standard errors below
    assert np.mean(held) >= 0.85


@pytest.mark.parametrize("kind", KINDS)
def test_uncertainty_moves_and_scales_with_the_cloud(kind: str) -> None:
    points = noisy(EXAMPLES[kind], 500, 0.01)
    here, there = known(points, kind), known(1024.0 * points + [3e4, -1e4, 5e3], kind)
    for name, interval in here.intervals.items():
        factor = 1.0 if name == "half_angle" else 1024.0
        assert there.intervals[name].standard_deviation == pytest.approx(
            factor * interval.standard_deviation, rel=1e-4
        )
    assert there.covariance is not None and here.covariance is not None
    assert np.all(np.linalg.eigvalsh(here.covariance) > -1e-12 * np.trace(here.covariance))


def test_uneven_noise_is_weighed_where_it_is() -> None:
    """Noise on one side only makes the centre uncertain along that side."""
    rng, sphere = np.random.default_rng(1), Sphere([0.0, 0.0, 0.0], 1.0)
    points = rng.standard_normal((3000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    sigma = np.where(np.abs(points[:, 2]) > 0.7, 0.02, 0.002)
    found = known(points + (sigma * rng.standard_normal(3000))[:, None] * sphere.gradient(points), "sphere")
    along, across = (found.intervals[f"center.{axis}"].standard_deviation for axis in "zx")
    assert along > 2.0 * across


def test_correlated_noise_is_found_and_counts() -> None:
    points = sample(EXAMPLES["cylinder"], 2000)
    rng, outward = np.random.default_rng(2), EXAMPLES["cylinder"].gradient(points)
    smooth = known(points + 0.005 * waves(rng, points / 0.15)[:, None] * outward, "cylinder")
    rough = known(points + 0.005 * rng.standard_normal((2000, 1)) * outward, "cylinder")
    assert (smooth.noise_model, rough.noise_model) == ("correlated", "independent")
    assert smooth.correlation is not None and 0.1 < smooth.correlation.length < 0.22
    assert "correlated_noise" in codes(smooth) and "correlated_noise" not in codes(rough)
    radii = [each.intervals["radius"].standard_deviation for each in (smooth, rough)]
    assert radii[0] > 2.0 * radii[1]


def flat(n: int, rng: np.random.Generator) -> tuple[Linear, Array]:
    """A cost of a plane over the unit square, linearised about it, with pulls of unit noise; feet (n, 3)."""
    feet = rng.uniform(0.0, 1.0, (n, 3)) * [1.0, 1.0, 0.0]
    rows = np.column_stack([np.ones(n), feet[:, :2]])
    left = rng.standard_normal(n)
    return Linear(feet, rows, np.eye(3), left, left, np.ones(n), np.ones(n), 1.0), feet


def test_few_inliers_scatter_by_their_distances_whatever_the_kernel_keeps() -> None:
    linear, _ = flat(20, np.random.default_rng(3))
    inlier = np.arange(20) < 15
    found = replace(linear, pull=0.1 * linear.pull).equal(inlier)
    left = np.where(inlier, 1.0, 0.1) * linear.distance
    assert found is not None and found.noise == pytest.approx(np.sqrt(left @ left / 17))


def test_without_fields_the_covariance_is_the_sandwich() -> None:
    linear, _ = flat(300, np.random.default_rng(3))
    found, bread = linear.uneven(None), np.linalg.inv(linear.rows.T @ linear.rows)
    own = linear.pull**2 / (1.0 - np.sum((linear.rows @ bread) * linear.rows, axis=1))
    assert found is not None and found.effective_points == 300
    expected = bread @ linear.rows.T @ np.diag(own) @ linear.rows @ bread
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-9)


def two_fields(patch: np.ndarray, seen: np.ndarray, reach: float) -> Agreement:
    """Half of the noise is each point's own; beside it a rough field of 0.2 and a smooth one; extent 2."""
    alone = [np.array([each]) for each in (1.0, 0.5, 3.0, 0.1, 2.0, reach / 2.0)]
    return Agreement(patch, seen, 2.0, *alone, None)


def test_fields_count_as_in_the_double_sum_over_patches() -> None:
    linear, feet = flat(300, np.random.default_rng(3))
    patch, seen = patches_of(feet), np.arange(300) % 7 > 0
    agreement = two_fields(patch, seen, 0.4)
    middle = np.array([feet[seen & (patch == each)].mean(axis=0) for each in patch])
    apart = cdist(middle, middle)
    covariance = 3.0 * np.exp(-apart / 0.2) + 2.0 * np.exp(-((apart / 0.4) ** 2) / 2.0)
    rows = linear.rows * seen[:, None]
    independent = linear.rows.T @ linear.rows
    meat = 0.5 * independent + rows.T @ covariance @ rows
    np.testing.assert_allclose(agreement.meats(independent, linear.rows, feet), [meat], rtol=1e-9)
    alone, found = linear.uneven(None), linear.uneven(agreement)
    assert alone is not None and found is not None
    bread = np.linalg.inv(linear.rows.T @ linear.rows)
    expected = 0.5 * alone.matrix + bread @ rows.T @ covariance @ rows @ bread
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-6)  # the halvings of a quantile


def test_a_bow_as_wide_as_the_cloud_has_no_mean() -> None:
    """So that it moves no plane along its normal, whose rows are 1."""
    linear, feet = flat(300, np.random.default_rng(3))
    seen = np.ones(300, bool)
    narrow, wide = (
        two_fields(patches_of(feet), seen, reach).meats(np.zeros((3, 3)), linear.rows, feet)[0]
        for reach in (0.4, 2.0)
    )
    rough = replace(two_fields(patches_of(feet), seen, 2.0), smooth=np.zeros(1))
    left = wide - rough.meats(np.zeros((3, 3)), linear.rows, feet)[0]
    assert abs(left[0, 0]) < 1e-9 * narrow[0, 0] and left[1, 1] > 0.0


def square(noise: Callable[[np.random.Generator, Array], Array], seed: int) -> tuple[Array, Array]:
    """Points (900, 3) of a unit square under noise of 0.002 by some law, and the same without noise."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-0.5, 0.5, (900, 3)) * [1.0, 1.0, 0.0]
    return places + np.outer(0.002 * noise(rng, places), [0.0, 0.0, 1.0]), places


def test_under_exponential_noise_intervals_are_as_much_longer_as_the_variance_of_the_mean() -> None:
    """Of noise with the correlation exp(-h / 0.1) the mean varies by the mean of it over all pairs."""

    def noise(rng: np.random.Generator, places: Array) -> Array:
        correlation = np.exp(-cdist(places, places) / 0.1)
        return np.linalg.cholesky(correlation + 1e-9 * np.eye(900)) @ rng.standard_normal(900)

    ratios = []
    for seed in range(10):
        points, places = square(noise, seed)
        found = known(points, "plane")
        assert found.position is not None and found.noise_model == "correlated"
        true = 0.002 * np.sqrt(np.exp(-cdist(places, places) / 0.1).mean())
        ratios.append(found.position.standard_deviations[0] / true)
    # ranges are a factor of three apart, in which the deviation of a mean goes with the range
    assert 0.7 < np.exp(np.mean(np.log(ratios))) < 3.0


def test_a_bow_of_half_the_noise_makes_intervals_longer() -> None:
    def bowed(rng: np.random.Generator, places: Array) -> Array:
        along = places[:, 0] ** 2
        return np.asarray(rng.standard_normal(900) + (along - along.mean()) / along.std() / 2.0)

    flat, bent = (
        known(square(noise, 1)[0], "plane").direction
        for noise in (lambda rng, places: rng.standard_normal(len(places)), bowed)
    )
    assert flat is not None and bent is not None
    # a plane is tilted by noise as the mean, over the root mean square of a coordinate; a bow may tilt it by
    # as much as it rises, half the noise over the same
    tilt = 0.002 * np.sqrt(12.0)
    assert flat.standard_deviations[0] < 1.5 * tilt / np.sqrt(900) < tilt / 2.0 < bent.standard_deviations[0]


def test_a_short_arc_is_profiled_and_leaves_the_larger_radius_open_wider() -> None:
    found = known(arc(25.0, 300, 0.008, 0), "cylinder")
    radius = found.intervals["radius"]
    assert radius.method == "profile" and radius.low is not None and radius.high is not None
    middle = recognize(arc(25.0, 300, 0.008, 0), Config(kinds=("cylinder",))).primitive.radius
    assert radius.high - middle > 1.1 * (middle - radius.low)
    assert {"short_arc", "weak_size"} <= codes(found)
    assert "25 degrees" in next(each.message for each in found.warnings if each.code == "short_arc")


def test_the_ends_of_a_profile_are_those_of_an_independent_optimiser() -> None:
    """At each end of the radius the best cylinder of that radius costs so much more, found by SciPy."""
    points = arc(40.0, 150, 0.02, seed=3)
    found = known(points, "cylinder", criterion="least_squares")

    def cost(radius: float) -> float:
        def residuals(x: Array) -> Array:
            axis = np.array([x[0], x[1], 1.0])
            across = np.cross(points - [x[2], x[3], 0.0], axis / np.linalg.norm(axis))
            return np.asarray(np.linalg.norm(across, axis=1) - radius)

        return float(least_squares(residuals, [0.0, 0.0, 1.0 - radius, 0.0], xtol=1e-12, ftol=1e-12).cost)

    best = minimize_scalar(cost, bracket=(0.8, 1.0), options={"xtol": 1e-8})
    rise = best.fun * stdtrit(len(points) - 5, 0.975) ** 2 / (len(points) - 5)
    interval = found.intervals["radius"]
    assert interval.method == "profile"
    low = brentq(lambda radius: cost(radius) - best.fun - rise, 0.3 * best.x, best.x)
    high = brentq(lambda radius: cost(radius) - best.fun - rise, best.x, 5.0 * best.x)
    np.testing.assert_allclose([interval.low, interval.high], [low, high], rtol=0.01)


def test_an_arc_that_looks_flat_has_no_upper_end() -> None:
    radius = known(arc(8.0, 100, 0.004, 3), "cylinder").intervals["radius"]
    assert radius.high is None and radius.low is not None


@pytest.mark.parametrize("scale", [1e-12, 1e12])
def test_what_is_held_does_not_depend_on_the_unit(scale: float) -> None:
    found = known(scale * noisy(EXAMPLES["cone"], 500, 0.01), "cone")
    assert {interval.method for interval in found.intervals.values()} <= {"linear", "profile"}


def test_a_surface_that_the_points_leave_open_has_no_intervals() -> None:
    found = known(arc(8.0, 100, 0.004, 4), "cylinder")
    assert found.covariance is None and codes(found) >= {"undetermined"}


def test_an_axis_that_a_belt_leaves_open_is_a_right_angle_off_at_most() -> None:
    rng, cylinder = np.random.default_rng(1), Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 1.0)
    belt = cylinder.surface(rng.uniform(-np.pi, np.pi, 40), rng.uniform(-0.02, 0.02, 40))
    found = known(belt + 0.02 * rng.standard_normal((40, 1)) * cylinder.gradient(belt), "cylinder")
    assert found.direction is not None and found.direction.radius_95 == np.pi / 2
    assert "the axis is not determined" in [each.message for each in found.warnings]


def test_fixed_numbers_are_held_and_help_the_others() -> None:
    points = noisy(EXAMPLES["cylinder"], 400, 0.01)
    free = known(points, "cylinder")
    held = known(points, "cylinder", constraints=Constraints.of({"radius": {"value": 0.8}}))
    assert held.intervals["radius"] == type(held.intervals["radius"])(0.8, 0.8, 0.0, "held")
    for name in ("point.x", "point.z"):
        assert held.intervals[name].standard_deviation <= free.intervals[name].standard_deviation
    axis = known(points, "cylinder", constraints=Constraints.of({"axis": {"direction": [0.2, 0.9, 0.3]}}))
    assert axis.direction is not None and axis.direction.radius_95 == 0.0


def test_an_active_bound_makes_an_interval_one_sided() -> None:
    points = noisy(EXAMPLES["sphere"], 400, 0.01)
    found = known(points, "sphere", constraints=Constraints.of({"radius": {"max": 1.29}}))
    radius = found.intervals["radius"]
    assert radius.method == "bound" and radius.high == 1.29 and radius.low is not None and radius.low < 1.29


def test_exact_points_leave_the_rounding() -> None:
    points = np.round(sample(EXAMPLES["sphere"], 500), 4)
    found = known(points, "sphere")
    assert found.noise_model == "exact"
    assert 1e-6 < found.intervals["radius"].standard_deviation < 1e-5


def test_few_points_warn_and_the_fewest_know_nothing() -> None:
    points = noisy(EXAMPLES["sphere"], 12, 0.01)
    assert "few_points" in codes(known(points, "sphere"))
    fewest = known(points[:4], "sphere")
    assert fewest.covariance is None and fewest.noise_model == "unknown" and not fewest.intervals
    assert codes(fewest) >= {"minimal_sample"}


def test_nothing_is_claimed_where_nothing_fits_or_no_theory_holds() -> None:
    volume = np.random.default_rng(5).uniform(-1.0, 1.0, (500, 3))
    assert recognize(volume).uncertainty is None
    extreme = Config(kinds=("sphere",), criterion="minimum_zone")
    assert recognize(noisy(EXAMPLES["sphere"], 100, 0.01), extreme).uncertainty is None


def test_arcs_are_those_of_the_extents() -> None:
    """As many degrees as the points were drawn over; strays do not make an arc whole."""
    rng = np.random.default_rng(3)
    cylinder = EXAMPLES["cylinder"]
    azimuth = np.append(rng.uniform(0.0, np.radians(100.0), 2000), np.radians([200.0, 201.0]))
    points = cylinder.surface(azimuth, rng.uniform(-1.0, 1.0, 2002))
    found = recognize(points + 1e-3 * rng.normal(size=points.shape))
    assert found.extents is not None and found.uncertainty is not None
    assert found.extents.arcs["about the axis"] == pytest.approx(100.0, abs=1.0)
    (warning,) = (each for each in found.uncertainty.warnings if each.code == "one_sided")
    assert "an arc of 100 degrees about the axis" in warning.message
