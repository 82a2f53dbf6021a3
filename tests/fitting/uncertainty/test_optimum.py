"""What the optimum tells of the noise, where points are many, few, exact or rounded."""

import numpy as np
import pytest
from scipy.special import stdtrit

from primfit.fitting.answer.result import Recognition
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.uncertainty import optimum
from tests.fitting.clouds import EXAMPLES, noisy, sample
from tests.fitting.uncertainty.known import known

Patch = pytest.MonkeyPatch


def _sphere(points: np.ndarray) -> Recognition:
    answer = recognize(points, Config(kinds=("sphere",)))
    assert answer.primitive is not None and answer.noise is not None
    return answer


def test_the_noise_of_rounding_is_what_intervals_of_rounded_points_come_from(monkeypatch: Patch) -> None:
    """95 of 100 hold the truth; with the step itself in place of its standard deviation all would."""

    def off() -> np.ndarray:
        found = []
        for seed in range(20):
            uncertainty = (answer := _sphere(np.round(sample(EXAMPLES["sphere"], 60, seed), 4))).uncertainty
            assert uncertainty is not None and uncertainty.noise_model == "exact"
            spread = uncertainty.intervals["radius"].standard_deviation
            found.append((answer.primitive.radius - 1.3) / spread)  # type: ignore[union-attr]
        return np.asarray(found)

    assert 0.7 < np.sqrt(np.mean(off() ** 2)) < 1.4
    monkeypatch.setattr(optimum, "ROUNDING_NOISE", 1.0)
    assert np.sqrt(np.mean(off() ** 2)) < 0.5


def test_exact_points_leave_the_rounding() -> None:
    points = np.round(sample(EXAMPLES["sphere"], 500), 4)
    found = known(points, "sphere")
    assert found.noise_model == "exact"
    assert 1e-6 < found.intervals["radius"].standard_deviation < 1e-5


def test_few_points_of_a_sphere_have_the_intervals_of_a_regression() -> None:
    """s^2 (J^T J)^-1 with the derivatives by center and radius worked out by hand, and Student's t."""
    points = noisy(EXAMPLES["sphere"], 120, 0.01)
    answer = recognize(points, Config(kinds=("sphere",), criterion="least_squares"))
    assert isinstance(answer.primitive, Sphere) and answer.uncertainty is not None
    from_center = points - answer.primitive.center
    rho = np.linalg.norm(from_center, axis=1)
    jacobian = np.column_stack([-from_center / rho[:, None], -np.ones(120)])
    variance = np.sum((rho - answer.primitive.radius) ** 2) / (120 - 4)
    expected = np.sqrt(variance * np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    numbers = [*answer.primitive.center, answer.primitive.radius]
    for name, middle, deviation in zip(
        ("center.x", "center.y", "center.z", "radius"), numbers, expected, strict=True
    ):
        interval = answer.uncertainty.intervals[name]
        assert interval.method == "linear" and interval.low is not None and interval.high is not None
        assert interval.standard_deviation == pytest.approx(deviation, rel=1e-9)
        half = stdtrit(120 - 4, 0.975) * deviation
        np.testing.assert_allclose([interval.low, interval.high], [middle - half, middle + half], rtol=1e-12)


def test_twice_the_unit_is_twice_the_interval_and_four_times_the_points_half_of_it() -> None:
    cylinder = EXAMPLES["cylinder"]

    def deviations(n: int, unit: float) -> np.ndarray:
        found = recognize(
            unit * noisy(cylinder, n, 0.01), Config(kinds=("cylinder",), criterion="least_squares")
        ).uncertainty
        assert found is not None
        return np.array([each.standard_deviation for each in found.intervals.values()])

    np.testing.assert_allclose(deviations(1500, 2.0), 2.0 * deviations(1500, 1.0), rtol=1e-9)
    ratio = deviations(1500, 1.0) / deviations(6000, 1.0)
    assert np.exp(np.log(ratio).mean()) == pytest.approx(2.0, rel=0.15)


def test_under_weights_a_plane_has_the_position_of_a_weighted_regression() -> None:
    points = noisy(EXAMPLES["plane"], 150, 0.01)
    weights = np.where(np.arange(150) < 75, 2.0, 1.0)
    config = Config(kinds=("plane",), criterion="least_squares")
    weighted = recognize(points, config, weights=weights)
    x = points - np.average(points, axis=0, weights=weights)
    normal = np.linalg.svd(np.sqrt(weights)[:, None] * x)[2][2]
    assert weighted.primitive is not None and weighted.uncertainty is not None
    np.testing.assert_allclose(abs(weighted.primitive.row()[:3] @ normal), 1.0, rtol=1e-12)
    distance = x @ normal
    noise = np.sqrt(np.sum(weights * distance**2) / (150 - 3))
    position = weighted.uncertainty.position
    assert position is not None
    # the plane's point is that nearest to the mean of the points, where the offset depends on the tilt, too
    rows = np.column_stack([np.ones(150), (points - points.mean(axis=0)) @ np.linalg.svd(x)[2][:2].T])
    covariance = noise**2 * np.linalg.inv(rows.T @ (weights[:, None] * rows))
    assert position.standard_deviations[0] == pytest.approx(np.sqrt(covariance[0, 0]), rel=1e-3)
