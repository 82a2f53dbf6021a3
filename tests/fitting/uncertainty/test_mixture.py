"""The covariance whose intervals are those of a mixture: against the mixture itself, and what must be so."""

import numpy as np
import pytest
from scipy.special import stdtr, stdtrit

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.noise.student import half_interval
from primfit.fitting.uncertainty import covariance
from primfit.fitting.uncertainty._covariance import mixture_ends
from tests.fitting.uncertainty import reference_covariance as reference

FREE = 60
UNIT = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, -2e-4], [0.0, -2e-4, 1e-6]])


def mixed(parts: Array, weights: Array) -> Array:
    """Of covariances (T, k, k), each of which has a meat of its own."""
    root = np.linalg.inv(UNIT)
    return covariance.mixed(root @ parts @ root, np.eye(len(parts)), weights, UNIT, FREE)[0]


def test_of_one_covariance_it_is_this_one() -> None:
    one = UNIT + np.diag([0.0, 3.0, 0.0])
    np.testing.assert_allclose(mixed(one[None], np.ones(1)), one, rtol=1e-11, atol=1e-15)


@pytest.mark.parametrize("share", [0.01, 0.1, 0.6])
def test_the_ends_leave_five_of_100_cases_of_the_mixture(share: float) -> None:
    parts, weights = np.stack([UNIT, 900.0 * UNIT]), np.array([1.0 - share, share])
    found = mixed(parts, weights)
    ends = stdtrit(FREE, 0.975) * np.sqrt(np.diag(found))
    beyond = 2.0 * stdtr(FREE, -ends[None] / np.sqrt(np.einsum("tii->ti", parts)))
    np.testing.assert_allclose(weights @ beyond, 0.05, atol=1e-12)


def test_what_is_unlikely_and_large_hardly_counts() -> None:
    found = mixed(np.stack([UNIT, 1e6 * UNIT]), np.array([0.99, 0.01]))
    # 1% of the cases are beyond, and 4% of the others may be: 2.10 standard deviations in place of 2.00
    np.testing.assert_allclose(found, (2.10 / 2.00) ** 2 * UNIT, rtol=0.02, atol=1e-9)


def test_without_noise_nothing_is_uncertain() -> None:
    assert not mixed(np.zeros((2, 3, 3)), np.array([0.5, 0.5])).any()


@pytest.mark.parametrize("free", [1, 2, 3, 4, 57, 60, 64])
def test_ends_are_those_of_bisection(free: int) -> None:
    """Over many decades of the standard deviations, and of the probabilities."""
    rng = np.random.default_rng(free)
    deviations, weights = 10.0 ** rng.uniform(-3.0, 3.0, (7, 60)), 10.0 ** rng.uniform(-20.0, 0.0, 60)
    weights /= weights.sum()
    found = mixture_ends(deviations, weights, free, 0.95)
    np.testing.assert_allclose(found, reference.ends(deviations.T, weights, free), rtol=1e-11)


def test_what_is_certain_needs_no_interval() -> None:
    deviations, weights = np.array([[0.0, 1.0, 0.0], [0.0, 2.0, 0.0]]), np.array([0.5, 0.03, 0.47])
    np.testing.assert_array_equal(mixture_ends(deviations, weights, FREE, 0.95), 0.0)
    weights = np.array([0.5, 0.1, 0.4])
    half = mixture_ends(deviations, weights, FREE, 0.95)
    np.testing.assert_allclose(2.0 * stdtr(FREE, -half / [1.0, 2.0]), 0.5, rtol=1e-12)


def test_one_part_has_the_quantile_of_student() -> None:
    found = mixture_ends(np.array([[3.0]]), np.ones(1), FREE, 0.95)
    np.testing.assert_allclose(found, 3.0 * half_interval(FREE), rtol=1e-12)
    assert half_interval(None) == pytest.approx(1.959963984540054, rel=1e-12)


def test_the_first_meat_has_its_share_of_the_variance() -> None:
    """In the mean over directions: a trace over the inverse of the unit, as it says."""
    root = np.linalg.inv(UNIT)
    parts, weights = np.stack([UNIT, UNIT + np.diag([90.0, 0.0, 0.0])]), np.array([0.3, 0.7])
    found, alike = covariance.mixed(root @ parts @ root, np.eye(2), weights, UNIT, FREE)
    assert alike == pytest.approx(np.trace(root @ parts[0]) / np.trace(root @ found), rel=1e-9)
