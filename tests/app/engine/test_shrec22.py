"""The text format of the SHREC 2022 track."""

import numpy as np
import pytest

from primfit.app.engine.shrec22 import prediction
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

Z = np.array([0.0, 0.0, 1.0])
P = np.array([0.1, 1e-17, -1 / 3])


@pytest.mark.parametrize(
    ("primitive", "expected"),
    [
        (Plane(Z, P), [1, *Z, *P]),
        (Cylinder(Z, P, 2.5), [2, 2.5, *Z, *P]),
        (Sphere(P, 2.5), [3, 2.5, *P]),
        (Cone(P, Z, 0.6), [4, 0.6, *Z, *P]),
        (Torus(P, Z, 3.0, 1.5), [5, 3.0, 1.5, *Z, *P]),
    ],
)
def test_label_first_then_parameters_in_full_precision(primitive: Primitive, expected: list[float]) -> None:
    text = prediction(parameters(primitive))
    assert text.endswith("\n")
    assert [float(line) for line in text.splitlines()] == expected
    assert text.splitlines()[0] == str(expected[0])
