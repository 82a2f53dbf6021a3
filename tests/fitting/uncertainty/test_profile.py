"""Profiles: ends where the cost of the best other numbers has risen enough, or none."""

import numpy as np
import pytest
from scipy.optimize import brentq, least_squares, minimize, minimize_scalar
from scipy.special import stdtrit

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives import PRIMITIVES, is_angle, values_of
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import TOUCHES, Constraints
from primfit.fitting.solver.refine import CODES, refine
from primfit.fitting.trial.limits import Limits
from primfit.fitting.uncertainty._profile import Region, numbers
from tests.fitting.clouds import EXAMPLES, noisy
from tests.fitting.uncertainty.known import arc, codes, known
from tests.fitting.uncertainty.reference_profile import Cost, Local, profile_end


def test_a_short_arc_is_profiled_and_leaves_the_larger_radius_open_wider() -> None:
    found = known(arc(25.0, 300, 0.008, 0), "cylinder")
    radius = found.intervals["radius"]
    assert radius.method == "profile" and radius.low is not None and radius.high is not None
    middle = recognize(arc(25.0, 300, 0.008, 0), Config(kinds=("cylinder",))).primitive.radius
    assert radius.high - middle > 1.1 * (middle - radius.low)
    assert {"short_arc", "weak_size"} <= codes(found)
    assert "25 degrees" in next(each.message for each in found.warnings if each.code == "short_arc")


def test_the_ends_of_a_profile_are_those_of_an_independent_optimizer() -> None:
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
    """For each radius SciPy finds the best center; the cost has risen by as much as Student's t says."""
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


CENTER = np.array([0.1, -0.2, 0.05])
LIMITS = {
    "plane": {"normal": {"direction": [0.6, -0.3, 0.74], "max_angle": 1e-3}},
    "sphere": {"radius": {"min": 1.2995}},
    "cylinder": {"axis": {"direction": [0.22, 0.9, 0.3], "max_angle": 1e-3}},
    "cone": {"half_angle": {"value": 0.6}, "axis": {"direction": [0.1, 0.31, -0.9], "max_angle": 5e-3}},
    "torus": {"major_radius": {"max": 1.6005}, "axis": {"direction": [0.5, -0.4, 0.7]}},
}
"""Of each kind some that are active at the optimum of its example, or become so on the way."""


def region_of(surface: Primitive, cost: Cost) -> Region:
    chart = PRIMITIVES[surface.kind].chart.numbers
    return Region(
        CODES[surface.kind],
        surface.row(),
        cost.points,
        kernel=cost.kernel,
        scale=cost.scale,
        factors=cost.factors,
        bounds=None if cost.limits is None else cost.limits.bounds,
        touches=TOUCHES,
        center=CENTER,
        sizes=[place for _, place in chart.values()],
        angles=[is_angle(name) for name in chart],
    )


def end_of(cost: Cost, surface: Primitive, weights: Array, half: float, rise: float) -> Array | None:
    """The numbers (P,) at the farther end by the reference, from the optimum."""

    def gradient(there: Primitive) -> Array:
        return np.asarray(weights @ numbers(CODES[there.kind], there.row(), CENTER)[1])

    local = cost.near(surface)
    end = profile_end(cost, surface, local, gradient, half, local.cost, local.cost + rise)
    return None if end is None else values_of(end[0].canonical(CENTER))


@pytest.mark.parametrize("limited", [False, True], ids=["free", "limited"])
@pytest.mark.parametrize("kernel", [Kernel.LEAST_SQUARES, Kernel.TUKEY, Kernel.HUBER])
@pytest.mark.parametrize("kind", EXAMPLES)
def test_the_compiled_ends_are_those_of_numpy(kind: str, kernel: Kernel, limited: bool) -> None:
    """From the optimum, along random sums of the numbers, for small and for large rises of the cost."""
    rng, points = np.random.default_rng(7), noisy(EXAMPLES[kind], 150, 0.02, 3)
    frame = Frame(np.zeros(3), 1.0)
    limits = Limits.of(Constraints.of(LIMITS[kind]), kind, frame) if limited else None
    factors = rng.uniform(0.5, 2.0, len(points)) if limited else None
    start = EXAMPLES[kind].row() if limits is None else limits.impose(EXAMPLES[kind].row(), points)
    surface = refine(
        PRIMITIVES[kind].from_row(start),
        points,
        kernel,
        0.03,
        factors=factors,
        bounds=None if limits is None else limits.bounds,
    ).primitive
    cost = Cost(points, kernel, 0.03, factors, limits)
    for rise in (0.1, 2.0, 30.0):
        weights = rng.normal(size=len(values_of(surface)))
        ends = region_of(surface, cost).ends(weights, 0.05, rise)
        expected = end_of(cost, surface, -weights, 0.05, rise)
        assert (ends[0] is None) == (expected is None)
        if expected is not None:
            np.testing.assert_allclose(ends[0], expected, rtol=1e-9, atol=1e-10)


def test_ends_that_are_open_are_so_in_both() -> None:
    points = arc(8.0, 100, 0.004, 3)
    surface = refine(EXAMPLES["cylinder"].from_row(np.array([0, 0, 1, 0, 0, 0, 0, 0, 1.0])), points).primitive
    cost = Cost(points, Kernel.LEAST_SQUARES, 0.004, None, None)
    weights = np.eye(7)[6]
    region = region_of(surface, cost)
    low, high = region.ends(weights, 0.5, 5.0)
    assert high is None and end_of(cost, surface, weights, 0.5, 5.0) is None
    assert low is not None
    np.testing.assert_allclose(low, end_of(cost, surface, -weights, 0.5, 5.0), rtol=1e-9, atol=1e-10)
    assert len(region.rows) == 2


def test_a_search_begins_at_the_farthest_surface_seen() -> None:
    """Looking for an end twice brings it nearer at most, and what has been seen is kept."""
    points = noisy(EXAMPLES["sphere"], 200, 0.02)
    surface = refine(EXAMPLES["sphere"], points).primitive
    region = region_of(surface, Cost(points, Kernel.LEAST_SQUARES, 0.02, None, None))
    first, second = (region.ends(np.eye(4)[3], 0.01, 2.0) for _ in range(2))
    assert len(region.rows) == 5
    for one, other, sign in zip(first, second, (-1.0, 1.0), strict=True):
        assert one is not None and other is not None and sign * (other[3] - one[3]) >= 0.0
