"""What neighbors share counts in the intervals: against double sums, and laws whose mean is known."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from primfit.benchmark.coverage import waves
from primfit.fitting.cloud.patches import PATCHES, Halved
from primfit.fitting.fields.fields import Explanations
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.uncertainty import agreement
from primfit.fitting.uncertainty.agreement import Agreement, Correlation
from primfit.fitting.uncertainty.covariance import Linear
from tests.fitting.clouds import EXAMPLES, sample
from tests.fitting.pieces import ball, sheet
from tests.fitting.uncertainty.known import codes, flat, known

Patch = pytest.MonkeyPatch


def two_fields(patch: np.ndarray, seen: np.ndarray, reach: float) -> Agreement:
    """Half of the noise is each point's own; beside it a rough field of 0.2 and a smooth one; extent 2."""
    alone = [np.array([each]) for each in (1.0, 0.5, 3.0, 0.1, 2.0, reach / 2.0)]
    return Agreement(patch, seen, 2.0, *alone, None)


def fields_of(agreement: Agreement, linear: Linear) -> Array:
    """The covariance (k, k) of the sum of all rows under the fields of its only explanation."""
    parts = agreement.fields(linear.rows, linear.gain, linear.feet)
    return np.asarray(np.tensordot(agreement.shares[0, 1:], parts, 1))


def square(noise: Callable[[np.random.Generator, Array], Array], seed: int) -> tuple[Array, Array]:
    """Points (900, 3) of a unit square under noise of 0.002 by some law, and the same without noise."""
    rng = np.random.default_rng(seed)
    places = rng.uniform(-0.5, 0.5, (900, 3)) * [1.0, 1.0, 0.0]
    return places + np.outer(0.002 * noise(rng, places), [0.0, 0.0, 1.0]), places


def test_fields_are_neither_certain_nor_impossible(monkeypatch: Patch) -> None:
    """`FIELDS`: intervals are too long under independent noise, or too short under waves."""

    def deviation(points: Array, kind: str) -> float:
        known = recognize(points, Config(kinds=(kind,))).uncertainty
        assert known is not None and known.covariance is not None
        return float(np.sqrt(np.abs(np.asarray(known.covariance)).max()))

    white, wavy = ball(1000, 0.005, 2), sheet(1000, 0.005, 0)
    wavy[:, 2] += 0.005 * np.sin(9.0 * wavy[:, 0] + 1.0) * np.sin(7.0 * wavy[:, 1])
    usual = deviation(white, "sphere"), deviation(wavy, "plane")
    monkeypatch.setattr(agreement, "FIELDS", 0.9)
    assert deviation(white, "sphere") > 1.3 * usual[0]
    monkeypatch.setattr(agreement, "FIELDS", 1e-100)
    assert deviation(wavy, "plane") < 0.8 * usual[1]


def test_correlated_noise_is_found_and_counts() -> None:
    points = sample(EXAMPLES["cylinder"], 2000)
    rng, outward = np.random.default_rng(2), EXAMPLES["cylinder"].gradient(points)
    smooth = known(points + 0.005 * waves(rng, points / 0.15)[:, None] * outward, "cylinder")
    rough = known(points + 0.005 * rng.standard_normal((2000, 1)) * outward, "cylinder")
    assert (smooth.noise_model, rough.noise_model) == ("correlated", "independent")
    assert smooth.correlation is not None and 0.1 < smooth.correlation.length < 0.22
    assert "correlated_noise" in codes(smooth) and "correlated_noise" not in codes(rough)
    radii = [each.intervals["radius"].standard_deviation for each in (smooth, rough)]
    assert radii[0] > 2.0 * radii[1]


def test_fields_count_as_in_the_double_sum_over_patches() -> None:
    linear = flat(300, np.random.default_rng(3))
    feet = linear.feet.T
    patch, seen = Halved.of(feet).patches(), np.arange(300) % 7 > 0
    agreement = two_fields(patch, seen, 0.4)
    middle = np.array([feet[seen & (patch == each)].mean(axis=0) for each in patch])
    apart = cdist(middle, middle)
    covariance = 3.0 * np.exp(-apart / 0.2) + 2.0 * np.exp(-((apart / 0.4) ** 2) / 2.0)
    rows = linear.rows.T * seen[:, None]
    np.testing.assert_allclose(fields_of(agreement, linear), rows.T @ covariance @ rows, rtol=1e-9)
    alone, found = linear.uneven(None), linear.uneven(agreement)
    assert alone is not None and found is not None
    bread = np.linalg.inv(linear.rows @ linear.rows.T)
    expected = 0.5 * alone.matrix + bread @ rows.T @ covariance @ rows @ bread
    np.testing.assert_allclose(found.matrix, expected, rtol=1e-9)


def test_a_bow_as_wide_as_the_cloud_has_no_mean() -> None:
    """So that it moves no plane along its normal, whose rows are 1."""
    linear = flat(300, np.random.default_rng(3))
    patch, seen = Halved.of(linear.feet.T).patches(), np.ones(300, bool)
    narrow, wide = (fields_of(two_fields(patch, seen, reach), linear) for reach in (0.4, 2.0))
    left = wide - fields_of(replace(two_fields(patch, seen, 2.0), smooth=np.zeros(1)), linear)
    assert abs(left[0, 0]) < 1e-9 * narrow[0, 0] and left[1, 1] > 0.0


def test_under_exponential_noise_intervals_are_as_much_longer_as_the_variance_of_the_mean() -> None:
    """Of noise with the correlation exp(-h / 0.1) the mean varies by the mean of it over all pairs."""

    def noise(rng: np.random.Generator, places: Array) -> Array:
        correlation = np.exp(-cdist(places, places) / 0.1)
        return np.linalg.cholesky(correlation + 1e-9 * np.eye(900)) @ rng.standard_normal(900)

    ratios = []
    for seed in range(10):
        points, places = square(noise, seed)
        found = known(points, "plane")
        assert found.position is not None and found.noise_model == "correlated"
        true = 0.002 * np.sqrt(np.exp(-cdist(places, places) / 0.1).mean())
        ratios.append(found.position.standard_deviations[0] / true)
    # ranges are a factor of three apart, in which the deviation of a mean goes with the range
    assert 0.7 < np.exp(np.mean(np.log(ratios))) < 3.0


def test_a_bow_of_half_the_noise_makes_intervals_longer() -> None:
    def bowed(rng: np.random.Generator, places: Array) -> Array:
        along = places[:, 0] ** 2
        return np.asarray(rng.standard_normal(900) + (along - along.mean()) / along.std() / 2.0)

    flat, bent = (
        known(square(noise, 1)[0], "plane").direction
        for noise in (lambda rng, places: rng.standard_normal(len(places)), bowed)
    )
    assert flat is not None and bent is not None
    # a plane is tilted by noise as the mean, over the root mean square of a coordinate; a bow may tilt it by
    # as much as it rises, half the noise over the same
    tilt = 0.002 * np.sqrt(12.0)
    assert flat.standard_deviations[0] < 1.5 * tilt / np.sqrt(900) < tilt / 2.0 < bent.standard_deviations[0]


def test_fields_of_no_range_and_of_endless_range_are_sums_within_and_over_patches() -> None:
    """The first leaves each patch a variance of its own; the second moves all patches alike."""
    linear = flat(300, np.random.default_rng(3))
    patch, seen = Halved.of(linear.feet.T).patches(), np.ones(300, bool)
    sums = np.array([linear.rows[:, patch == each].sum(axis=1) for each in np.unique(patch)])
    only_rough = replace(two_fields(patch, seen, 0.4), smooth=np.zeros(1))
    short, endless = (
        fields_of(replace(only_rough, rough_range=np.array([span])), linear) for span in (1e-6, 1e9)
    )
    np.testing.assert_allclose(short, 3.0 * sums.T @ sums, rtol=1e-9)
    total = linear.rows.sum(axis=1)
    np.testing.assert_allclose(endless, 3.0 * np.outer(total, total), rtol=1e-6, atol=1e-6)


def test_ripple_longer_than_a_patch_is_seen_whatever_the_unit_and_the_listing() -> None:
    points = sample(EXAMPLES["cylinder"], 1500)
    outward = EXAMPLES["cylinder"].gradient(points)
    points = points + 0.005 * waves(np.random.default_rng(5), points / 0.15)[:, None] * outward
    one = known(points, "cylinder").correlation
    other = known(1000.0 * points[np.random.default_rng(6).permutation(1500)], "cylinder").correlation
    assert one is not None and other is not None
    assert (other.share, other.power) == (pytest.approx(one.share, rel=1e-6), one.power)
    assert other.length == pytest.approx(1000.0 * one.length, rel=1e-6)


def test_patches_whose_means_vary_too_little_have_no_correlation_of_their_own() -> None:
    """A field is likely, but none as likely as that the means agree less than independent points would."""
    none, some = np.zeros(4), np.array([0.0, 1.0, 1.0, 1.0])
    found = Explanations(
        log_evidence=none,
        white=np.ones(4),
        rough=none,
        rough_range=none,
        smooth=some,
        smooth_range=0.1 * some,
        rough_size=none,
        smooth_size=some,
        apart=0.0,
        apart_white=0.5,
        hidden=1.0,
        spread=np.ones(3),
        unexplained=None,
    )
    weights = np.array([0.0, 0.2, 0.2, 0.2, 0.4])
    correlation = agreement._correlation(found, weights, 1.0, 100, 1.0)
    assert correlation == Correlation(pytest.approx(np.sqrt(2.0) * 0.1), 0.5, 2)
    more = agreement._correlation(replace(found, apart_white=2.0), weights, 1.0, 100, 1.0)
    assert more.length == pytest.approx(np.sqrt(1.0 / (np.pi * PATCHES))) and more.share == 1.0
