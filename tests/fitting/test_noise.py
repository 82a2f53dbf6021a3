"""fitting/noise/: laws that it rests on, and for each of its numbers what goes wrong without it."""

import numpy as np
import pytest

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.noise import exact, rounding, scale
from primfit.fitting.noise.exact import exact_points, is_peaked
from primfit.fitting.noise.outliers import NoiseModel
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.uncertainty import optimum
from tests.fitting.clouds import EXAMPLES, noisy, rotation, sample

Patch = pytest.MonkeyPatch


def _sphere(points: np.ndarray) -> Recognition:
    answer = recognize(points, Config(kinds=("sphere",)))
    assert answer.primitive is not None and answer.noise is not None
    return answer


def _radius_error(points: np.ndarray) -> float:
    return abs(float(_sphere(points).primitive.radius) - 1.3)  # type: ignore[union-attr]


@pytest.mark.parametrize("share", [0.0, 0.1, 0.4, 0.65])
@pytest.mark.parametrize("sigma", [3e-4, 0.01])
def test_a_mixture_is_found_again(share: float, sigma: float) -> None:
    rng = np.random.default_rng(0)
    distance = rng.normal(0.0, sigma, 2000)
    distance[: round(share * 2000)] = rng.uniform(-0.5, 0.5, round(share * 2000))
    found = NoiseModel.of(distance, 1e-14, 1.0)
    assert found.scale == pytest.approx(sigma, rel=0.08)
    assert found.outlier_share == pytest.approx(share, abs=0.03)


def test_a_mixture_of_no_noise_has_the_smallest_scale() -> None:
    found = NoiseModel.of(np.zeros(10), 1e-3, 1.0)
    assert (found.scale, found.outlier_share) == (1e-3, 0.0)


@pytest.mark.parametrize("n", [100, 20_000])
@pytest.mark.parametrize("steps", [3.0, 30.0, 1e9])
def test_noise_of_some_steps_has_no_exact_points(n: int, steps: float) -> None:
    distance = np.abs(np.random.default_rng(1).normal(0.0, 1.0, n))
    distance[:5] = 0.0
    assert not exact_points(distance, 1.0 / steps, dof=5).any()


# -- what each number is for --------------------------------------------------------------------------------


def test_without_a_margin_of_rounding_a_cloud_that_was_turned_often_is_not_exact(monkeypatch: Patch) -> None:
    points = sample(EXAMPLES["torus"], 600)
    for seed in range(100):
        points = points @ rotation(seed).T

    def exact_share() -> float:
        answer = recognize(points)
        assert answer.noise is not None
        return answer.noise.exact_share

    assert exact_share() == 1.0
    monkeypatch.setattr(rounding, "ULPS", 1)
    assert exact_share() < 0.9


def test_a_coarse_step_taken_for_a_rounding_makes_a_grid_collinear(monkeypatch: Patch) -> None:
    grid = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0), [0.0]), axis=-1).reshape(-1, 3)
    assert recognize(grid).primitive is not None
    monkeypatch.setattr(rounding, "COARSEST_STEPS", 1)
    with pytest.raises(InvalidPointCloudError, match="collinear"):
        recognize(grid)


def test_a_fine_step_taken_for_noise_hides_the_exact_points(monkeypatch: Patch) -> None:
    points = sample(EXAMPLES["sphere"], 1000)
    points[:800] += np.random.default_rng(2).uniform(-0.1, 0.1, (800, 3))
    points = np.round(points, 4)
    assert _radius_error(points) < 1e-5
    monkeypatch.setattr(rounding, "COARSEST_STEPS", np.inf)
    assert _radius_error(points) > 1e-3


def test_the_neighbourhood_of_a_peak_is_near_it(monkeypatch: Patch) -> None:
    """A wide one has fewer points for its width, and all noise is peaked; a narrow one has too few."""
    rng = np.random.default_rng(4)
    noise = rng.normal(size=(40, 2000))
    assert np.mean([is_peaked(each, 5) for each in noise]) < 0.1
    peaked = noise.copy()
    peaked[:, :60] *= 0.03
    assert np.mean([is_peaked(each, 5) for each in peaked]) > 0.9
    monkeypatch.setattr(exact, "AROUND", 30.0)
    assert np.mean([is_peaked(each, 5) for each in noise]) > 0.9
    monkeypatch.setattr(exact, "AROUND", 1.1)
    assert np.mean([is_peaked(each, 5) for each in peaked]) < 0.6


def test_without_a_core_outliers_are_noise(monkeypatch: Patch) -> None:
    rng = np.random.default_rng(3)
    points = noisy(EXAMPLES["sphere"], 1000, 0.01)
    points[:300] = rng.uniform(-1.0, 2.0, (300, 3))
    assert _radius_error(points) < 2e-3
    monkeypatch.setattr(scale, "CORE", 1e3)
    monkeypatch.setattr(scale, "CORE_DEVIATION", 1.0)
    assert _radius_error(points) > 1e-2


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
