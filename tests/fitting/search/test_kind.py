"""The fit of one kind: exact clouds, noise, outliers."""

import numpy as np
import pytest

from primfit.fitting.cloud.cloud import Cloud
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.search.kind import Fit, fit_kind
from primfit.fitting.trial.trial import Trial
from tests.fitting.clouds import EXAMPLES, noisy, sample

examples = pytest.mark.parametrize("primitive", EXAMPLES.values(), ids=EXAMPLES.keys())


def test_least_squares_ends_the_robust_fit_where_the_noise_is_normal() -> None:
    """Isotropic noise has tails hardly heavier than normal ones; with outliers the biweight stays."""
    points = noisy(EXAMPLES["sphere"], 600, 0.01)
    rng = np.random.default_rng(0)

    def costs(cloud: Cloud) -> tuple[float, float]:
        fit = fit_kind(Trial("sphere", cloud), "least_squares", rng)
        assert isinstance(fit, Fit)
        each = (fit.finished.primitive, fit.robust)
        return tuple(float(np.sum(p.signed_distance(cloud.points) ** 2)) for p in each)  # type: ignore[return-value]

    plain, robust = costs(Cloud.prepare(points, None, rng))
    assert robust == pytest.approx(plain, rel=1e-12)
    points[:20] += 0.5
    plain, robust = costs(Cloud.prepare(points, None, rng))
    assert robust > 1.01 * plain


@examples
def test_each_kind_is_fitted_to_its_own_exact_cloud(primitive: Primitive) -> None:
    rng = np.random.default_rng(0)
    points = sample(primitive, 700)
    cloud = Cloud.prepare(points, None, rng)
    found = fit_kind(Trial(primitive.kind, cloud), "robust", rng)
    assert isinstance(found, Fit)
    assert np.abs(cloud.frame.restore(found.finished.primitive).signed_distance(points)).max() < 1e-13


@examples
def test_noise_costs_no_more_than_least_squares_on_the_truth(primitive: Primitive) -> None:
    """Robust refinement of a cloud without outliers is within a few per cent of the plain optimum."""
    rng = np.random.default_rng(0)
    points = noisy(primitive, 800, 0.01)
    cloud = Cloud.prepare(points, None, rng)
    fit = fit_kind(Trial(primitive.kind, cloud), "least_squares", rng)
    assert isinstance(fit, Fit)
    cost_robust, cost_plain = (
        np.sum(each.signed_distance(cloud.points) ** 2) for each in (fit.robust, fit.finished.primitive)
    )
    assert cost_plain <= (1.0 + 1e-12) * cost_robust <= 1.01 * cost_plain


def test_a_third_of_gross_outliers_moves_a_cylinder_little() -> None:
    rng = np.random.default_rng(4)
    cylinder = EXAMPLES["cylinder"]
    points = noisy(cylinder, 900, 0.005)
    points[:300] = rng.uniform(points.min(axis=0) - 1.0, points.max(axis=0) + 1.0, (300, 3))
    cloud = Cloud.prepare(points, None, rng)
    found = fit_kind(Trial("cylinder", cloud), "robust", rng)
    assert isinstance(found, Fit) and isinstance(found.finished.primitive, Cylinder)
    restored = cloud.frame.restore(found.finished.primitive)
    assert restored.radius == pytest.approx(0.8, abs=0.005)
    assert abs(restored.axis @ cylinder.axis) > 0.9999  # type: ignore[attr-defined]
