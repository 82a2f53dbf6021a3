"""Extents of pieces with known cuts, of all five kinds, clean and with noise and outliers."""

import tracemalloc
from typing import Any

import numpy as np
import pytest

from primfit.fitting.extents import EXTENTS, extents_of
from primfit.fitting.extents.plane import PlaneExtents
from primfit.fitting.geometry.vectors import Array, around_axis, basis
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.clouds import rotation

Range = tuple[float, float]
TURN = 2.0 * np.pi
AXIS = np.array([0.2, -0.5, 0.8]) / np.linalg.norm([0.2, -0.5, 0.8])
PLANE = Plane(AXIS, [1.0, 2.0, 3.0])
SPHERE = Sphere([1.0, 2.0, 3.0], 1.5)
CYLINDER = Cylinder(AXIS, [1.0, 2.0, 3.0], 0.8)
CONE = Cone([1.0, 2.0, 3.0], AXIS, 0.4)
TORUS = Torus([1.0, 2.0, 3.0], AXIS, 2.0, 0.6)

OF_KIND: dict[str, Primitive] = {p.kind: p for p in (PLANE, SPHERE, CYLINDER, CONE, TORUS)}


def piece(primitive: Primitive, u: Range, v: Range, n: int, seed: int = 1) -> Array:
    """`n` points, evenly dense on the surface between two parameters each (a sphere's v is a polar angle)."""
    rng = np.random.default_rng(seed)
    across = rng.uniform(*u, n)
    along = rng.uniform(*v, n)
    match primitive:
        case Sphere():
            along = np.arccos(rng.uniform(np.cos(v[1]), np.cos(v[0]), n))
        case Cone():
            along = np.sqrt(rng.uniform(v[0] ** 2, v[1] ** 2, n))
        case Torus():
            weight = primitive.major_radius + primitive.minor_radius * np.cos(along)
            keep = rng.uniform(0, primitive.major_radius + primitive.minor_radius, n) < weight
            across, along = across[keep], along[keep]
    return primitive.surface(across, along)


def spoilt(points: Array, seed: int = 2) -> Array:
    """With noise of 0.1 % of the diagonal, and 5 % of the points anywhere in the bounding box."""
    rng = np.random.default_rng(seed)
    low, high = points.min(axis=0), points.max(axis=0)
    noisy = points + rng.normal(0.0, 1e-3 * np.linalg.norm(high - low), points.shape)
    noisy[: len(points) // 20] = rng.uniform(low, high, (len(points) // 20, 3))
    return noisy


def extents(points: Array, kind: str) -> Any:
    found = recognize(points, Config(kinds=(kind,)))
    assert found.status == "fitted", found.message
    assert type(found.extents) is EXTENTS[kind]
    return found.extents


SPOILS = {"clean": lambda points: points, "noise and outliers": spoilt}
spoils = pytest.mark.parametrize("spoil", SPOILS.values(), ids=SPOILS)


@spoils
@pytest.mark.parametrize(("start", "span"), [(0.5, 2.0), (2.5, 1.5), (5.0, 5.5), (1.0, 6.1), (0.0, TURN)])
def test_cylinder(spoil: Any, start: float, span: float) -> None:
    found = extents(spoil(piece(CYLINDER, (start, start + span), (-0.7, 1.1), 20_000)), "cylinder")
    low, high = CYLINDER.point - 0.7 * CYLINDER.axis, CYLINDER.point + 1.1 * CYLINDER.axis
    if found.start @ CYLINDER.axis > found.end @ CYLINDER.axis:
        low, high = high, low
    assert np.linalg.norm(found.start - low) < 0.018 and np.linalg.norm(found.end - high) < 0.018
    assert found.length == pytest.approx(1.8, rel=0.01)
    assert found.full_turn == (span == TURN)
    assert found.span == pytest.approx(span, rel=0.01)
    assert found.area == pytest.approx(span * 0.8 * 1.8, rel=0.015)
    assert found.coverage > 0.97
    _check_arc(found, CYLINDER, start, span)


@spoils
@pytest.mark.parametrize(("low", "high"), [(0.0, 2.0), (0.8, 2.0)])
@pytest.mark.parametrize(("start", "span"), [(2.5, 1.5), (1.0, 6.0), (0.0, TURN)])
def test_cone(spoil: Any, low: float, high: float, start: float, span: float) -> None:
    found = extents(spoil(piece(CONE, (start, start + span), (low, high), 20_000)), "cone")
    assert found.apex_inside == (low == 0.0)
    assert found.start_height == pytest.approx(low, abs=0.01 * high)
    assert found.end_height == pytest.approx(high, rel=0.01)
    assert found.start_radius == pytest.approx(low * np.tan(0.4), abs=0.01 * high)
    assert found.end_radius == pytest.approx(high * np.tan(0.4), rel=0.01)
    assert np.linalg.norm(found.end - (CONE.apex + high * CONE.axis)) < 0.01 * high
    assert found.full_turn == (span == TURN)
    assert found.span == pytest.approx(span, rel=0.01)
    assert found.area == pytest.approx(span / 2 * np.tan(0.4) / np.cos(0.4) * (high**2 - low**2), rel=0.02)
    assert found.coverage > 0.97
    _check_arc(found, CONE, start, span)


@spoils
@pytest.mark.parametrize(("start", "span"), [(2.5, 1.5), (1.0, 6.0), (0.0, TURN)])
@pytest.mark.parametrize(("tube_start", "tube_span"), [(2.0, 2.5), (-1.0, 2.5), (4.0, 6.0), (0.0, TURN)])
def test_torus(spoil: Any, start: float, span: float, tube_start: float, tube_span: float) -> None:
    points = piece(TORUS, (start, start + span), (tube_start, tube_start + tube_span), 20_000)
    found = extents(spoil(points), "torus")
    assert found.full_turn == (span == TURN)
    assert found.span == pytest.approx(span, rel=0.01)
    assert found.tube_full_turn == (tube_span == TURN)
    assert found.tube_span == pytest.approx(tube_span, rel=0.01)
    assert _apart(found.tube_start_angle, tube_start) < 0.01 * tube_span
    ends = np.sin(tube_start + tube_span) - np.sin(tube_start)
    assert found.area == pytest.approx(span * 0.6 * (2.0 * tube_span + 0.6 * ends), rel=0.02)
    assert found.coverage > 0.97
    _check_arc(found, TORUS, start, span)


def _check_arc(found: Any, primitive: Any, start: float, span: float) -> None:
    """The reference direction and the start angle lead to where the piece begins (or ends, axis reversed)."""
    assert found.reference_direction @ primitive.axis == pytest.approx(0.0, abs=0.01)
    if span == TURN:
        assert found.start_angle == 0.0
        return
    u, v = basis(primitive.axis)
    beyond = np.cross(primitive.axis, found.reference_direction)
    if found.reference_direction @ u < 0.9:  # the other sign of the axis has another reference
        return
    at = np.cos(found.start_angle) * found.reference_direction + np.sin(found.start_angle) * beyond
    assert at @ (np.cos(start) * u + np.sin(start) * v) > np.cos(0.01 * span)


def _apart(one: float, other: float) -> float:
    return abs((one - other + np.pi) % TURN - np.pi)


@spoils
@pytest.mark.parametrize("half_angle", [0.3, 1.0, 1.5, 2.2, 2.8, np.pi])
def test_sphere(spoil: Any, half_angle: float) -> None:
    points = piece(SPHERE, (0.0, TURN), (0.0, half_angle), 20_000)
    turned = (points - SPHERE.center) @ rotation(3).T + SPHERE.center
    found = extents(spoil(turned), "sphere")
    assert found.full_sphere == (half_angle == np.pi)
    assert found.half_angle == pytest.approx(half_angle, rel=0.01)
    assert found.area == pytest.approx(TURN * 1.5**2 * (1 - np.cos(half_angle)), rel=0.02)
    assert found.height == pytest.approx(1.5 * (1 - np.cos(half_angle)), rel=0.02)
    assert found.rim_radius == pytest.approx(1.5 * np.sin(half_angle), abs=0.02)
    assert found.start_half_angle == 0.0
    assert found.coverage > 0.97
    if half_angle < np.pi:
        assert found.axis @ rotation(3)[:, 2] > np.cos(0.01 * half_angle + 0.01)


@spoils
@pytest.mark.parametrize("low, high", [(0.3, 1.0), (0.5, 2.2), (1.0, 2.8), (1.4, 1.74), (0.6, np.pi - 0.6)])
def test_sphere_zone(spoil: Any, low: float, high: float) -> None:
    points = piece(SPHERE, (0.0, TURN), (low, high), 20_000)
    found = extents(spoil((points - SPHERE.center) @ rotation(3).T + SPHERE.center), "sphere")
    assert not found.full_sphere
    pole = rotation(3)[:, 2]
    if found.axis @ pole < 0.0:  # it points to the smaller opening
        pole, low, high = -pole, np.pi - high, np.pi - low
    assert found.axis @ pole > np.cos(0.01)
    assert found.start_half_angle == pytest.approx(low, abs=0.01 * high)
    assert found.half_angle == pytest.approx(high, rel=0.01)
    assert found.area == pytest.approx(TURN * 1.5**2 * (np.cos(low) - np.cos(high)), rel=0.01)
    assert found.height == pytest.approx(1.5 * (np.cos(low) - np.cos(high)), rel=0.01)
    assert np.linalg.norm(found.start_rim_center - (SPHERE.center + 1.5 * np.cos(low) * pole)) < 0.03
    assert found.start_rim_radius == pytest.approx(1.5 * np.sin(low), abs=0.02)
    assert found.coverage > 0.97


def test_a_zone_that_is_not_full_around_is_a_cap() -> None:
    found = extents(piece(SPHERE, (0.0, 5.0), (0.8, 2.0), 5000), "sphere")
    assert found.start_half_angle == found.start_rim_radius == 0.0
    assert found.coverage < 0.8


def test_the_cap_about_a_patch_is_the_smallest() -> None:
    points = piece(SPHERE, (0.2, 1.4), (1.0, 1.9), 3000)
    found = extents(points, "sphere")
    directions = (points - SPHERE.center) / SPHERE.radius
    rng = np.random.default_rng(0)
    others = found.axis + rng.normal(0.0, 0.05, (5000, 3))
    others /= np.linalg.norm(others, axis=1)[:, None]
    smallest = (others @ directions.T).min(axis=1).max()
    assert np.cos(found.half_angle) > smallest - 5e-3
    assert np.mean(directions @ found.axis >= np.cos(found.half_angle)) > 0.995


@spoils
def test_plane(spoil: Any) -> None:
    points = piece(PLANE, (-1.5, 1.5), (-0.5, 0.5), 20_000)
    found = extents(spoil(points), "plane")
    assert found.length == pytest.approx(3.0, rel=0.01)
    assert found.width == pytest.approx(1.0, rel=0.015)
    assert found.area == pytest.approx(3.0, rel=0.015)
    assert np.linalg.norm(found.center - PLANE.point) < 0.01
    assert found.coverage > 0.97
    assert abs(found.length_direction @ basis(PLANE.normal)[0]) > 0.9999
    a, b, c = found.outline[:3]
    assert np.cross(b - a, c - b) @ PLANE.normal > 0.0


def test_a_hole_is_not_covered() -> None:
    points = piece(CYLINDER, (0.0, 4.0), (0.0, 2.0), 30_000)
    _, _, height = around_axis(points, CYLINDER.point, CYLINDER.axis)
    found = extents(points[(height < 0.5) | (height > 1.1)], "cylinder")
    assert found.length == pytest.approx(2.0, rel=0.01)
    assert found.coverage == pytest.approx(0.7, abs=0.03)


def test_scan_lines_make_a_full_turn() -> None:
    angles, heights = np.meshgrid(np.arange(36) * TURN / 36, np.linspace(0.0, 3.0, 50))
    found = extents(CYLINDER.surface(angles.ravel(), heights.ravel()), "cylinder")
    assert found.full_turn
    half = extents(CYLINDER.surface(angles[:, :19].ravel(), heights[:, :19].ravel()), "cylinder")
    assert half.span == pytest.approx(np.pi, rel=0.01)


@pytest.mark.parametrize("scale", [1e-60, 1.0, 1e60])
@pytest.mark.parametrize("kind", KINDS)
def test_they_move_and_scale_with_the_cloud(kind: str, scale: float) -> None:
    points = piece(OF_KIND[kind], (0.3, 2.0), (0.5, 1.4), 2000)
    one, other = extents(points, kind), extents(scale * points, kind)
    assert other.area == pytest.approx(scale**2 * one.area, rel=1e-6)
    assert other.coverage == pytest.approx(one.coverage, abs=0.02)


def test_no_primitive_has_no_extents() -> None:
    flat = np.random.default_rng(0).uniform(-1, 1, (200, 3)) * [1, 1, 0]
    assert recognize(flat, Config(kinds=("torus",))).extents is None


@pytest.mark.parametrize("n", [3, 4, 5, 7, 10, 30])
@pytest.mark.parametrize("kind", KINDS)
def test_few_points_do_not_fail(kind: str, n: int) -> None:
    points = OF_KIND[kind].surface(np.linspace(0.1, 2.0, n), np.linspace(0.2, 1.1, n) ** 2)
    found = extents_of(OF_KIND[kind], points, 0.01)
    assert found is not None and 0.0 < found.coverage <= 1.0


def test_a_triangle_is_its_own_outline() -> None:
    """Rounding puts a corner inside the octagon of the outermost points, which are the corners."""
    corners = np.array(
        [
            [-2696.8583551327392, 2652.3217092313157, -10344.94562842277],
            [-7199.395068888343, -1639.9115395404501, 94.10011875630147],
            [-3201.20514849298, 5863.989091160152, -8656.255986004839],
        ]
    )
    extents = recognize(corners, Config(kinds=("plane",))).extents
    assert extents is not None
    np.testing.assert_allclose(np.sort(extents.outline, axis=0), np.sort(corners, axis=0), rtol=1e-9)


def test_points_on_a_circle_are_their_own_outline() -> None:
    turn = np.linspace(0.0, TURN, 20_000, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    extents = recognize(circle, Config(kinds=("plane",))).extents
    assert extents is not None
    assert extents.area == pytest.approx(np.pi, rel=1e-6) and extents.concave_area == extents.area


def test_points_on_one_line_of_a_plane_have_no_outline() -> None:
    assert extents_of(PLANE, PLANE.surface(np.linspace(0.0, 1.0, 10), np.zeros(10)), 0.0) is None


def test_an_outline_of_many_corners_takes_little_memory() -> None:
    n = 4000
    angle = np.random.default_rng(5).uniform(0.0, 2.0 * np.pi, n)
    ellipse = np.stack([3.0 * np.cos(angle), 2.0 * np.sin(angle), np.zeros(n)], axis=1)
    tracemalloc.start()
    extents = extents_of(Plane([0.0, 0.0, 1.0], [0.0, 0.0, 0.0]), ellipse, 0.0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert isinstance(extents, PlaneExtents) and len(extents.outline) == n
    assert (extents.length, extents.width) == pytest.approx((6.0, 4.0), rel=1e-5)
    assert abs(extents.length_direction[0]) == pytest.approx(1.0, abs=1e-5)
    assert extents.area == pytest.approx(6.0 * np.pi, rel=1e-4)
    assert peak < 8 * n**2  # one distance for each two corners
