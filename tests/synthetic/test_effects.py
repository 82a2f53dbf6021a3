"""Each effect does what its name says, and its covariance is the one that its draws have."""

from dataclasses import replace

import numpy as np
import pytest

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.synthetic.effects import (
    Correlated,
    DepthSteps,
    FormDeviation,
    LineOffsets,
    LineWaves,
    RadialBow,
    Ripple,
    Seen,
    StationShift,
    White,
)
from primfit.synthetic.fields import Rough
from primfit.synthetic.patches import Patch

Z = np.array([0.0, 0.0, 1.0])
WALL = Patch(Plane(Z, np.zeros(3)), (-0.5, 0.5), (-0.5, 0.5))


def wall(count=40, height=2.0, stations=1):
    """A wall of 1 m seen on a grid from `height` above its middle; every other line by the second station."""
    x, y = (a.ravel() for a in np.meshgrid(*2 * [np.linspace(-0.5, 0.5, count)], indexing="ij"))
    points = np.column_stack([x, y, np.zeros(count**2)])
    rays = points - [0.0, 0.0, height]
    distance = np.linalg.norm(rays, axis=1)
    rays /= distance[:, None]
    line = np.repeat(np.arange(count), count)
    return Seen(
        points,
        np.tile(Z, (count**2, 1)),
        rays,
        distance,
        -rays[:, 2],
        -rays[:, 2],
        points[:, :2] / height,
        line,
        y,
        line % stations,
        np.maximum(np.abs(x), np.abs(y)) > 0.49,
        np.ones(count**2),
    )


SEEN = wall(8, stations=2)
EFFECTS = (
    White(0.01),
    Correlated(0.01, Rough(0.3)),
    LineOffsets(0.01),
    LineWaves(0.01, 0.3),
    Ripple(0.01, 0.2),
    RadialBow(0.01),
    FormDeviation(0.01, WALL, 0, 0.3),
    StationShift(0.01),
)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.name)
def test_the_covariance_is_that_of_the_draws(effect):
    rng, count = np.random.default_rng(2), 600
    drawn = np.array([effect.applied(rng, SEEN, SEEN.points)[:, 2] for _ in range(count)])
    expected = effect.covariance(SEEN)
    scatter = np.sqrt(2.0 / count) * expected.diagonal().max()
    assert drawn.T @ drawn / count == pytest.approx(expected, abs=6 * scatter)
    assert np.linalg.eigvalsh(expected).min() > -1e-12


@pytest.mark.parametrize("effect", EFFECTS[:-1], ids=lambda effect: effect.name)
def test_points_move_by_the_size_of_the_effect(effect):
    seen = wall(stations=2)
    moved = [effect.applied(np.random.default_rng(i), seen, seen.points) - seen.points for i in range(20)]
    assert np.sqrt(np.mean(np.sum(np.square(moved), axis=2))) == pytest.approx(0.01, rel=0.25)


@pytest.mark.parametrize("effect", EFFECTS[:6], ids=lambda effect: effect.name)
def test_a_sensor_errs_along_its_rays(effect):
    moved = effect.applied(np.random.default_rng(0), SEEN, SEEN.points) - SEEN.points
    assert np.abs(np.cross(moved, SEEN.rays)).max() < 1e-12


def test_lines_are_off_as_a_whole_and_independently():
    seen = wall()
    error = LineOffsets(0.01).applied(np.random.default_rng(1), seen, seen.points) - seen.points
    along = np.einsum("ij,ij->i", error, seen.rays).reshape(40, 40)
    assert np.ptp(along, axis=1).max() < 1e-12
    assert np.std(along[:, 0]) == pytest.approx(0.01, rel=0.4)
    assert abs(np.corrcoef(along[1:, 0], along[:-1, 0])[0, 1]) < 0.5


def test_waves_go_along_a_line_and_not_across():
    seen = wall()
    error = LineWaves(0.01, 0.2).applied(np.random.default_rng(1), seen, seen.points) - seen.points
    along = np.einsum("ij,ij->i", error, seen.rays).reshape(40, 40)
    assert np.corrcoef(along[:, 1:].ravel(), along[:, :-1].ravel())[0, 1] > 0.95
    assert abs(np.corrcoef(along[1:].ravel(), along[:-1].ravel())[0, 1]) < 0.3


def test_a_radial_bow_grows_with_the_square_of_the_distance_from_the_middle():
    seen = wall()
    error = RadialBow(0.01).applied(np.random.default_rng(1), seen, seen.points) - seen.points
    along = np.einsum("ij,ij->i", error, seen.rays)
    fitted = np.polyfit(np.sum(seen.points**2, axis=1), along, 1)
    assert np.polyval(fitted, np.sum(seen.points**2, axis=1)) == pytest.approx(along)
    assert np.sqrt(np.mean(along**2)) == pytest.approx(0.01)


@pytest.mark.parametrize("far", [1.0, 2.0, 4.0])
def test_depth_steps_grow_with_the_square_of_the_range(far):
    """Neighbouring depths differ by coefficient z^2."""
    seen, coefficient = wall(200, far), 2.85e-3
    tilted = seen.points + (0.2 * seen.points[:, 0])[:, None] * seen.rays
    effect = DepthSteps(coefficient * far**2 / np.sqrt(12.0), coefficient)
    stepped = effect.applied(np.random.default_rng(0), seen, tilted)
    depths = np.unique(np.round(far - stepped[:, 2], 9))
    middle = np.abs(depths - far) < 0.05
    assert np.diff(depths[middle]) == pytest.approx(coefficient * far**2, rel=0.12)
    error = (stepped - tilted)[:, 2]
    assert np.abs(error).max() < 0.75 * coefficient * (far + 0.1) ** 2
    assert np.std(error) == pytest.approx(effect.size, rel=0.15)


def test_stations_are_shifted_as_a_whole_and_the_first_not_at_all():
    seen = wall(stations=2)
    moved = StationShift(0.01).applied(np.random.default_rng(3), seen, seen.points) - seen.points
    assert np.abs(moved[seen.station == 0]).max() == 0.0
    second = moved[seen.station == 1]
    assert np.ptp(second, axis=0) == pytest.approx(0.0, abs=1e-12)
    assert 0.003 < np.linalg.norm(second[0]) < 0.04


@pytest.mark.parametrize(
    ("primitive", "u", "v", "waves", "turns"),
    [
        (Cylinder(Z, np.zeros(3), 0.5), (-np.pi, np.pi), (-1.0, 1.0), 3, 3),
        (Cone(np.zeros(3), Z, 0.3), (-np.pi, np.pi), (0.5, 1.5), 2, 2),
    ],
)
def test_lobes_go_around_as_often_as_they_say(primitive, u, v, waves, turns):
    patch = Patch(primitive, u, v)
    azimuth = np.linspace(-np.pi, np.pi, 400, endpoint=False)
    seen = on(patch, azimuth, np.full(400, 1.0))
    error = primitive.signed_distance(
        FormDeviation(0.001, patch, waves, 0.2).applied(np.random.default_rng(0), seen, seen.points)
    )
    spectrum = np.abs(np.fft.rfft(error))
    assert spectrum.argmax() == turns
    assert np.sqrt(np.mean(error**2)) == pytest.approx(0.001, rel=1e-2)


def test_a_barrel_bulges_in_the_middle_of_its_height():
    patch = Patch(Cylinder(Z, np.zeros(3), 0.5), (-np.pi, np.pi), (-1.0, 1.0))
    height = np.linspace(-1.0, 1.0, 301)
    seen = on(patch, np.zeros(301), height)
    moved = FormDeviation(0.001, patch, 0, 0.0).applied(np.random.default_rng(0), seen, seen.points)
    error = patch.primitive.signed_distance(moved)
    assert abs(error[150] - error[0]) == pytest.approx(abs(error[150] - error[-1]))
    # Of a parabola the root mean square is 2 / sqrt(45) of its height.
    assert abs(error[150] - error[0]) == pytest.approx(0.001 * np.sqrt(45) / 2, rel=0.02)


@pytest.mark.parametrize("primitive", [Sphere(np.zeros(3), 1.0), Torus(np.zeros(3), Z, 2.0, 0.5)])
def test_balls_and_tubes_become_oval(primitive):
    patch = Patch(primitive, (-np.pi, np.pi), (0.1, 3.0))
    rng = np.random.default_rng(0)
    seen = on(patch, rng.uniform(-np.pi, np.pi, 500), rng.uniform(0.1, 3.0, 500))
    moved = FormDeviation(0.001, patch, 0, 0.5).applied(rng, seen, seen.points)
    error = primitive.signed_distance(moved)
    assert np.sqrt(np.mean(error**2)) == pytest.approx(0.001, rel=1e-3)
    assert error.min() < -5e-4 and error.max() > 5e-4


def on(patch, u, v):
    """Points at these parameters, seen along their normals."""
    points = patch.primitive.surface(u, v)
    count = len(points)
    seen = wall(2).part(np.zeros(count, dtype=int))
    normals = patch.primitive.gradient(points)
    return replace(seen, points=points, normals=normals, rays=-normals)
