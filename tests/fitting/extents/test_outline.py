"""Concave outlines of plane patches with known cuts: even, uneven, noisy, scanned, and degenerate."""

from typing import Any

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from primfit.fitting.extents import extents_of
from primfit.fitting.extents.outline import MOST_CORNERS
from primfit.fitting.geometry.vectors import Array, basis
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.outlines import CUTS, lattice, patch

PLANE = Plane([0.2, -0.5, 0.8], [1.0, 2.0, 3.0])


def extents(at: Array, noise: float = 0.0) -> Any:
    return extents_of(PLANE, PLANE.surface(at[:, 0], at[:, 1]), noise)


def shape_of(found: Any) -> Any:
    """What the outline bounds, in the plane."""
    frame = np.array(basis(PLANE.normal))
    flat = [[(ring - PLANE.point) @ frame.T for ring in rings] for rings in found.concave_outline]
    for outer, *holes in flat:
        assert shapely.is_ccw(shapely.LinearRing(outer))
        assert not any(shapely.is_ccw(shapely.LinearRing(hole)) for hole in holes)
    return shapely.MultiPolygon([(outer, holes) for outer, *holes in flat])


@pytest.mark.parametrize("name", CUTS)
@pytest.mark.parametrize("n", [2000, 20_000])
def test_areas_of_random_points(name: str, n: int) -> None:
    _, area, holes = CUTS[name]
    found = extents(patch(name, n))
    assert found.concave_area == pytest.approx(area, rel=0.01 if n > 2000 else 0.025)
    assert [len(rings) - 1 for rings in found.concave_outline] == [holes]
    assert shape_of(found).area == pytest.approx(found.concave_area, rel=1e-9)
    assert np.abs(PLANE.signed_distance(np.concatenate(found.concave_outline[0]))).max() < 1e-12


@pytest.mark.parametrize("name", CUTS)
def test_a_grid_is_bounded_by_its_outer_points(name: str) -> None:
    """Where its rows lie along the edges, it ends half a step within them."""
    at = lattice(name, 20_000)
    _, area, holes = CUTS[name]
    found = extents(at)
    half_step = 0.0 if name in ("ring", "disc") else np.sqrt(area / len(at)) / 2.0
    assert found.concave_area + half_step * shape_of(found).length == pytest.approx(area, rel=0.01)
    assert [len(rings) - 1 for rings in found.concave_outline] == [holes]


@pytest.mark.parametrize("name", ["L", "U", "ring"])
def test_noise_and_outliers(name: str) -> None:
    _, area, holes = CUTS[name]
    rng = np.random.default_rng(1)
    at = patch(name, 20_000)
    points = PLANE.surface(at[:, 0], at[:, 1])
    points += rng.normal(0.0, 1.4e-3, points.shape)
    points[:1000] = rng.uniform(points.min(axis=0), points.max(axis=0), (1000, 3))
    found = recognize(points, Config(kinds=("plane",))).extents
    assert found and found.kind == "plane"
    assert found.concave_area == pytest.approx(area, rel=0.015)
    assert [len(rings) - 1 for rings in found.concave_outline] == [holes]


def test_where_the_points_fill_it_it_is_the_convex_one() -> None:
    found = extents(patch("square", 3000))
    ((ring,),) = found.concave_outline
    np.testing.assert_allclose(ring, found.outline, rtol=0.0, atol=1e-12)
    assert found.concave_area == found.area


@pytest.mark.parametrize("name", ["L", "U", "ring"])
def test_a_density_that_falls_to_a_fifth(name: str) -> None:
    _, area, holes = CUTS[name]
    at = patch(name, 50_000)
    at = at[np.random.default_rng(1).uniform(size=len(at)) < 5.0 ** -at[:, 0]]
    found = extents(at)
    assert found.concave_area == pytest.approx(area, rel=0.01)
    assert [len(rings) - 1 for rings in found.concave_outline] == [holes]


@pytest.mark.parametrize("aspect", [4.0, 25.0, 100.0])
def test_scan_lines_are_one_piece(aspect: float) -> None:
    """Lines so many times as far apart as the points along them."""
    step = np.sqrt(1e-4 * aspect)
    x, y = np.meshgrid(np.arange(0.0, 1.0, step / aspect), np.arange(0.0, 1.0, step))
    at = np.stack([x.ravel(), y.ravel()], axis=1)
    at = at[CUTS["U"][0](at)]
    found = extents(at)
    assert [len(rings) for rings in found.concave_outline] == [1]
    assert found.concave_area == pytest.approx(0.72, abs=2.5 * step)


def test_two_pieces_with_strays_between_them() -> None:
    at = patch("square", 20_000)
    at = at[(at[:, 0] < 0.3) | (at[:, 0] > 0.4)]
    found = extents(np.concatenate([at, np.random.default_rng(2).uniform(0.0, 1.0, (20, 2))]))
    areas = [part.area for part in shape_of(found).geoms]
    assert areas == pytest.approx([0.6, 0.3], rel=0.01)


def test_holes_are_found_that_are_several_spacings_wide() -> None:
    at = patch("square", 20_000)
    center = (np.floor(at * 4.0) + 0.5) / 4.0
    found = extents(at[np.abs(at - center).max(axis=1) > 0.04])
    assert [len(rings) for rings in found.concave_outline] == [17]
    assert found.concave_area == pytest.approx(1.0 - 16 * 0.08**2, rel=0.015)


def test_repeated_points_count_once() -> None:
    at = patch("L", 2000)
    assert extents(np.repeat(at, 7, axis=0)).concave_area == pytest.approx(extents(at).concave_area, rel=0.01)


def test_of_very_many_holes_the_largest_are_kept() -> None:
    at = patch("square", 60_000)
    found = extents(at[np.linalg.norm(np.mod(at, 0.05) - 0.025, axis=1) > 0.017])
    corners = sum(len(ring) for rings in found.concave_outline for ring in rings)
    assert MOST_CORNERS // 4 < corners <= MOST_CORNERS


@settings(max_examples=150, deadline=None)
@given(
    kind=st.sampled_from(["even", "rounded", "thin", "repeated", "clumps", "tails", "circles"]),
    n=st.integers(3, 300),
    noise=st.sampled_from([0.0, 1e-3, 0.3, 100.0]),
    seed=st.integers(0, 2**32 - 1),
)
def test_any_points_have_a_valid_outline_or_none(kind: str, n: int, noise: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    at = rng.normal(0.0, 1.0, (n, 2))
    match kind:
        case "rounded":
            at = np.round(at)
        case "thin":
            at *= [1.0, 1e-9]
        case "repeated":
            at = at[rng.integers(0, 1 + n // 5, n)]
        case "clumps":
            at = 1e-3 * at + 5.0 * rng.integers(0, 2, (n, 1))
        case "tails":
            at = np.exp(4.0 * at)
        case "circles":
            at *= (rng.integers(1, 3, n) / np.linalg.norm(at, axis=1))[:, None]
    found = extents(at, noise)
    if found is None:
        return
    assert shape_of(found).is_valid
    assert 0.0 < found.concave_area <= found.area
    assert sum(len(ring) for rings in found.concave_outline for ring in rings) <= MOST_CORNERS
