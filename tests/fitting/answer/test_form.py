"""Form errors that are known: extremes alternate about the feature, and no other zone is narrower."""

import numpy as np
import pytest

from primfit.fitting.answer.form import Form, Reference, form_of
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.zones.exchange import FEW

TURN = 2.0 * np.pi
AXIS, HERE = [0.3, -0.5, 0.8], [10.0, 20.0, 30.0]
LOBES, HEIGHT = 5, 0.02
ROUND: dict[str, tuple[Primitive, tuple[float, float], str]] = {
    "sphere": (Sphere(HERE, 15.0), (0.7, 2.4), "sphericity"),
    "cylinder": (Cylinder(AXIS, HERE, 8.0), (-7.0, 11.0), "cylindricity"),
    "cone": (Cone(HERE, AXIS, 0.4), (8.0, 20.0), "conicity"),
    "torus": (Torus(HERE, AXIS, 20.0, 6.0), (-1.0, 2.0), "toroidal form"),
}


def references(form: Form) -> tuple[Reference, Reference]:
    assert isinstance(form.least_squares, Reference) and isinstance(form.minimum_zone, Reference)
    return form.least_squares, form.minimum_zone


def lobed(primitive: Primitive, v: tuple[float, float], crowded: int) -> Array:
    """Points off by HEIGHT cos(LOBES u), all extremes among them, with so many more on one side."""
    u, along = np.meshgrid(np.arange(20 * LOBES) * TURN / (20 * LOBES), np.linspace(*v, 9))
    more = np.random.default_rng(0).uniform([0.0, v[0]], [0.4, v[1]], (crowded, 2)).T
    u, along = np.append(u, more[0]), np.append(along, more[1])
    feet = primitive.surface(u, along)
    return feet + HEIGHT * np.cos(LOBES * u)[:, None] * primitive.gradient(feet)


@pytest.mark.parametrize("kind", ROUND)
def test_lobes_are_as_wide_as_they_are(kind: str) -> None:
    primitive, v, name = ROUND[kind]
    form = form_of(primitive, lobed(primitive, v, crowded=0))
    assert form.name == name
    for found in references(form):
        assert found.form_error == pytest.approx(2.0 * HEIGHT, rel=1e-4)
        assert found.peak == pytest.approx(HEIGHT, rel=1e-3) and found.valley == pytest.approx(
            -HEIGHT, rel=1e-3
        )
        assert found.rms == pytest.approx(HEIGHT / np.sqrt(2.0), rel=1e-3)


@pytest.mark.parametrize("kind", ROUND)
def test_many_points_on_one_side_pull_least_squares_only(kind: str) -> None:
    primitive, v, _ = ROUND[kind]
    crowded = 10 * FEW
    least_squares, zone = references(form_of(primitive, lobed(primitive, v, crowded)))
    assert zone.form_error == pytest.approx(2.0 * HEIGHT, rel=1e-4)
    assert least_squares.form_error > 1.02 * zone.form_error
    assert least_squares.rms < zone.rms
    assert np.ptp(zone.primitive.signed_distance(lobed(primitive, v, crowded))) == pytest.approx(
        zone.form_error
    )


def test_the_flatness_of_a_peak_above_a_triangle_is_its_height() -> None:
    corners = np.array([[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]])
    inside = np.random.default_rng(1).dirichlet([1.0, 1.0, 1.0], 500) @ corners
    heights = np.random.default_rng(2).uniform(0.0, 0.3, 500)
    flat = [*np.column_stack([inside, heights]), *np.column_stack([corners, np.zeros(3)]), [1.0, 1.0, 0.3]]
    for sign in (1.0, -1.0):
        normal = np.array([0.0, 0.0, sign])
        form = form_of(Plane(normal, np.zeros(3)), np.array(flat))
        least_squares, zone = references(form)
        assert form.name == "flatness"
        assert zone.form_error == pytest.approx(0.3, rel=1e-9) and zone.peak == pytest.approx(0.15, rel=1e-9)
        assert least_squares.form_error > zone.form_error
        assert isinstance(least_squares.primitive, Plane) and least_squares.primitive.normal @ normal > 0.9


def test_many_points_and_far_ones_give_the_same() -> None:
    primitive, v, _ = ROUND["cylinder"]
    points = lobed(primitive, v, crowded=60_000)
    away = np.array([5e5, 0.0, 0.0])
    _, here = references(form_of(primitive, points))
    _, far = references(form_of(primitive.transformed(np.eye(3), away, 1.0), points + away))
    assert here.form_error == pytest.approx(2.0 * HEIGHT, rel=1e-4)
    assert far.form_error == pytest.approx(here.form_error, rel=1e-6)


def test_what_cannot_be_had_says_why() -> None:
    line = form_of(Plane([0.0, 0.0, 1.0], [0.0, 0.0, 0.0]), np.outer(np.arange(9.0), [1.0, 0.0, 0.0]))
    assert not line.least_squares and "collinear" in line.least_squares.reason
    few = form_of(Torus([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 3.0, 1.0), np.eye(3))
    assert not few.minimum_zone and "3 points do not determine a torus" in few.minimum_zone.reason
