"""The measures against cases worked out by hand."""

import numpy as np
import pytest

from primfit.benchmark.measures import (
    GRID,
    MOST_SAMPLED,
    distances,
    fitting_errors,
    is_right,
    l2,
    position_error,
    reference_errors,
    sampled_errors,
    surface_error,
    truth_errors,
)
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.shrec22 import from_vector, sampled_distances, to_vector

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


SQUARE = np.array([[0, 0, 1], [4, 0, 1], [4, 3, 1], [0, 3, 3]], float)
"""Bounding box 4 x 3 x 2, diagonal sqrt(29)."""


def test_fitting_errors_by_hand():
    errors = fitting_errors(Plane(Z, ORIGIN), SQUARE)
    assert errors["mfe"] == pytest.approx((1 + 1 + 1 + 3) / 4 / np.sqrt(29))
    assert errors["hausdorff"] == pytest.approx(3.0)


def test_errors_of_a_cone_count_the_way_to_its_apex():
    below = np.array([[0.0, 0.0, -2.0], [0.0, 0.0, -1.0]])
    assert fitting_errors(Cone(ORIGIN, Z, 0.5), below)["hausdorff"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    "primitive",
    [
        Plane([0.6, 0, 0.8], [1, 2, 3]),
        Sphere([1, 2, 3], 2.0),
        Cylinder([0.6, 0, 0.8], [1, 2, 3], 1.0),
        Cone([1, 2, 3], [0.6, 0, 0.8], 0.5),
        Torus([1, 2, 3], [0.6, 0, 0.8], 2.0, 0.5),
    ],
    ids=lambda primitive: primitive.kind,
)
def test_the_sampled_surface_is_the_surface_but_for_gaps(primitive):
    """Points of the surface are near a sample, and no point is nearer to a sample than to the surface."""
    rng = np.random.default_rng(0)
    on_surface = primitive.surface(rng.uniform(0, 2, 500), rng.uniform(0, 2, 500))
    assert sampled_distances(primitive, on_surface, GRID).max() < 0.1
    away = on_surface + 0.3 * primitive.gradient(on_surface)
    excess = sampled_distances(primitive, away, GRID) - distances(primitive, away)
    assert excess.min() > -1e-12 and excess.max() < 0.05


def test_samples_beyond_all_bounds_are_infinitely_far():
    with np.errstate(all="ignore"):
        assert np.isinf(sampled_distances(Torus(ORIGIN, Z, 1e308, 1e308), SQUARE, GRID)).all()


def test_sampled_errors_of_large_clouds_look_at_a_part():
    points = np.random.default_rng(0).standard_normal((MOST_SAMPLED + 1, 3))
    whole, part = (sampled_errors(Sphere(ORIGIN, 1.0), cloud) for cloud in (points, points[::2]))
    assert whole["hausdorff_sampled"] == part["hausdorff_sampled"]


@pytest.mark.parametrize(
    ("found", "truth", "center", "expected"),
    [
        # Offsets 2 and 5 from the origin, whichever way the normals point and wherever the points lie.
        (Plane(Z, [7, 8, 2]), Plane(Z, [0, 0, 5]), ORIGIN, 3.0),
        (Plane(-Z, [7, 8, 2]), Plane(Z, [0, 0, 5]), ORIGIN, 3.0),
        # x + z = 0 lies 3 / sqrt(2) from (3, 0, 0), the plane z = 1 lies -1 from it.
        (Plane([1, 0, 1], ORIGIN), Plane(Z, Z), 3 * X, 3 / np.sqrt(2) + 1),
        # Parallel axes 5 apart, given by points far along them.
        (Cylinder(Z, [3, 4, 99], 1.0), Cylinder(-Z, [0, 0, -50], 2.0), ORIGIN, 5.0),
        # The axes y and z meet at the origin; the true one is at height 2 where it is closest to the cloud.
        (Cylinder([0, 1, 0], ORIGIN, 1.0), Cylinder(Z, ORIGIN, 1.0), [0, 9, 2], 2.0),
    ],
)
def test_position_errors_by_hand(found, truth, center, expected):
    assert position_error(found, truth, np.array(center, float)) == pytest.approx(expected)


def test_other_kinds_have_no_position_error():
    assert position_error(Sphere(X, 1.0), Sphere(ORIGIN, 1.0), ORIGIN) is None
    assert position_error(Plane(Z, ORIGIN), Cylinder(Z, ORIGIN, 1.0), ORIGIN) is None


def test_surface_error_by_hand():
    """Points off the true plane are carried to it: heights 1, 1, 1, 3 above z = 0 do not matter."""
    assert surface_error(Plane(Z, [0, 0, 2]), Plane(Z, ORIGIN), SQUARE) == pytest.approx(2.0)
    # A sphere of radius 5 about (0, 0, 3) is 0 and 2 away from the points (4, 0, 0) and (0, 0, 0) of z = 0.
    points = np.array([[4.0, 0.0, 7.0], [0.0, 0.0, -1.0]])
    found = surface_error(Sphere([0, 0, 3], 5.0), Plane(Z, ORIGIN), points)
    assert found == pytest.approx(np.sqrt((0**2 + 2**2) / 2))


def test_errors_against_the_truth_are_shares_of_the_extent():
    points = np.array([[0.0, 0.0, 0.0], [6.0, 8.0, 0.0]])  # extent 10
    errors = truth_errors(Cylinder(Z, [0, 5, 0], 3.0), Cylinder(Z, ORIGIN, 1.0), points)
    assert errors["l2"] == pytest.approx(2.0) and errors["relative_l2"] == pytest.approx(0.2)
    assert errors["position"] == pytest.approx(5.0) and errors["relative_position"] == pytest.approx(0.5)
    # Angles are no lengths: a cone that is 0.1 rad too wide is so at any extent.
    cone = truth_errors(Cone(ORIGIN, Z, 0.6), Cone(ORIGIN, Z, 0.5), points)
    assert cone["relative_l2"] == pytest.approx(cone["l2"]) == pytest.approx(0.1)


def test_another_kind_has_a_surface_error_only():
    assert set(truth_errors(Plane(Z, ORIGIN), Sphere(ORIGIN, 1.0), SQUARE)) == {"surface"}


def test_radius_errors_are_signed_shares_of_the_radius():
    for found, truth in (
        (Sphere(X, 2.2), Sphere(ORIGIN, 2.0)),
        (Cylinder(Z, X, 2.2), Cylinder(Z, ORIGIN, 2.0)),
    ):
        assert truth_errors(found, truth, SQUARE)["radius"] == pytest.approx(0.1)
        assert truth_errors(truth, found, SQUARE)["radius"] == pytest.approx(-1 / 11)
    assert "radius" not in truth_errors(Cylinder(Z, X, 2.2), Sphere(ORIGIN, 2.0), SQUARE)


def test_the_reference_fit_and_what_is_expected_of_it_by_hand():
    """Heights 2 +- 1 over the corners of a rectangle, as on a saddle: the best plane is z = 2.

    The extent is that of 6 x 8 x 2; three parameters and four points under noise of 0.5 let expect a surface
    error of 0.5 sqrt(3 / 4).
    """
    points = np.array([[3, 4, 3], [-3, 4, 1], [3, -4, 1], [-3, -4, 3]], float)
    errors = reference_errors(Plane(Z, ORIGIN), points, 0.5)
    extent = np.sqrt(36 + 64 + 4)
    assert errors["surface"] == pytest.approx(2.0 / extent)
    assert errors["expected"] == pytest.approx(0.5 * np.sqrt(0.75) / extent)
    assert errors["position"] == pytest.approx(2.0) and errors["l2"] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    "truth", [Sphere([5, 0, 1], 2.0), Cylinder([1, 2, 3], [9, 9, 9], 2.0), Torus([1, 1, 0], X, 3.0, 1.0)]
)
def test_reference_fits_err_as_theory_expects(truth):
    """The mean of  surface^2 / expected^2  is 1, with a standard deviation of sqrt(2 / dof / clouds)."""
    rng = np.random.default_rng(0)
    squares = []
    for _ in range(150):
        points = truth.surface(*rng.uniform(0.5, 2.5, (2, 300)))
        points += 0.01 * rng.standard_normal((300, 1)) * truth.gradient(points)
        errors = reference_errors(truth, points, 0.01)
        squares.append((errors["surface"] / errors["expected"]) ** 2)
    assert np.mean(squares) == pytest.approx(1.0, abs=4 * np.sqrt(2 / truth.dof / 150))


@pytest.mark.parametrize(
    ("status", "found", "kind", "right"),
    [
        ("fitted", Plane(X, ORIGIN), "plane", True),
        ("fitted", Sphere(ORIGIN, 1.0), "plane", False),
        ("ambiguous", Plane(Z, ORIGIN), "plane", False),
        ("no_fit", Plane(Z, ORIGIN), "plane", False),
        ("error", None, "plane", False),
        ("no_fit", Plane(Z, ORIGIN), "foreign", True),
        ("ambiguous", Plane(Z, ORIGIN), "foreign", False),
        ("fitted", Plane(Z, ORIGIN), "foreign", False),
        ("crash", None, "foreign", False),
    ],
)
def test_what_is_right(status, found, kind, right):
    assert is_right(status, found, kind) is right
