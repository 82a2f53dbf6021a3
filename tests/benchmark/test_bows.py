"""Parts that deviate by a known multiple of their noise."""

from collections import Counter

import numpy as np
import pytest

from primfit.benchmark.bows import NOISE, POINTS, beyond, bowed_cloud, deviating
from primfit.benchmark.cases import AMPLITUDES, CASE_SETS
from primfit.fitting.names import KINDS
from primfit.fitting.solver.refine import refine
from primfit.synthetic.bows import DEVIATIONS_OF

PARTS = [(kind, deviation) for kind in KINDS for deviation in DEVIATIONS_OF[kind]]


@pytest.mark.parametrize(("kind", "deviation"), PARTS)
def test_the_deviation_is_the_stated_multiple_of_the_noise(kind, deviation):
    """The same part without and with it: their heights over the truth differ by it alone."""
    for amplitude in (0.5, 3.0):
        clean, bowed = (bowed_cloud(np.random.default_rng(4), kind, deviation, a) for a in (0.0, amplitude))
        away = (cloud.primitive.signed_distance(cloud.points) for cloud in (bowed, clean))
        apart = np.subtract(*away) / bowed.noise
        assert np.sqrt(np.mean(apart**2)) == pytest.approx(amplitude, rel=1e-3)
        assert clean.primitive.kind == kind and clean.noise == bowed.noise
        white = clean.primitive.signed_distance(clean.points) / clean.noise
        assert np.std(white) == pytest.approx(1.0, abs=4 / np.sqrt(2 * len(white)))


@pytest.mark.parametrize(("kind", "deviation"), PARTS)
def test_least_squares_takes_none_of_it(kind, deviation):
    truth, points, field = deviating(np.random.default_rng(2), kind, deviation, 2000)
    assert np.sqrt(np.mean(field**2)) == pytest.approx(1.0)
    np.testing.assert_allclose(beyond(truth, points, field), field, atol=1e-9)
    bowed = points + 1e-4 * field[:, None] * truth.gradient(points)
    left = refine(truth, bowed).primitive.signed_distance(bowed)
    assert np.sqrt(np.mean(left**2)) == pytest.approx(1e-4, rel=1e-3)


def test_signs_are_drawn():
    signs = []
    for seed in range(20):
        _, points, field = deviating(np.random.default_rng(seed), "plane", "bow", 300)
        signs.append(np.sign(field[np.argmin(np.linalg.norm(points, axis=1))]))
    assert set(signs) == {-1.0, 1.0}


def test_the_set_is_balanced_and_shows_each_part_at_every_amplitude():
    chosen = CASE_SETS["bows"]
    assert chosen.small % (len(AMPLITUDES) * len(KINDS) * 6) == 0 == chosen.full % chosen.small
    cases = [chosen.draw(1, index) for index in range(chosen.small)]
    counts = Counter((case.kind, case.groups["amplitude [noise]"]) for case in cases)
    assert set(counts.values()) == {chosen.small // 20}
    kinds = Counter((case.kind, case.groups["deviation"]) for case in cases)
    assert all(kinds[kind, d] * len(DEVIATIONS_OF[kind]) == chosen.small // 5 for kind, d in PARTS)
    for first in range(0, 40, 20):
        parts = [cases[first + 5 * level] for level in range(len(AMPLITUDES))]
        assert len({len(case.points) for case in parts}) == len({case.noise for case in parts}) == 1
        assert [case.groups["amplitude [noise]"] for case in parts] == list(AMPLITUDES)
    sizes = [len(case.points) for case in cases]
    assert POINTS.low <= min(sizes) and max(sizes) <= POINTS.high
    shares = [case.noise / np.linalg.norm(np.ptp(case.points, axis=0)) for case in cases]
    assert 0.5 * NOISE.low < min(shares) and max(shares) < 2 * NOISE.high  # a turn changes the diagonal
