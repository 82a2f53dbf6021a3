"""The figures of an answer are those of its points."""

import numpy as np
import pytest

from primfit.fitting.answer._figures import figures
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.clouds import EXAMPLES, noisy


def test_errors_are_those_of_the_points() -> None:
    points = noisy(EXAMPLES["sphere"], 700, 0.01)
    answer = recognize(points, Config(kinds=("sphere",)))
    assert answer.primitive is not None and answer.error is not None
    distance = np.abs(answer.primitive.signed_distance(points))
    assert answer.error.rms == pytest.approx(np.sqrt(np.mean(distance**2)))
    assert answer.error.mean == pytest.approx(distance.mean())
    assert answer.error.p95 == pytest.approx(np.percentile(distance, 95))
    assert answer.error.max == pytest.approx(distance.max())
    assert answer.error.relative_mean == pytest.approx(
        distance.mean() / np.linalg.norm(np.ptp(points, axis=0))
    )


@pytest.mark.parametrize("n", [1, 2, 3, 19, 20, 21, 1000])
@pytest.mark.parametrize("reach", [0.0, 1.0, np.inf])
def test_figures_are_those_of_numpy(n: int, reach: float) -> None:
    """Of distances with ties; of all points where none belongs to the surface."""
    rng = np.random.default_rng(n)
    signed, judged = np.round(rng.normal(size=n), 2), 0.01 + np.abs(rng.normal(size=n))
    distance, belongs = np.abs(signed), judged <= reach
    near = distance[belongs] if belongs.any() else distance
    expected = (
        np.sqrt(np.mean(distance**2)),
        distance.mean(),
        np.percentile(distance, 95.0),
        distance.max(),
        np.ptp(signed),
        np.sqrt(np.mean(near**2)),
        np.ptp(signed[belongs] if belongs.any() else signed),
        belongs.mean(),
    )
    np.testing.assert_allclose(figures(signed, judged, reach, 0.95), expected, rtol=1e-13)


def test_repeated_points_count_as_often_as_they_are_given() -> None:
    points = noisy(EXAMPLES["sphere"], 300, 0.01)
    answer = recognize(np.vstack([points, points[:100]]), Config(kinds=("sphere",)))
    assert answer.primitive is not None and answer.error is not None
    distance = answer.primitive.signed_distance(np.vstack([points, points[:100]]))
    assert answer.error.rms == pytest.approx(np.sqrt(np.mean(distance**2)))
