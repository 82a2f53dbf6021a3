"""The rough fits find the known surfaces, under noise on a share of the points too."""

import numpy as np
import pytest

from primfit.fitting.guesses.oriented import revolution_axis
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.models._features import compared
from primfit.models.rough import rough_features, rough_fits

AXIS = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
CENTER = np.array([0.1, 0.2, -0.1])


def surfaces():
    rng = np.random.default_rng(0)
    u, v = rng.uniform(0, 4.0, 400), rng.uniform(0.2, 1.0, 400)
    return {
        "plane": (Plane(AXIS, CENTER), 3 * u, 2 * v),
        "sphere": (Sphere(CENTER, 1.1), u, 3 * v),
        "cylinder": (Cylinder(AXIS, CENTER, 0.7), u, 2 * v - 1),
        "cone": (Cone(CENTER, AXIS, 0.6), u, 1.5 * v),
        "torus": (Torus(CENTER, AXIS, 1.0, 0.4), u, 6 * v),
    }


def example(kind, noisy_share=0.0):
    """Points with rms radius 1 and the normals there, by differences of the distance."""
    primitive, u, v = surfaces()[kind]
    points = primitive.surface(u, v)
    steps = 1e-6 * np.eye(3)
    normals = np.stack(
        [primitive.signed_distance(points + e) - primitive.signed_distance(points - e) for e in steps], axis=1
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    count = int(noisy_share * len(points))
    points[:count] += np.random.default_rng(1).normal(0, 0.05, (count, 3))
    points = points - points.mean(axis=0)
    return points / np.sqrt(np.mean(np.sum(points**2, axis=1))), normals


@pytest.mark.parametrize("noisy_share", [0.0, 0.3])
@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_nearest_to_its_own_points(kind, noisy_share):
    points, normals = example(kind, noisy_share)
    fits, distances = rough_fits(points, normals, revolution_axis(points, normals))
    assert fits.shape == (5, 9) and distances.shape == (5, len(points))
    own = np.median(np.abs(distances[KINDS.index(kind)]))
    assert own < (1e-3 if noisy_share == 0.0 else 0.02)
    simpler = np.median(np.abs(distances[: KINDS.index(kind)]), axis=1)
    assert np.all(simpler > 2 * own)


def test_a_slender_tube_is_bent_into_its_torus():
    torus = Torus(CENTER, AXIS, 2.0, 0.1)
    rng = np.random.default_rng(4)
    points = torus.surface(rng.uniform(0.0, 0.6, 300), rng.uniform(-2.0, 2.0, 300))
    middle = torus.surface(np.array([0.3]), np.array([np.pi]))[0]
    tangent = np.cross(AXIS, middle - CENTER)
    cylinder = Cylinder(tangent, points.mean(axis=0), 0.1).row()
    found = Torus.from_row(Torus.rows_along(cylinder, points, torus.gradient(points))[0])
    assert found.major_radius == pytest.approx(2.0, rel=0.05)
    assert abs(found.axis @ AXIS) == pytest.approx(1.0, abs=1e-3)


def test_a_turn_and_a_shift_of_the_cloud_change_rounding_only():
    points, normals = example("torus", 0.3)
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    before, _ = rough_features(points, normals)
    after, _ = rough_features(points @ turn.T, normals @ turn.T)
    np.testing.assert_allclose(after, before, atol=1e-5)


def test_distances_are_compared_as_by_numpy():
    rng = np.random.default_rng(6)
    distances = rng.normal(scale=[[0.02], [0.1], [3.0]], size=(3, 41))
    distances[1, 5] = np.nan
    squared = np.minimum(np.nan_to_num(distances**2, nan=1.0), 1.0)
    medians = np.sqrt(np.sort(squared, axis=1)[:, 20])
    costs = np.minimum(squared / (1.5 * medians.min()) ** 2, 9.0).sum(axis=1) / 2.0
    expected = medians, np.sqrt(squared).mean(axis=1), costs
    for found, each in zip(compared(distances, 1e-5, 1.5, 9.0), expected, strict=True):
        np.testing.assert_allclose(found, each, rtol=1e-12)
