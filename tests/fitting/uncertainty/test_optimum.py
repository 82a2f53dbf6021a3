"""What the optimum tells of the noise, where points are many, few, exact or rounded."""

import numpy as np
import pytest

from primfit.fitting.answer.result import Recognition
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.uncertainty import optimum
from tests.fitting.clouds import EXAMPLES, sample
from tests.fitting.uncertainty.known import known

Patch = pytest.MonkeyPatch


def _sphere(points: np.ndarray) -> Recognition:
    answer = recognize(points, Config(kinds=("sphere",)))
    assert answer.primitive is not None and answer.noise is not None
    return answer


def test_the_noise_of_rounding_is_what_intervals_of_rounded_points_come_from(monkeypatch: Patch) -> None:
    """95 of 100 hold the truth; with the step itself in place of its standard deviation all would."""

    def off() -> np.ndarray:
        found = []
        for seed in range(20):
            uncertainty = (answer := _sphere(np.round(sample(EXAMPLES["sphere"], 60, seed), 4))).uncertainty
            assert uncertainty is not None and uncertainty.noise_model == "exact"
            spread = uncertainty.intervals["radius"].standard_deviation
            found.append((answer.primitive.radius - 1.3) / spread)  # type: ignore[union-attr]
        return np.asarray(found)

    assert 0.7 < np.sqrt(np.mean(off() ** 2)) < 1.4
    monkeypatch.setattr(optimum, "ROUNDING_NOISE", 1.0)
    assert np.sqrt(np.mean(off() ** 2)) < 0.5


def test_exact_points_leave_the_rounding() -> None:
    points = np.round(sample(EXAMPLES["sphere"], 500), 4)
    found = known(points, "sphere")
    assert found.noise_model == "exact"
    assert 1e-6 < found.intervals["radius"].standard_deviation < 1e-5
