"""Steps of the compiled loop within bounds: each solves a bounded program, and the last meets its laws."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.solver.refine import linearize, refine, stepped
from primfit.fitting.trial.limits import Limits

ORIGIN = Frame(np.zeros(3), 1.0)
MAJOR, MINOR = 1.5, 0.5


def limits_of(kind: str, **constraints: object) -> Limits:
    limits = Limits.of(Constraints.of(constraints), kind, ORIGIN)  # type: ignore[arg-type]
    assert limits is not None
    return limits


def torus_and_points(seed: int) -> tuple[Torus, Array]:
    """A torus, and points of one slightly beside it."""
    rng = np.random.default_rng(seed)
    torus = Torus(0.1 * rng.normal(size=3), rng.normal(size=3), MAJOR, MINOR)
    other = stepped(torus, 1e-3 * rng.normal(size=7))
    points = other.surface(*rng.uniform(0.0, 2.0 * np.pi, (2, 200)))
    return torus, points + 1e-4 * rng.normal(size=(200, 3))


@pytest.mark.parametrize("seed", range(12))
def test_a_step_is_the_optimum_of_a_bounded_quadratic(seed: int) -> None:
    """Radii may grow and shrink by less than the points ask for, by more, or not at all."""
    torus, points = torus_and_points(seed)
    shrink, grow = np.random.default_rng([seed, 1]).choice([1e-5, 5e-4, 5e-3], (2, 2))
    limits = limits_of(
        "torus",
        major_radius={"min": MAJOR - shrink[0], "max": MAJOR + grow[0]},
        minor_radius={"min": MINOR - shrink[1], "max": MINOR + grow[1]},
    )
    distance, jacobian = linearize(torus, points)
    low, high = np.full(7, -np.inf), np.full(7, np.inf)
    low[5:], high[5:] = -shrink, grow
    best = lsq_linear(jacobian, -distance, (low, high), tol=1e-14)
    found = refine(torus, points, max_iterations=1, bounds=limits.bounds).primitive
    moved = found.signed_distance(points) - stepped(torus, best.x).signed_distance(points)
    assert np.abs(moved).max() < 1e-8 * np.abs(best.x).max() + 1e-10


@pytest.mark.parametrize("seed", range(6))
def test_at_the_end_bounds_only_push_and_the_rest_is_stationary(seed: int) -> None:
    torus, points = torus_and_points(seed)
    limits = limits_of("torus", major_radius={"max": MAJOR - 0.01}, minor_radius={"min": MINOR + 0.01})
    start = Torus(torus.center, torus.axis, MAJOR - 0.02, MINOR + 0.02)
    end = refine(start, points, bounds=limits.bounds)
    assert end.converged and isinstance(end.primitive, Torus)
    assert (end.primitive.major_radius, end.primitive.minor_radius) == (MAJOR - 0.01, MINOR + 0.01)
    distance, jacobian = linearize(end.primitive, points)
    pull = jacobian.T @ distance / np.linalg.norm(distance)
    np.testing.assert_allclose(pull[:5], 0.0, atol=1e-7)
    assert pull[5] < 0.0 < pull[6], "a larger ring and a thinner tube would cost less"


@pytest.mark.parametrize("kind", ["plane", "cylinder"])
def test_an_axis_beyond_its_cone_stops_on_it_at_the_nearest_place(kind: str) -> None:
    """The best tilt of 0.1 rad is towards x; within 0.04 of z the best is 0.04 towards x."""
    rng, tilt = np.random.default_rng(7), 0.1
    best = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    along = np.linspace(-1.0, 1.0, 21)
    u, v = (each.ravel() for each in np.meshgrid(along, along))
    if kind == "plane":
        start, truth = Plane([0.0, 0.0, 1.0], np.zeros(3)), Plane(best, np.zeros(3))
        limits = limits_of(kind, normal={"direction": [0, 0, 1], "max_angle": 0.04})
        points = truth.surface(u, v)
    else:
        start, truth = Cylinder([0.0, 0.0, 1.0], np.zeros(3), 1.0), Cylinder(best, np.zeros(3), 1.0)
        limits = limits_of(kind, axis={"direction": [0, 0, 1], "max_angle": 0.04})
        points = truth.surface(np.pi * u, v)
    start = stepped(start, np.append(1e-3 * rng.normal(size=2), np.zeros(start.dof - 2)))
    found = refine(start, points, bounds=limits.bounds)
    axis = found.primitive.row()[:3]
    assert found.converged
    assert np.arccos(abs(axis[2])) == pytest.approx(0.04, abs=1e-8)
    assert abs(axis[1]) < 1e-3 < 0.03 < axis[0] * np.sign(axis[2])
