"""The covariance whose intervals are those of a mixture: against the mixture itself, and what must be so."""

import numpy as np
import pytest
from scipy.special import stdtr, stdtrit

from primfit.fitting.uncertainty.mixture import mixed

FREE = 60.0
UNIT = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, -2e-4], [0.0, -2e-4, 1e-6]])


def test_of_one_covariance_it_is_this_one() -> None:
    one = UNIT + np.diag([0.0, 3.0, 0.0])
    # a quantile is bisected to six digits
    np.testing.assert_allclose(mixed(one[None], np.ones(1), UNIT, FREE), one, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("share", [0.01, 0.1, 0.6])
def test_the_ends_leave_five_of_100_cases_of_the_mixture(share: float) -> None:
    parts, weights = np.stack([UNIT, 900.0 * UNIT]), np.array([1.0 - share, share])
    found = mixed(parts, weights, UNIT, FREE)
    ends = stdtrit(FREE, 0.975) * np.sqrt(np.diag(found))
    beyond = 2.0 * stdtr(FREE, -ends[None] / np.sqrt(np.einsum("tii->ti", parts)))
    np.testing.assert_allclose(weights @ beyond, 0.05, atol=1e-6)


def test_what_is_unlikely_and_large_hardly_counts() -> None:
    found = mixed(np.stack([UNIT, 1e6 * UNIT]), np.array([0.99, 0.01]), UNIT, FREE)
    # 1 % of the cases are beyond, and 4 % of the others may be: 2.10 standard deviations in place of 2.00
    np.testing.assert_allclose(found, (2.10 / 2.00) ** 2 * UNIT, rtol=0.02, atol=1e-9)


def test_without_noise_nothing_is_uncertain() -> None:
    assert not mixed(np.zeros((2, 3, 3)), np.array([0.5, 0.5]), UNIT, FREE).any()
