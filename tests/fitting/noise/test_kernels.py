"""Kernels: weights and slopes are derivatives, and the tuning is that of the textbook."""

import numpy as np
import pytest

from primfit.fitting.noise.kernels import CUTOFF, HUBER_95, TUKEY_95, Kernel


@pytest.mark.parametrize("kernel", Kernel, ids=lambda kernel: kernel.name.lower())
def test_weights_are_the_derivative_of_the_cost(kernel: Kernel) -> None:
    x = np.linspace(0.01, 8.0, 200)
    slope = (kernel.rho((x + 1e-6) ** 2) - kernel.rho((x - 1e-6) ** 2)) / 2e-6
    np.testing.assert_allclose(kernel.weight(x**2), slope / x, atol=1e-6)
    assert kernel.weight(np.zeros(1))[0] == 1.0


def test_the_tuning_leaves_95_per_cent_of_the_efficiency() -> None:
    """Variance of a location under normal noise, E psi^2 / (E psi')^2, by quadrature."""
    x = np.linspace(-10.0, 10.0, 400_001)
    density = np.exp(-0.5 * x**2) / np.sqrt(2.0 * np.pi) * (x[1] - x[0])
    for kernel, width in ((Kernel.HUBER, HUBER_95), (Kernel.TUKEY, TUKEY_95 / CUTOFF)):
        psi = kernel.weight((x / width) ** 2) * x
        slope = np.gradient(psi, x)
        assert (slope @ density) ** 2 / (psi**2 @ density) == pytest.approx(0.95, abs=2e-4)


@pytest.mark.parametrize("kernel", Kernel)
def test_the_slope_of_a_kernel_is_that_of_its_pull(kernel: Kernel) -> None:
    x, step = np.array([0.0, 0.3, 0.9, 1.7, 4.0, 5.5, 7.0]), 1e-6
    pulls = [kernel.weight((x + sign * step) ** 2) * (x + sign * step) for sign in (1.0, -1.0)]
    np.testing.assert_allclose(kernel.slope(x**2), (pulls[0] - pulls[1]) / (2.0 * step), atol=1e-8)
