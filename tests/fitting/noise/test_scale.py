"""The scale of the noise is that of its core; normal noise is told from other."""

import numpy as np
import pytest
from scipy.integrate import quad

from primfit.fitting.noise.scale import CORE, CORE_DEVIATION, core_scale, is_normal
from primfit.fitting.search import polish
from tests.fitting.clouds import EXAMPLES, noisy
from tests.fitting.noise.spheres import radius_error

Patch = pytest.MonkeyPatch


def test_the_deviation_of_a_core_is_the_ratio_of_its_integrals() -> None:
    def density(x: float) -> float:
        return float((1.0 - (x / CORE) ** 2) ** 2 * np.exp(-0.5 * x**2))

    squares = quad(lambda x: x**2 * density(x), 0.0, CORE)[0]
    variance = squares / quad(density, 0.0, CORE)[0]
    assert CORE_DEVIATION == pytest.approx(np.sqrt(variance), rel=1e-14)


@pytest.mark.parametrize("outliers", [0, 1500])
def test_the_scale_is_that_of_the_core(outliers: int) -> None:
    rng = np.random.default_rng(0)
    distance = np.abs(rng.normal(0.0, 0.02, 5000))
    distance[:outliers] = rng.uniform(0.0, 3.0, outliers)
    assert core_scale(distance) == pytest.approx(0.02, rel=0.05)


def test_normal_noise_is_told_from_heavy_tails_outliers_and_uneven_noise() -> None:
    rng = np.random.default_rng(4)
    noise = rng.normal(0.0, 0.3, (40, 2000))
    uneven = noise * rng.uniform(0.3, 3.0, 2000)
    assert np.mean([is_normal(each, 6.0 * 0.3) for each in noise]) > 0.9
    assert not any(is_normal(each, 6.0 * 0.3) for each in uneven / 2.0)
    assert not is_normal(np.append(noise[0], 1.9), 1.8), "one point beyond the largest is an outlier"
    heavy = [np.clip(rng.standard_t(5, 2000), -8.0, 8.0) for _ in range(10)]
    assert not any(is_normal(each, 8.0) for each in heavy)
    assert not is_normal(np.zeros(10), 1.0), "of exact points nothing is known"


def test_without_a_core_outliers_are_noise(monkeypatch: Patch) -> None:
    rng = np.random.default_rng(3)
    points = noisy(EXAMPLES["sphere"], 1000, 0.01)
    points[:300] = rng.uniform(-1.0, 2.0, (300, 3))
    assert radius_error(points) < 2e-3
    monkeypatch.setattr(polish, "CORE", 1e3)
    monkeypatch.setattr(polish, "CORE_DEVIATION", 1.0)
    assert radius_error(points) > 1e-2
