"""The last digits of an optimum: where another arithmetic has its own, and nowhere if there is no minimum."""

import numpy as np
import pytest

from primfit.benchmark.proofs import oracles
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.newton import newton
from primfit.fitting.solver.refine import refine, stepped
from tests.fitting.clouds import EXAMPLES, noisy, sample
from tests.fitting.solver import reference_newton as reference

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


def beside(primitive: Primitive, size: float, seed: int) -> Primitive:
    return stepped(primitive, size * np.random.default_rng(seed).normal(size=primitive.dof))


@examples
def test_it_is_the_optimum_of_long_doubles(primitive: Primitive) -> None:
    points = noisy(primitive, 150, 0.02)
    center = points.mean(axis=0)
    points = points - center
    start = refine(primitive.transformed(np.eye(3), -center, 1.0), points).primitive
    found = newton(beside(start, 1e-4, 1), points, Kernel.LEAST_SQUARES)
    wide = points.astype(np.longdouble)
    best = oracles.newton(primitive.kind, oracles.long(parameters(start)), wide)
    ours, theirs = (
        oracles.distances(primitive.kind, surface, wide)
        for surface in (oracles.long(parameters(found)), best)
    )
    assert np.abs(ours - theirs).max() < 1e-13


@pytest.mark.parametrize("kernel", Kernel, ids=lambda kernel: kernel.name.lower())
@examples
def test_from_either_side_it_comes_to_one_point(primitive: Primitive, kernel: Kernel) -> None:
    points = noisy(primitive, 300, 0.02)
    center = points.mean(axis=0)
    points = points - center
    start = refine(primitive.transformed(np.eye(3), -center, 1.0), points, kernel, 0.02).primitive
    one, other = (newton(beside(start, 1e-4, seed), points, kernel, 0.02) for seed in (2, 3))
    assert np.abs(one.signed_distance(points) - other.signed_distance(points)).max() < 1e-13


def test_where_the_cost_is_largest_nothing_moves() -> None:
    """Of all planes through its center, the one across a rod's length leaves most over."""
    rod = np.random.default_rng(4).normal(size=(200, 3)) * [5.0, 1.0, 0.5]
    rod -= rod.mean(axis=0)
    worst = np.linalg.svd(rod)[2][0]
    across = Plane(worst, np.zeros(3))
    assert newton(across, rod, Kernel.LEAST_SQUARES) is across


def started(primitive: Primitive, points: Array, kernel: Kernel, scale: float) -> tuple[Primitive, Array]:
    """Beside the optimum of points about their mean, and these."""
    center = points.mean(axis=0)
    start = refine(primitive.transformed(np.eye(3), -center, 1.0), points - center, kernel, scale).primitive
    return beside(start, 1e-3, 5), points - center


@pytest.mark.parametrize("kernel", [Kernel.LEAST_SQUARES, Kernel.TUKEY, Kernel.HUBER])
@pytest.mark.parametrize("n", [12, 400])
@examples
def test_it_goes_where_numpy_goes(primitive: Primitive, n: int, kernel: Kernel) -> None:
    start, points = started(primitive, noisy(primitive, n, 0.02), kernel, 0.03)
    one, other = (each(start, points, kernel, 0.03) for each in (newton, reference.newton))
    np.testing.assert_allclose(one.signed_distance(points), other.signed_distance(points), atol=2e-14)


def test_curvature_is_seen_on_some_of_many_points() -> None:
    sphere = EXAMPLES["sphere"]
    start, points = started(sphere, noisy(sphere, 50_001, 0.02), Kernel.LEAST_SQUARES, 1.0)
    one, other = (each(start, points, Kernel.LEAST_SQUARES) for each in (newton, reference.newton))
    np.testing.assert_allclose(one.signed_distance(points), other.signed_distance(points), atol=2e-14)


@examples
def test_exact_points_need_no_curvature(primitive: Primitive) -> None:
    start, points = started(primitive, sample(primitive, 300), Kernel.LEAST_SQUARES, 1.0)
    found = newton(refine(start, points).primitive, points, Kernel.LEAST_SQUARES)
    assert np.abs(found.signed_distance(points)).max() < 1e-14


def test_what_points_leave_open_stays() -> None:
    """Points on a line turn no plane about it, and fewer points than parameters determine none."""
    plane, line = Plane([0.0, 0.0, 1.0], np.zeros(3)), np.outer(np.linspace(-1.0, 1.0, 40), [1.0, 0.5, 0.0])
    line[:, 2] += 0.01 * np.random.default_rng(0).normal(size=40)
    for points in (line, line[:2], line[:0]):
        assert newton(plane, points, Kernel.LEAST_SQUARES) is plane
