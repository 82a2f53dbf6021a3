"""What goes over all points of a verdict, held against NumPy."""

import numpy as np
import pytest

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.solver.refine import CODES, linearize
from primfit.fitting.trial.limits import moved
from primfit.fitting.verdict import _evidence
from tests.fitting.clouds import EXAMPLES, noisy


@pytest.mark.parametrize("pivot", [np.zeros(3), np.array([0.3, -0.2, 0.1])])
@pytest.mark.parametrize("kind", EXAMPLES)
def test_slopes_and_feet_are_those_of_the_surface(kind: str, pivot: Array) -> None:
    """About a pivot, too, and where the apex of a cone is the closest point."""
    primitive: Primitive = EXAMPLES[kind]
    points = np.vstack([noisy(primitive, 300, 0.1), np.random.default_rng(1).normal(size=(300, 3))])
    there = moved(primitive, -pivot)
    residual, jacobian, feet = _evidence.linear(CODES[kind], there.row(), points, pivot)
    expected, slopes = linearize(there, points - pivot)
    np.testing.assert_array_equal(residual, expected)
    np.testing.assert_array_equal(jacobian, slopes)
    away = primitive.signed_distance(points)[:, None] * primitive.gradient(points)
    np.testing.assert_allclose(feet, points - away, atol=1e-13)


def test_no_points_have_no_slopes() -> None:
    primitive = EXAMPLES["torus"]
    residual, jacobian, feet = _evidence.linear(
        CODES["torus"], primitive.row(), np.empty((0, 3)), np.zeros(3)
    )
    assert (residual.shape, jacobian.shape, feet.shape) == ((0,), (0, 7), (0, 3))


@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.8, 1.0])
def test_inliers_count_where_they_are_at_least_half(share: float) -> None:
    rng = np.random.default_rng(2)
    patch = rng.integers(0, 40, 200)
    inlier = rng.uniform(size=200) < share
    most = np.bincount(patch, inlier) >= 0.5 * np.bincount(patch)
    found = _evidence.mostly(patch, inlier.view(np.uint8))
    np.testing.assert_array_equal(found.view(bool), inlier & most[patch])
