"""What a cloud leaves open: the interval of what nests a kind in a more general one."""

import numpy as np
import pytest

from fitting.geometry import Array
from fitting.nesting import Interval, intervals
from fitting.primitives import Cone, Cylinder, Plane, Primitive, Sphere, Torus
from fitting.recognize import recognize
from fitting.refine import refine

RNG = np.random.default_rng(11)
FLAT = Plane([0.0, 0.0, 1.0], [0.0, 0.0, 0.0])
PIPE = Cylinder([0.0, 0.0, 1.0], [0.0, 0.0, 0.0], 0.5)
BALL = Sphere([0.0, 0.0, 0.0], 1.0)


def around(count: int = 400) -> tuple[Array, Array]:
    return RNG.uniform(0.0, 2.0 * np.pi, count), RNG.uniform(-1.0, 1.0, count)


def found(simple: Primitive, points: Array, noise: float) -> dict[str, Interval]:
    fitted = refine(simple, points).primitive
    ways = intervals(fitted, points, fitted.signed_distance(points), noise, 2.0)
    return {kind: max(each, key=lambda way: way.estimate + way.error) for kind, each in ways.items()}


def test_the_estimate_is_the_parameter_that_was_put_in() -> None:
    angle, height = around()
    lean = 0.02
    cone = Cone([0.0, 0.0, -0.5 / np.tan(lean)], [0.0, 0.0, 1.0], lean)
    leaning = cone.surface(angle, height - cone.apex[2])
    assert found(PIPE, leaning, 1e-6)["cone"].estimate == pytest.approx(lean / 0.05, rel=0.02)
    bend = 0.05
    torus = Torus([1.0 / bend, 0.0, 0.0], [0.0, 1.0, 0.0], 1.0 / bend, 0.5)
    bent = torus.surface(np.pi + bend * height, angle)
    length = np.ptp(bent[:, 2])
    assert found(PIPE, bent, 1e-6)["torus"].estimate == pytest.approx(bend * length / 0.25, rel=0.05)
    hole = Torus([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.01, 0.99)
    holed = hole.surface(angle, np.pi / 2.0 * height)
    assert found(BALL, holed, 1e-6)["torus"].estimate == pytest.approx(0.01 / 0.15, rel=0.1)


def test_the_error_is_that_of_least_squares() -> None:
    flat = np.column_stack([RNG.uniform(-0.5, 0.5, (200, 2)), np.zeros(200)])
    noise = 0.01
    estimates = []
    for seed in range(300):
        points = flat + np.random.default_rng(seed).normal(0.0, noise, 200)[:, None] * [0.0, 0.0, 1.0]
        interval = found(FLAT, points, noise)["sphere"]
        estimates.append(interval.estimate)
    assert np.sqrt(np.mean(np.square(estimates))) == pytest.approx(interval.error, rel=0.1)


@pytest.mark.parametrize(("noise", "is_open"), [(1e-4, False), (0.05, True)])
def test_noise_opens_what_it_hides(noise: float, is_open: bool) -> None:
    flat = np.column_stack([RNG.uniform(-0.5, 0.5, (60, 2)), RNG.normal(0.0, noise, 60)])
    assert found(FLAT, flat, noise)["cylinder"].is_open == is_open


def test_a_cap_may_be_a_cylinder_and_a_whole_sphere_may_not() -> None:
    angle, height = around()
    assert "cylinder" not in found(BALL, BALL.surface(angle, np.arccos(height)), 1e-3)
    assert "cylinder" in found(BALL, BALL.surface(angle, 0.2 * (1.0 + height)), 1e-3)


def test_general_kinds_leave_nothing_open_and_points_on_an_axis_do_no_harm() -> None:
    angle, height = around(50)
    torus = Torus([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, 0.3)
    assert intervals(torus, torus.surface(angle, height), np.zeros(50), 0.1, 2.0) == {}
    ring = np.vstack([PIPE.surface(angle, 0.0 * height), [[0.0, 0.0, 0.0]]])
    for ways in intervals(PIPE, ring, PIPE.signed_distance(ring), 0.1, 1.0).values():
        assert not np.isnan([[way.estimate, way.error, way.whole, way.evidence] for way in ways]).any()


def test_a_bend_that_a_cylinder_hides_is_significant_in_some_direction() -> None:
    """Least squares turns the cylinder so that the bend is small where it is seen best."""
    angle, height = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, 40), RNG.uniform(-1.0, 1.0, 40)
    bent = Torus([10.0, 0.0, 0.0], [0.0, 1.0, 0.0], 10.0, 1.0).surface(np.pi + 0.15 * height, angle)
    bent += RNG.normal(0.0, 4e-4, bent.shape)
    straight = PIPE.surface(angle, 1.5 * height) * 2.0 + RNG.normal(0.0, 4e-3, bent.shape)
    for points, expected in ((bent, True), (straight, False)):
        fitted = refine(PIPE, points).primitive
        distance = fitted.signed_distance(points)
        noise = float(np.sqrt(np.sum(distance**2) / 35.0))
        ways = intervals(fitted, points, distance, noise, 3.5)["torus"]
        assert any(way.is_significant(1.0) for way in ways) == expected


def test_a_few_points_on_a_bent_tube_are_a_torus() -> None:
    """Normals of so few points tell nothing; the search bends cylinders."""
    rng = np.random.default_rng(4)
    for _ in range(8):
        torus = Torus(rng.normal(size=3), rng.normal(size=3), rng.uniform(8.0, 14.0), 1.0)
        points = torus.surface(rng.uniform(-0.16, 0.16, 45), rng.uniform(0.0, 2.0 * np.pi, 45))
        points += rng.normal(0.0, 4e-4, points.shape)
        answer = recognize(points)
        assert answer.status == "fitted" and isinstance(answer.primitive, Torus)
        assert answer.error is not None and answer.error.rms < 8e-4
