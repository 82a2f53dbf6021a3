"""The compiled extents against what they were in NumPy: random pieces, noise, strays, few points, holes."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import shapely

from primfit.fitting.extents import _extents, extents_of
from primfit.fitting.extents.outline import _edges
from primfit.fitting.geometry.vectors import Array, basis
from tests.fitting.extents import reference_curved
from tests.fitting.extents.cuts import CONE, CYLINDER, OF_KIND, PLANE, SPHERE, TORUS, TURN, piece, spoilt
from tests.fitting.extents.reference_flat import plane
from tests.fitting.outlines import CUTS, patch

PIECES = {
    "cylinder part": (CYLINDER, (0.3, 2.9), (0.0, 2.0)),
    "cylinder": (CYLINDER, (0.0, TURN), (0.0, 2.0)),
    "cone part": (CONE, (4.0, 7.0), (0.5, 2.0)),
    "cone with apex": (CONE, (0.0, TURN), (0.0, 2.0)),
    "torus part": (TORUS, (1.0, 4.0), (0.5, 2.5)),
    "torus": (TORUS, (0.0, TURN), (0.0, TURN)),
    "cap": (SPHERE, (0.0, TURN), (0.0, 0.7)),
    "zone": (SPHERE, (0.0, TURN), (0.6, 1.4)),
    "most of a sphere": (SPHERE, (0.0, TURN), (0.5, np.pi)),
    "sphere": (SPHERE, (0.0, TURN), (0.0, np.pi)),
}
NOISES = (0.0, 0.01)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("n", [9, 39, 45, 400, 3000])
@pytest.mark.parametrize("name", PIECES)
def test_curved_pieces(name: str, n: int, noise: float) -> None:
    primitive, u, v = PIECES[name]
    points = piece(primitive, u, v, n, seed=n)
    points = points + noise * np.random.default_rng(n).normal(size=points.shape)
    same_as_reference(primitive, points, noise)


@pytest.mark.parametrize("kind", ["cylinder", "cone", "torus", "sphere"])
def test_curved_pieces_with_strays(kind: str) -> None:
    same_as_reference(OF_KIND[kind], spoilt(piece(OF_KIND[kind], (0.3, 2.0), (0.5, 1.4), 5000)), 3e-3)


def same_as_reference(primitive: Any, points: Array, noise: float) -> None:
    found = extents_of(primitive, points, noise)
    expected: Callable[..., dict[str, Any]] = getattr(reference_curved, primitive.kind)
    assert found is not None
    for name, value in expected(primitive, reference_curved.feet_of(primitive, points), noise).items():
        np.testing.assert_allclose(getattr(found, name), value, rtol=1e-9, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("noise", NOISES)
@pytest.mark.parametrize("n", [39, 50, 400, 3000, 20_000])
@pytest.mark.parametrize("name", CUTS)
def test_flat_pieces(name: str, n: int, noise: float) -> None:
    at = patch(name, n)
    at = np.concatenate([at, np.random.default_rng(n).uniform(-0.1, 1.1, (n // 300, 2))])
    points = PLANE.surface(at[:, 0], at[:, 1])
    points += noise * np.random.default_rng(n).normal(size=points.shape)
    flat_as_reference(points, noise)


def test_repeated_points_of_a_plane() -> None:
    at = np.repeat(patch("L", 700), 5, axis=0)
    flat_as_reference(PLANE.surface(at[:, 0], at[:, 1]), 0.0)


def flat_as_reference(points: Array, noise: float) -> None:
    found: Any = extents_of(PLANE, points, noise)
    expected = plane(PLANE, reference_curved.feet_of(PLANE, points), noise)
    outline, pieces = expected.pop("outline"), expected.pop("pieces")
    begins = int(np.argmin(np.linalg.norm(outline - found.outline[0], axis=1)))
    np.testing.assert_allclose(np.roll(outline, -begins, axis=0), found.outline, rtol=0.0, atol=1e-9)
    for name, value in expected.items():
        np.testing.assert_allclose(getattr(found, name), value, rtol=1e-9, atol=1e-9, err_msg=name)
    first, second = basis(PLANE.normal)
    *_, along, near = _extents.plane(np.ascontiguousarray(points), PLANE.point, first, second, noise)
    if near is None:
        assert pieces.is_empty
        return
    turned = np.array([along, [-along[1], along[0]]])
    shape = shapely.MultiPolygon(
        [(outer @ turned, [hole @ turned for hole in holes]) for outer, *holes in near[0]]
    )
    assert shapely.get_num_coordinates(shape) == shapely.get_num_coordinates(pieces)
    assert shape.symmetric_difference(pieces).area < 1e-9 * found.area


def test_depths_are_distances_to_the_boundary() -> None:
    ring = shapely.Point(0.0, 0.0).buffer(1.0).difference(shapely.Point(0.2, 0.1).buffer(0.4))
    shape = shapely.MultiPolygon([ring, shapely.box(2.0, 2.0, 3.0, 3.0)])
    at = np.random.default_rng(1).uniform(-1.5, 3.5, (3000, 2))
    inside = np.where(shapely.contains_xy(shape, at[:, 0], at[:, 1]), 1.0, -1.0)
    expected = inside * shapely.distance(shapely.points(at), shape.boundary)
    np.testing.assert_allclose(_extents.depths(at, _edges(shape)), expected, rtol=0.0, atol=1e-12)
