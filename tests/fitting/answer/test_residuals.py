"""Residuals have one sign for all kinds, and inliers are those of the answer."""

import numpy as np
import pytest

from primfit.fitting.answer.residuals import PERCENTILES, Deviations
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config

AXIS, HERE = [0.3, -0.5, 0.8], [10.0, 20.0, 30.0]
SHAPES: list[Primitive] = [
    Plane(AXIS, HERE),
    Sphere(HERE, 15.0),
    Cylinder(AXIS, HERE, 8.0),
    Cone(HERE, AXIS, 0.4),
    Torus(HERE, AXIS, 20.0, 6.0),
]


@pytest.mark.parametrize("criterion", ["robust", "least_squares", "minimum_zone"])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_the_inliers_of_all_points_are_those_that_the_error_counts(shape: Primitive, criterion: str) -> None:
    rng = np.random.default_rng(0)
    feet = shape.surface(rng.uniform(0.5, 6.0, 2000), rng.uniform(1.0, 3.0, 2000))
    points = feet + rng.normal(0.0, 0.01, (2000, 3))
    stray = rng.permutation(2000)[:50]
    points[stray] += 0.5 * shape.gradient(feet[stray])
    found = recognize(points, Config(kinds=(shape.kind,), criterion=criterion))  # type: ignore[arg-type]
    assert found.inlier_rule and found.error
    inlier = found.inlier_rule.among(points)
    assert inlier.mean() == found.error.inlier_share
    assert not inlier[stray].any() and inlier.mean() > 0.96


def test_of_few_points_none_is_rejected() -> None:
    found = recognize(np.eye(4)[:, :3], Config(kinds=("plane",)))
    assert found.inlier_rule and found.inlier_rule.reach == np.inf
    assert found.inlier_rule.among(np.full((1, 3), 1e9)).all()


def test_deviations_by_hand() -> None:
    found = Deviations.of(np.array([-3.0, -1.0, 0.0, 1.0, 2.0]))
    assert (found.n_points, found.min, found.max) == (5, -3.0, 2.0)
    assert found.mean == pytest.approx(-0.2) and found.mean_absolute == pytest.approx(1.4)
    assert found.rms == pytest.approx(np.sqrt(3.0))
    assert tuple(found.percentiles) == PERCENTILES and found.percentiles[50.0] == 0.0
    assert found.histogram.edges[[0, 20, -1]].tolist() == [-3.0, 0.0, 3.0]
    assert found.histogram.counts.sum() == 5


def test_no_deviation_and_tiny_ones_have_a_histogram() -> None:
    for size in (0.0, 5e-324, 1e-200, 1e200):
        found = Deviations.of(np.array([size, -size]))
        assert np.isfinite(found.histogram.edges).all() and found.histogram.counts.sum() == 2
        assert found.rms == pytest.approx(size)
