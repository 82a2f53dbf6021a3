"""What is found of a cloud of the example sphere, whose radius is 1.3."""

import numpy as np

from primfit.fitting.answer.result import Recognition
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config


def sphere(points: np.ndarray) -> Recognition:
    answer = recognize(points, Config(kinds=("sphere",)))
    assert answer.primitive is not None and answer.noise is not None
    return answer


def radius_error(points: np.ndarray) -> float:
    return abs(float(sphere(points).primitive.radius) - 1.3)  # type: ignore[union-attr]
