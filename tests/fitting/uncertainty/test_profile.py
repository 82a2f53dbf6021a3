"""Profiles: ends where the cost of the best other numbers has risen enough, or none."""

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares, minimize_scalar
from scipy.special import stdtrit

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
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
