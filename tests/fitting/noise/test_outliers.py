"""A mixture of noise and outliers is found again."""

import numpy as np
import pytest

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
