"""A mixture of noise and outliers is found again."""

import numpy as np
import pytest
from scipy.special import xlogy

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.outliers import NoiseModel


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


def by_numpy(distance: Array, smallest: float, width: float) -> NoiseModel:
    """The criterion for each number of noise points, then the likelihood point by point."""
    squared = np.sort(distance**2)
    sums, many = np.cumsum(squared), len(squared)
    noise = np.arange(1, many + 1)
    scales, outliers = np.maximum(np.sqrt(sums / noise), smallest), many - noise
    normal = xlogy(noise, noise / (many * scales * np.sqrt(2.0 * np.pi))) - 0.5 * sums / scales**2
    best = int(np.argmax(normal + xlogy(outliers, outliers / (many * width))))
    scale, share = float(scales[best]), float(outliers[best]) / many
    density = np.exp(-0.5 * squared / scale**2) / (scale * np.sqrt(2.0 * np.pi))
    return NoiseModel(scale, share, float(np.log((1.0 - share) * density + share / width).sum()))


@pytest.mark.parametrize("n", [1, 2, 7, 64, 511, 512, 513, 1500])
@pytest.mark.parametrize("share", [0.0, 0.03, 0.5, 1.0])
@pytest.mark.parametrize(("sigma", "smallest"), [(0.01, 1e-14), (1e-9, 1e-12), (0.0, 1e-15), (1e-4, 3e-4)])
def test_a_mixture_is_that_of_numpy(n: int, share: float, sigma: float, smallest: float) -> None:
    """Among others without noise, with all of it below the smallest scale, and without any."""
    rng = np.random.default_rng(n)
    distance = rng.normal(0.0, sigma, n)
    far = rng.uniform(size=n) < share
    distance[far] = rng.uniform(-0.5, 0.5, n)[far]
    found, expected = NoiseModel.of(distance, smallest, 1.7), by_numpy(distance, smallest, 1.7)
    assert found.outlier_share == expected.outlier_share
    assert found.scale == pytest.approx(expected.scale, rel=1e-12)
    assert found.log_likelihood == pytest.approx(expected.log_likelihood, rel=1e-11, abs=1e-10)
