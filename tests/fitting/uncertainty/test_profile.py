"""Profiles: ends where the cost of the best other numbers has risen enough, or none."""

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares, minimize, minimize_scalar
from scipy.special import stdtrit

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.uncertainty.profile import Local
from tests.fitting.clouds import EXAMPLES, noisy
from tests.fitting.uncertainty.known import arc, codes, known


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


@pytest.mark.parametrize("seed", range(3))
def test_a_step_goes_to_the_farthest_place_of_an_ellipsoid(seed: int) -> None:
    """The largest g . s with  1/2 s A s + b s <= rise,  by SciPy on the boundary and inside."""
    rng = np.random.default_rng(seed)
    root, slope, gradient = rng.normal(size=(5, 4)), 0.2 * rng.normal(size=4), rng.normal(size=4)
    local = Local(0.0, slope, root.T @ root, None)
    found = local.farthest(gradient, 1.5)
    assert found is not None
    best = minimize(
        lambda s: -gradient @ s,
        np.zeros(4),
        jac=lambda s: -gradient,
        method="SLSQP",
        constraints={
            "type": "ineq",
            "fun": lambda s: 1.5 - 0.5 * np.sum((root @ s) ** 2) - slope @ s,
            "jac": lambda s: -root.T @ (root @ s) - slope,
        },
        options={"ftol": 1e-10, "maxiter": 500},
    )
    assert best.success
    assert gradient @ found == pytest.approx(-best.fun, rel=1e-6)
    assert 0.5 * np.sum((root @ found) ** 2) + slope @ found == pytest.approx(1.5)


def test_an_open_direction_has_no_farthest_place() -> None:
    local = Local(0.0, np.zeros(2), np.diag([1.0, 0.0]), None)
    assert local.farthest(np.array([0.0, 1.0]), 1.0) is None


def test_the_ends_of_a_cap_are_those_of_spheres_of_given_radius() -> None:
    """For each radius SciPy finds the best centre; the cost has risen by as much as Student's t says."""
    rng = np.random.default_rng(9)
    cap = Sphere([0.0, 0.0, -1.0], 1.0)
    points = cap.surface(rng.uniform(0.0, 2.0 * np.pi, 120), rng.uniform(0.0, 0.3, 120))
    points += 0.005 * rng.normal(size=points.shape)
    interval = known(points, "sphere", criterion="least_squares").intervals["radius"]
    assert interval.method == "profile" and interval.low is not None and interval.high is not None

    def cost(radius: float) -> float:
        def residuals(center: Array) -> Array:
            return np.asarray(np.linalg.norm(points - center, axis=1) - radius)

        return float(least_squares(residuals, [0.0, 0.0, -radius], xtol=1e-12, ftol=1e-12).cost)

    best = minimize_scalar(cost, bracket=(0.8, 1.0), options={"xtol": 1e-8})
    rise = best.fun * stdtrit(len(points) - 4, 0.975) ** 2 / (len(points) - 4)
    for end in (interval.low, interval.high):
        assert cost(end) - best.fun == pytest.approx(rise, rel=0.05)
    assert interval.low < best.x < interval.high
