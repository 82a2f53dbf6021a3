"""Steps that bend surfaces: those of `stepped` to first order, and through the plane to the other side."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from primfit.fitting.geometry.turning import turned
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.solver.refine import bent, stepped
from tests.fitting.clouds import EXAMPLES, sample

CURVED = {name: primitive for name, primitive in EXAMPLES.items() if name != "plane"}

RADIUS = 4.0
TOUCHING: dict[str, Primitive] = {
    "sphere": Sphere([0.0, 0.0, -RADIUS], RADIUS),
    "cylinder": Cylinder([1.0, 0.0, 0.0], [0.0, 0.0, -RADIUS], RADIUS),
}
"""Surfaces that touch the plane z = 0 in the origin from below."""


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-170, 1e-9, 0.3, np.pi, 5.0, 100.0])
def test_a_frame_is_turned_by_a_rotation_vector(angle: float) -> None:
    rng = np.random.default_rng(0)
    for frame in Rotation.random(20, random_state=1).as_matrix():
        rotation = rng.normal(size=3)
        rotation *= angle / np.linalg.norm(rotation)
        expected = Rotation.from_rotvec(rotation @ frame).apply(frame)
        assert turned(frame, rotation) == pytest.approx(expected, rel=1e-13, abs=2e-15 * max(1.0, angle))


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", CURVED)
def test_steps_are_those_of_stepped_to_first_order(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = sample(CURVED[kind], 50, seed)
    origin = points[0] + rng.normal(0.0, 0.05, 3)
    primitive, points = CURVED[kind].transformed(np.eye(3), -origin, 1.0), points - origin
    step = rng.normal(size=primitive.dof)
    here = primitive.signed_distance(points)
    assert bent(primitive, np.zeros(primitive.dof)).signed_distance(points) == pytest.approx(here, abs=1e-14)
    for size in (1e-3, 1e-5):
        there, linear = (move(primitive, size * step).signed_distance(points) for move in (bent, stepped))
        assert np.abs(there - linear).max() < 100.0 * size**2
        assert np.abs(there - here).max() > size / 10.0


@pytest.mark.parametrize("kind", TOUCHING)
def test_curvature_goes_through_zero_to_the_other_side(kind: str) -> None:
    """A step of one radius takes the curvature to 0, one of two to its negative; the tangent plane stays."""
    primitive, points = TOUCHING[kind], sample(EXAMPLES["plane"], 20) * [1.0, 1.0, 0.0]
    rises = np.array([stepped(primitive, 1e-6 * unit).row()[5] + RADIUS for unit in np.eye(primitive.dof)])
    growing = np.append(-np.round(rises[:-1] / 1e-6), 1.0)
    flat, other = (bent(primitive, factor * RADIUS * growing) for factor in (1.0 - 1e-9, 2.0))
    assert flat.signed_distance(points) == pytest.approx(np.zeros(20), abs=1e-6)
    mirrored = primitive.transformed(np.diag([1.0, 1.0, -1.0]), np.zeros(3), 1.0)
    assert other.signed_distance(points) == pytest.approx(mirrored.signed_distance(points), abs=1e-12)
