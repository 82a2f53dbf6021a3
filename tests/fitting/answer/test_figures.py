"""The figures of an answer are those of its points."""

import numpy as np
import pytest

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
