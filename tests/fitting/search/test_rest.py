"""The surface and the scale of its noise that rounds of both come to, in fewer of them."""

import numpy as np
import pytest

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.noise.scale import core_scale
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.search.rest import at_rest
from primfit.fitting.solver.refine import refine

NEAR, ROUNDS = 5, 200
"""Plain rounds that come near, and that come to rest: each leaves a tenth to a half of what was left."""


def noisy_arc(rng: np.random.Generator, n: int = 600) -> Array:
    """Points of an arc of a cylinder of radius 0.5 under noise with outliers."""
    angle, height = rng.uniform(0.0, 2.0, n), rng.uniform(-0.5, 0.5, n)
    radius = 0.5 + 0.005 * rng.standard_t(3, n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def by_rounds(
    primitive: Primitive, points: Array, factors: Array | None, rounds: int
) -> tuple[Primitive, float]:
    scale = np.inf
    for _ in range(rounds):
        distance = primitive.signed_distance(points)
        scale = core_scale(np.abs(distance if factors is None else factors * distance))
        primitive = refine(primitive, points, Kernel.TUKEY, scale, factors=factors).primitive
    return primitive, scale


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize(
    "start", [Cylinder([0, 0, 1], [0, 0, 0], 0.5), Sphere([0, 0, 0], 0.5)], ids=lambda start: start.kind
)
def test_it_ends_where_rounds_do(start: Primitive, weighted: bool) -> None:
    rng = np.random.default_rng(3)
    points = noisy_arc(rng)
    factors = rng.uniform(0.5, 2.0, len(points)) if weighted else None
    near, scale = by_rounds(start, points, factors, NEAR)
    found = at_rest(near, scale, points, 1e-12, factors)
    assert found is not None
    primitive, scale = by_rounds(near, points, factors, ROUNDS)
    assert found[1] == pytest.approx(scale, rel=1e-10)
    moved = found[0].signed_distance(points) - primitive.signed_distance(points)
    assert np.abs(moved).max() <= 1e-7 * scale


def test_a_sphere_through_a_plane_has_no_rest() -> None:
    rng = np.random.default_rng(4)
    points = np.column_stack([rng.uniform(-0.5, 0.5, (500, 2)), 1e-3 * rng.standard_normal(500)])
    assert at_rest(Sphere([0, 0, 1e7], 1e7), 1e-3, points, 1e-12) is None


def test_the_scale_is_not_below_the_smallest() -> None:
    points = noisy_arc(np.random.default_rng(5))
    start = refine(Cylinder([0, 0, 1], [0, 0, 0], 0.5), points, Kernel.TUKEY, 0.05).primitive
    found = at_rest(start, 0.05, points, 0.05)
    assert found is not None and found[1] == pytest.approx(0.05, rel=1e-12)
