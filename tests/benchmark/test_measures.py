"""The measures against cases worked out by hand."""

import numpy as np
import pytest

from benchmark.measures import l2
from fitting.primitives import Cone, Cylinder, Plane, Primitive, Sphere, Torus
from fitting.primitives.shrec22 import from_vector, to_vector

ORIGIN = np.zeros(3)
X, Z = np.eye(3)[0], np.eye(3)[2]


@pytest.mark.parametrize(
    ("found", "truth", "expected"),
    [
        (Plane(Z, ORIGIN), Plane(-Z, 5 * X), 0.0),
        (Plane(X, ORIGIN), Plane(Z, ORIGIN), np.sqrt(2.0)),
        (Cylinder(-Z, 9 * X, 3.0), Cylinder(Z, ORIGIN, 1.0), 2.0),
        (Sphere([3, 4, 0], 1.0), Sphere(ORIGIN, 1.0), 5.0),
        (Sphere([3, 4, 0], 13.0), Sphere(ORIGIN, 1.0), 13.0),
        (Cone([0, 0, 2], Z, 0.5), Cone(ORIGIN, -Z, 0.5), 2.0),
        (Torus(ORIGIN, -Z, 1.0, 3.0), Torus(ORIGIN, Z, 3.0, 1.0), 0.0),
        (Torus(X, Z, 3.0, 1.0), Torus(ORIGIN, Z, 2.0, 1.0), np.sqrt(2.0)),
    ],
)
def test_l2_by_hand(found: Primitive, truth: Primitive, expected: float) -> None:
    assert l2(found, truth) == pytest.approx(expected, abs=1e-15)


def test_vectors_of_the_track_read_back() -> None:
    label, numbers = to_vector(Torus([1, 2, 3], [0, 0.6, 0.8], 2.5, 0.5))
    assert label == 5
    assert numbers == pytest.approx([2.5, 0.5, 0.0, 0.6, 0.8, 1.0, 2.0, 3.0])
    assert to_vector(from_vector(label, numbers))[1] == pytest.approx(numbers)


@pytest.mark.parametrize(("label", "numbers"), [(9, [1.0]), (3, [1.0, 2.0, 3.0])])
def test_vectors_that_are_none_are_refused(label: int, numbers: list[float]) -> None:
    with pytest.raises(ValueError, match=r"label is 9|4 parameters, not 3"):
        from_vector(label, numbers)
