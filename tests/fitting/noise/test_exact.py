"""Points on the surface to the last digit are told from accidents."""

import numpy as np
import pytest

from primfit.fitting.noise import exact
from primfit.fitting.noise.exact import exact_points, is_peaked

Patch = pytest.MonkeyPatch


def test_exact_points_are_told_from_accidents() -> None:
    rng = np.random.default_rng(0)
    noise = np.abs(rng.normal(0.0, 1.0, 1000))
    assert not exact_points(noise, 0.05, dof=5).any()
    half = noise.copy()
    half[:300] = 1e-16
    assert exact_points(half, 1e-13, dof=5).sum() == 300
    assert exact_points(np.zeros(6), 1e-13, dof=5).all()
    interpolated = noise.copy()
    interpolated[:5] = 0.0
    assert not exact_points(interpolated, 1e-13, dof=5).any()


@pytest.mark.parametrize("n", [100, 20_000])
@pytest.mark.parametrize("steps", [3.0, 30.0, 1e9])
def test_noise_of_some_steps_has_no_exact_points(n: int, steps: float) -> None:
    distance = np.abs(np.random.default_rng(1).normal(0.0, 1.0, n))
    distance[:5] = 0.0
    assert not exact_points(distance, 1.0 / steps, dof=5).any()


def test_the_neighborhood_of_a_peak_is_near_it(monkeypatch: Patch) -> None:
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
