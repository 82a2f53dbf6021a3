"""The covariance: a sandwich over points whose noise may be uneven."""

from dataclasses import replace

import numpy as np
import pytest

from primfit.fitting.cloud.patches import Halved
from primfit.fitting.noise.kernels import Kernel
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.solver.refine import CODES
from primfit.fitting.uncertainty import _covariance
from primfit.fitting.uncertainty.agreement import Agreement
from primfit.fitting.uncertainty.covariance import UNDETERMINED, Cost, Linear
from tests.fitting.clouds import EXAMPLES, noisy
from tests.fitting.uncertainty import reference_covariance as reference
from tests.fitting.uncertainty.known import flat, known

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


def test_uneven_noise_is_weighed_where_it_is() -> None:
    """Noise on one side only makes the center uncertain along that side."""
    rng, sphere = np.random.default_rng(1), Sphere([0.0, 0.0, 0.0], 1.0)
    points = rng.standard_normal((3000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    sigma = np.where(np.abs(points[:, 2]) > 0.7, 0.02, 0.002)
    found = known(points + (sigma * rng.standard_normal(3000))[:, None] * sphere.gradient(points), "sphere")
    along, across = (found.intervals[f"center.{axis}"].standard_deviation for axis in "zx")
    assert along > 2.0 * across


def test_few_inliers_scatter_by_their_distances_whatever_the_kernel_keeps() -> None:
    linear = flat(20, np.random.default_rng(3))
    inlier = np.arange(20) < 15
    found = replace(linear, pull=0.1 * linear.pull).equal(inlier)
    left = np.where(inlier, 1.0, 0.1) * linear.distance
    assert found is not None and found.noise == pytest.approx(np.sqrt(left @ left / 17))


def test_without_fields_the_covariance_is_the_sandwich() -> None:
    linear = flat(300, np.random.default_rng(3))
    rows = linear.rows.T
    found, bread = linear.uneven(None), np.linalg.inv(rows.T @ rows)
    own = linear.pull**2 / (1.0 - np.sum((rows @ bread) * rows, axis=1))
    assert found is not None and found.effective_points == 300
    expected = bread @ rows.T @ np.diag(own) @ rows @ bread
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-9)


def table(primitive: Primitive, cost: Cost) -> np.ndarray:
    return _covariance.linearized(
        CODES[primitive.kind], primitive.row(), cost.points, cost.kernel, cost.scale, cost.factors
    )


@pytest.mark.parametrize("kernel", Kernel, ids=lambda kernel: kernel.name.lower())
@examples
def test_the_compiled_table_of_points_is_that_of_numpy(primitive: Primitive, kernel: Kernel) -> None:
    """With outliers, and points on the other side of an apex, that have it for their foot."""
    points = np.vstack([noisy(primitive, 200, 0.05), np.random.default_rng(1).normal(0.0, 3.0, (100, 3))])
    for factors in (None, np.random.default_rng(2).uniform(0.1, 3.0, 300)):
        cost = Cost(points, kernel, 0.1, factors)
        np.testing.assert_allclose(
            table(primitive, cost), reference.table(primitive, cost), rtol=1e-11, atol=1e-11
        )


def test_feet_behind_an_apex_are_the_apex() -> None:
    cone = EXAMPLES["cone"]
    assert isinstance(cone, Cone)
    behind = cone.apex - np.multiply.outer(np.linspace(0.2, 2.0, 30), cone.axis)
    found = table(cone, Cost(behind, Kernel.LEAST_SQUARES, 1.0, None))
    np.testing.assert_allclose(found[-3:].T, np.tile(cone.apex, (30, 1)), atol=1e-14)


def test_no_points_make_an_empty_table() -> None:
    cost = Cost(np.empty((0, 3)), Kernel.LEAST_SQUARES, 1.0, None)
    assert table(EXAMPLES["sphere"], cost).shape == (11, 0)


@pytest.mark.parametrize("copies", [1.0, 3.5])
@pytest.mark.parametrize("seed", range(4))
def test_the_compiled_covariance_is_that_of_numpy(seed: int, copies: float) -> None:
    """Under random explanations of the noise, some of them hardly likely, and with points left out."""
    rng, count = np.random.default_rng(seed), 40
    primitive = list(EXAMPLES.values())[seed]
    points = noisy(primitive, 900, 0.02, seed)
    linear = Linear.of(primitive.kind, primitive.row(), Cost(points, Kernel.TUKEY, 0.02, None), copies)
    weight = 10.0 ** rng.uniform(-15.0, 0.0, count)
    agreement = Agreement(
        Halved.of(points).patches(),
        rng.random(900) < 0.9,
        2.5,
        weight / weight.sum(),
        rng.uniform(0.1, 1.0, count),
        1e-4 * rng.random(count),
        rng.choice([0.0, 0.1, 1.0], count),
        1e-2 * rng.random(count),
        rng.choice([0.0, 0.15, 1.0], count),
        None,
    )
    rows, feet = linear.rows.T, linear.feet.T
    bread = np.linalg.inv(copies * rows.T @ (linear.slope[:, None] * rows))
    independent = reference.uneven(rows, linear.pull, linear.slope, bread, copies)
    meats = reference.meats(agreement, independent, copies * linear.gain[:, None] * rows, feet)
    expected = reference.mixed(bread @ meats @ bread, agreement.weight, bread, 64.0 - rows.shape[1])
    found = linear.uneven(agreement)
    assert found is not None
    sizes = np.sqrt(np.diag(expected))
    np.testing.assert_allclose((found.matrix - expected) / np.outer(sizes, sizes), 0.0, atol=1e-10)


@pytest.mark.parametrize("k", [0, 1, 2, 5, 9])
def test_the_inverse_is_that_of_lapack_whatever_the_units(k: int) -> None:
    rng = np.random.default_rng(k)
    root, units = rng.normal(size=(k, k)), 10.0 ** rng.uniform(-6.0, 6.0, k)
    square = units[:, None] * (root.T @ root + 1e-3 * np.eye(k)) * units
    found = _covariance.inverted(square, UNDETERMINED)
    assert found is not None
    expected = np.linalg.inv(square / np.outer(units, units)) / np.outer(units, units)
    sizes = np.sqrt(np.diag(expected))
    np.testing.assert_allclose((found - expected) / np.outer(sizes, sizes), 0.0, atol=1e-10)


@pytest.mark.parametrize("open_one", [np.zeros(3), np.ones(3), np.array([1.0, np.nan, 0.0])])
def test_what_leaves_a_direction_open_has_no_inverse(open_one: np.ndarray) -> None:
    assert _covariance.inverted(np.outer(open_one, open_one), UNDETERMINED) is None
    assert _covariance.inverted(np.diag([1.0, -1.0, 1.0]), UNDETERMINED) is None
