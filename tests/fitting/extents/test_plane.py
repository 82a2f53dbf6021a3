"""Rectangles, triangles and circles on a plane."""

import tracemalloc
from typing import Any

import numpy as np
import pytest

from primfit.fitting.extents import extents_of
from primfit.fitting.extents.plane import PlaneExtents
from primfit.fitting.geometry.vectors import around_axis, basis
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.extents.cuts import CYLINDER, PLANE, TURN, extents, piece, spoils


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
