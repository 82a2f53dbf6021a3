"""The last digits of an optimum: where another arithmetic has its own, and nowhere if there is no minimum."""

import numpy as np
import pytest

from primfit.benchmark.proofs import oracles
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.newton import newton
from primfit.fitting.solver.refine import refine, stepped
from tests.fitting.clouds import EXAMPLES, noisy

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
    """Of all planes through its centre, the one across a rod's length leaves most over."""
    rod = np.random.default_rng(4).normal(size=(200, 3)) * [5.0, 1.0, 0.5]
    rod -= rod.mean(axis=0)
    worst = np.linalg.svd(rod)[2][0]
    across = Plane(worst, np.zeros(3))
    assert newton(across, rod, Kernel.LEAST_SQUARES) is across
