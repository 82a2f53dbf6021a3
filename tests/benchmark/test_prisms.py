"""Bars whose section is no circle, and pipes among them."""

from collections import Counter

import numpy as np
import pytest

from primfit.benchmark.cases import CASE_SETS, DEVIATIONS_SEEN, PIPE, bucket
from primfit.benchmark.prisms import NOISE, POINTS, section_cloud
from primfit.synthetic.sections import SECTIONS, deviation, section


def test_every_fourth_cloud_is_a_pipe_and_sorts_take_turns():
    chosen = CASE_SETS["sections"]
    assert chosen.small == 80 and chosen.full % chosen.small == 0
    cases = [chosen.draw(1, index) for index in range(chosen.small)]
    counts = Counter(case.groups["section"] for case in cases)
    assert counts == {PIPE: 20, **dict.fromkeys(SECTIONS, 3)}
    for index, case in enumerate(cases):
        assert (case.groups["deviation"] == PIPE) == (case.kind == "cylinder") == (index % 4 == 3)
        assert case.kind in ("cylinder", "foreign") and POINTS.low <= len(case.points) <= POINTS.high
        assert case.noise == 0.0 or NOISE.low <= case.noise <= NOISE.high
        if case.truth:
            assert case.truth.radius == 0.5
            away = case.truth.signed_distance(case.points)
            assert np.std(away) == pytest.approx(case.noise, rel=0.2, abs=1e-12)


def test_the_deviation_is_in_noise_scales():
    """That of a square is 4.5% of its diagonal; without noise it is beyond all bounds."""
    for seed in range(40):
        rng = np.random.default_rng(seed)
        drawn, found = section_cloud(rng, "4 faces")
        expected = deviation(section(np.random.default_rng(0), "4 faces"))
        assert found == (pytest.approx(expected / drawn.noise) if drawn.noise else np.inf)
        assert bucket(DEVIATIONS_SEEN, found) == (
            "over 3" if found > 3 else "1 to 3" if found > 1 else "under 1"
        )
