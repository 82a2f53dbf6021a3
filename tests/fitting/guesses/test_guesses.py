"""Starts of each kind: those of NumPy, and the surface itself where the points lie on it."""

from collections import Counter

import numpy as np
import pytest

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.guesses import _guesses
from primfit.fitting.guesses.oriented import Oriented, random_subsets
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import LEAST_CURVATURE, SMALLEST_MAJOR, Torus
from tests.fitting.clouds import EXAMPLES, sample
from tests.fitting.guesses import reference_guesses as reference

ROUNDS = 4


def example(kind: str, noise: float = 0.02, n: int = 150) -> tuple[Array, Array]:
    """Points near a surface, a tenth of them far off, and normals of either sign."""
    rng = np.random.default_rng(5)
    points = sample(EXAMPLES[kind], n)
    normals = EXAMPLES[kind].gradient(points) * rng.choice([-1.0, 1.0], n)[:, None]
    points = points + noise * rng.normal(size=(n, 3))
    points[:: max(n // 15, 1)] += 20.0 * noise * rng.normal(size=points[:: max(n // 15, 1)].shape)
    return points, normals


def directions(n: int = 6) -> Array:
    found = np.random.default_rng(8).normal(size=(n, 3))
    return np.asarray(found / np.linalg.norm(found, axis=1)[:, None])


@pytest.mark.parametrize("kind", ["cylinder", "cone", "torus", "sphere"])
def test_starts_about_axes_are_those_of_numpy(kind: str) -> None:
    points, normals = example(kind)
    axes, line = directions(), Oriented(points, normals).line
    for axis, found in zip(axes, Cylinder.rows_about(axes, points), strict=True):
        np.testing.assert_allclose(found, reference.cylinder(axis, points, ROUNDS), rtol=1e-7, atol=1e-7)
    for axis, found in zip(axes, Cone.rows_about(axes, points), strict=True):
        np.testing.assert_allclose(found, reference.cone(axis, points, ROUNDS), rtol=1e-6, atol=1e-6)
    tori = Torus.rows_about(axes, points, normals, line)
    assert len(tori) == 2 * len(axes) + 1
    met = [reference.met(axis, points, normals, ROUNDS) for axis in axes]
    seen = [reference.cylinder(axis, points, ROUNDS)[3:6] for axis in axes]
    lines = zip([*axes, *axes, line.direction], [*met, *seen, line.point], tori, strict=True)
    for axis, foot, found in lines:
        expected = reference.torus(axis, foot, points, ROUNDS, SMALLEST_MAJOR)
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


def test_spheres_bent_cylinders_and_tubes_are_those_of_numpy() -> None:
    points, normals = example("torus")
    groups = np.stack([points[:40], points[40:80]])
    for group, found in zip(groups, Sphere.rows_through(groups), strict=True):
        np.testing.assert_allclose(found, reference.sphere(group, ROUNDS), rtol=1e-7, atol=1e-7)
    cylinders = Cylinder.rows_about(directions(), points)
    for cylinder, found in zip(cylinders, Torus.rows_bent(cylinders, points), strict=True):
        expected = reference.bent(cylinder, points, ROUNDS, LEAST_CURVATURE)
        np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-5)
    for cylinder in cylinders:
        (found,) = Torus.rows_along(cylinder, points, normals)
        expected = reference.tube(cylinder, points, normals, ROUNDS)
        found[:3] *= np.sign(found[:3] @ expected[:3])
        np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("kind", ["cylinder", "cone", "torus", "sphere"])
def test_points_on_a_surface_lead_to_it(kind: str) -> None:
    primitive, points = EXAMPLES[kind], sample(EXAMPLES[kind], 100)
    oriented = Oriented(points, primitive.gradient(points))
    starts = type(primitive).initial_guesses(oriented, np.random.default_rng(0))
    axis = getattr(primitive, "axis", np.array([0.0, 0.0, 1.0]))[None]
    about: dict[str, Array] = {
        "cylinder": Cylinder.rows_about(axis, points),
        "cone": Cone.rows_about(axis, points),
        "torus": Torus.rows_about(axis, points, oriented.normals, oriented.line),
        "sphere": starts[:1],
    }
    surfaces: list[Primitive] = [type(primitive).from_row(row) for row in about[kind]]
    assert min(np.abs(each.signed_distance(points)).max() for each in surfaces) < 1e-6


def test_a_cylinder_without_a_bend_bends_into_a_wide_torus() -> None:
    points = sample(EXAMPLES["cylinder"], 100)
    torus = Torus.from_row(Torus.rows_bent(EXAMPLES["cylinder"].row()[None], points)[0])
    assert torus.major_radius == pytest.approx(1.0 / LEAST_CURVATURE, rel=1e-6)


def test_one_group_of_four_points_has_its_sphere() -> None:
    points = sample(EXAMPLES["sphere"], 4)
    sphere = Sphere.from_row(Sphere.rows_through(points[None], rounds=1)[0])
    np.testing.assert_allclose(sphere.signed_distance(points), 0.0, atol=1e-9)


def test_random_subsets_are_distinct_and_all_as_likely() -> None:
    drawn = random_subsets(5, 3, 30_000, np.random.default_rng(0))
    assert all(len(set(row)) == 3 for row in drawn.tolist())
    counts = Counter(map(tuple, np.sort(drawn, axis=1).tolist()))
    assert len(counts) == 10 and min(counts.values()) > 2_700 and max(counts.values()) < 3_300


def test_the_last_number_is_drawn_and_none_beyond() -> None:
    shares = np.array([[0.0, 0.0, 0.0], [np.nextafter(1.0, 0.0)] * 3, [0.0, np.nextafter(1.0, 0.0), 0.5]])
    assert _guesses.subsets(shares, 3).tolist() == [[0, 1, 2]] * 3
