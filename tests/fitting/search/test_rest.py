"""The surface and the scale of its noise that rounds of both come to, in fewer of them."""

import numpy as np
import pytest

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.noise.scale import CORE, CORE_DEVIATION, SCALE_AT_REST, core_scale
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.search._rest import with_its_scale
from primfit.fitting.solver.refine import CODES, refine

ROUNDS = 200
"""Plain rounds that come to rest: each leaves a tenth to a half of what was left."""


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


def together(
    primitive: Primitive, points: Array, factors: Array | None = None, smallest: float = 1e-12
) -> tuple[Array, float, Array]:
    across = np.array(primitive.chart.across, np.int64).reshape(-1, 2)
    return with_its_scale(
        CODES[primitive.kind],
        primitive.row(),
        points,
        smallest,
        3,
        20,
        across,
        CORE,
        CORE_DEVIATION,
        SCALE_AT_REST,
        factors,
    )


@pytest.mark.parametrize("weighted", [False, True])
@pytest.mark.parametrize(
    "start", [Cylinder([0, 0, 1], [0, 0, 0], 0.5), Sphere([0, 0, 0], 0.5)], ids=lambda start: start.kind
)
def test_it_ends_where_rounds_do(start: Primitive, weighted: bool) -> None:
    rng = np.random.default_rng(3)
    points = noisy_arc(rng)
    factors = rng.uniform(0.5, 2.0, len(points)) if weighted else None
    row, found, distance = together(start, points, factors)
    primitive, scale = by_rounds(start, points, factors, ROUNDS)
    assert found == pytest.approx(scale, rel=1e-10)
    np.testing.assert_allclose(distance, type(start).from_row(row).signed_distance(points), atol=1e-13)
    assert np.abs(distance - primitive.signed_distance(points)).max() <= 1e-7 * scale


def test_an_axis_that_lies_in_the_plane_where_its_basis_jumps() -> None:
    points = np.ascontiguousarray(noisy_arc(np.random.default_rng(6))[:, [2, 0, 1]])
    row, found, _ = together(Cylinder([1, 0, 1e-3], [0, 0, 0], 0.5), points)
    _, scale = by_rounds(Cylinder.from_row(row), points, None, ROUNDS)
    assert found == pytest.approx(scale, rel=1e-10)


def test_a_sphere_through_a_plane_comes_to_no_rest_and_ends() -> None:
    rng = np.random.default_rng(4)
    points = np.column_stack([rng.uniform(-0.5, 0.5, (500, 2)), 1e-3 * rng.standard_normal(500)])
    row, scale, _ = together(Sphere([0, 0, 1e7], 1e7), points)
    assert np.isfinite(row).all() and scale == pytest.approx(1e-3, rel=0.1)


def test_the_scale_is_not_below_the_smallest() -> None:
    _, scale, _ = together(
        Cylinder([0, 0, 1], [0, 0, 0], 0.5), noisy_arc(np.random.default_rng(5)), smallest=0.05
    )
    assert scale == pytest.approx(0.05, rel=1e-12)


def test_distances_that_are_no_numbers_end_it() -> None:
    row, scale, _ = together(Sphere([0, 0, np.nan], 0.5), noisy_arc(np.random.default_rng(5)))
    assert not np.isfinite(scale) and not np.isfinite(row).all()
