"""Weights and standard deviations of points count as they should, and bad ones are named."""

from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from primfit.benchmark.proofs import oracles
from primfit.benchmark.proofs.constraint_oracle import chart
from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import EXTREME
from tests.fitting.clouds import EXAMPLES
from tests.fitting.constrained import CLOUDS, FAR, fit

WEIGHTS = np.random.default_rng(9).uniform(0.2, 5.0, 300)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_weighted_least_squares_is_that_of_scipy(kind: str) -> None:
    points = CLOUDS[kind] - FAR
    build, start = chart({}, oracles.long(parameters(EXAMPLES[kind])))
    solved = least_squares(
        lambda x: np.sqrt(WEIGHTS) * oracles.distances(kind, build(x), points).astype(float),
        start, x_scale="jac", ftol=1e-15, xtol=1e-15, gtol=1e-15,
    )  # fmt: skip
    for given in ({"weights": WEIGHTS}, {"standard_deviations": 7.0 / np.sqrt(WEIGHTS)}):
        found = fit(kind, {}, points=points, **given).primitive
        assert found is not None
        assert 0.5 * np.sum(WEIGHTS * found.signed_distance(points) ** 2) == pytest.approx(
            solved.cost, rel=1e-10
        )


@pytest.mark.parametrize("criterion", ["robust", "least_squares"])
def test_equal_weights_are_none(criterion: str) -> None:
    points = CLOUDS["cylinder"]
    expected = fit("cylinder", {}, criterion, points=points)
    assert expected.primitive is not None
    for given in ({"weights": np.full(300, 3.0)}, {"standard_deviations": np.full(300, 0.01)}):
        found = fit("cylinder", {}, criterion, points=points, **given)
        assert found.primitive is not None
        assert parameters(found.primitive) == parameters(expected.primitive)


@pytest.mark.parametrize("criterion", ["robust", "least_squares"])
def test_a_weight_of_zero_leaves_a_point_out_and_a_factor_changes_nothing(criterion: str) -> None:
    weights = WEIGHTS.copy()
    weights[::4] = 0.0
    points, kept = CLOUDS["cone"].copy(), weights > 0.0
    points[::4] += 5.0
    expected = fit("cone", {}, criterion, points=points[kept], weights=weights[kept])
    found = fit("cone", {}, criterion, points=points, weights=weights)
    assert found.primitive is not None and expected.primitive is not None
    assert parameters(found.primitive) == parameters(expected.primitive)
    assert found.n_points == kept.sum()
    scaled = fit("cone", {}, criterion, points=points, weights=2.0**20 * weights).primitive
    assert scaled is not None
    assert parameters(scaled) == parameters(found.primitive)


def test_weights_follow_the_points_of_a_large_cloud() -> None:
    """Half of 40,000 points have ten times the noise, and say so: the answer is as good as theirs allows."""
    rng = np.random.default_rng(1)
    truth = Sphere([1.0, 2.0, 3.0], 2.0)
    points = truth.surface(rng.uniform(0, 1, 40_000), rng.uniform(0.2, 1, 40_000))
    sigma = np.where(rng.random(40_000) < 0.5, 0.2, 0.002)
    points += sigma[:, None] * rng.normal(size=points.shape)
    radii = {}
    for name, given in {"plain": {}, "weighted": {"standard_deviations": sigma}}.items():
        found = fit("sphere", {}, points=points, **given).primitive
        assert isinstance(found, Sphere)
        radii[name] = abs(found.radius - 2.0)
    assert radii["weighted"] < 5e-3 < radii["plain"]


@pytest.mark.parametrize(
    ("given", "field", "said"),
    [
        ({"weights": np.ones(5)}, "weights", r"\(300,\) is needed"),
        ({"weights": -np.ones(300)}, r"weights[0]", "-1"),
        ({"weights": np.full(300, np.nan)}, r"weights[0]", "nan"),
        ({"weights": np.eye(300)[0]}, "weights", "1 points have a weight over zero"),
        ({"weights": ["a"] * 300}, "weights", "numbers"),
        ({"standard_deviations": np.zeros(300)}, "standard_deviations[0]", "is 0"),
        ({"standard_deviations": np.ones(300), "weights": np.ones(300)}, "weights", "not both"),
    ],
)
def test_bad_weights_are_named(given: dict[str, Any], field: str, said: str) -> None:
    with pytest.raises(InvalidPointCloudError, match=said) as caught:
        recognize(CLOUDS["sphere"], **given)
    assert caught.value.field == field


@pytest.mark.parametrize("criterion", EXTREME)
@pytest.mark.parametrize("name", ["weights", "standard_deviations"])
def test_extreme_points_take_no_weights(criterion: Any, name: str) -> None:
    with pytest.raises(InvalidPointCloudError, match=f"takes no {name}; these do: robust") as caught:
        fit("sphere", {}, criterion, **{name: np.ones(300)})
    assert caught.value.field == name
