"""Sections: sound outlines of width 1, normals outward, and deviations worked out by hand."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist
from shapely import Point, Polygon

from primfit.synthetic.sections import (
    DENSE,
    SECTIONS,
    along,
    bar,
    circle_part,
    deviation,
    ellipse,
    from_circle,
    from_line,
    rectangle,
    regular,
    section,
)


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("sort", SECTIONS)
def test_outlines_are_sound_and_normals_point_outward(sort):
    for seed in range(5):
        corners = section(rng(seed), sort)
        outline = Polygon(corners)
        assert outline.is_valid and pdist(corners).max() == pytest.approx(1.0)
        points, normals = along(corners, rng(seed).random(100))
        np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
        for point, normal in zip(points, normals, strict=True):
            assert outline.exterior.distance(Point(point)) < 1e-12
            assert outline.contains(Point(point - 1e-6 * normal))
            assert not outline.contains(Point(point + 1e-6 * normal))


def test_there_are_twenty_sorts():
    assert len(SECTIONS) == 20


def test_a_square_is_off_its_best_circle_as_calculus_says():
    """At distances sqrt(1 + t^2), t uniform in [0, 1]: mean (sqrt 2 + asinh 1) / 2, mean square 4/3."""
    mean = (np.sqrt(2) + np.arcsinh(1)) / 2
    expected = np.sqrt(4 / 3 - mean**2) / (2 * np.sqrt(2))
    assert deviation(section(rng(), "4 faces")) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("faces", [3, 5, 6, 8])
def test_so_is_every_regular_bar(faces):
    """t is uniform up to the tangent of half a side's angle."""
    reach = np.tan(np.pi / faces)
    mean = (np.hypot(1, reach) + np.arcsinh(reach) / reach) / 2
    expected = np.sqrt(1 + reach**2 / 3 - mean**2)
    points, _ = along(regular(faces) / np.cos(np.pi / faces), (np.arange(DENSE) + 0.5) / DENSE)
    assert from_circle(points) == pytest.approx(expected, rel=2e-3)


def test_a_nearly_round_ellipse_is_off_by_its_second_harmonic():
    """Half-axes 1 + e and 1: radius 1 + e / 2 + e / 2 cos(2 a), which is e / sqrt(8) off, to first order."""
    points, _ = along(ellipse(1.002), (np.arange(DENSE) + 0.5) / DENSE)
    assert from_circle(points) == pytest.approx(0.002 / np.sqrt(8), rel=0.05)


def test_a_flat_section_is_nearer_to_a_plane():
    """A strip of 1 by 20: 40 of 42 at a height of 1/2, the ends uniform over the height."""
    flat = rectangle(20.0, 1.0)
    assert deviation(flat) == pytest.approx(np.sqrt((40 / 4 + 2 / 12) / 42), rel=1e-3)
    points, _ = along(flat, (np.arange(DENSE) + 0.5) / DENSE)
    assert from_line(points) == deviation(flat) < from_circle(points)


def test_a_circle_is_off_by_nothing_but_its_sides():
    assert deviation(circle_part(0.0, 2 * np.pi)[:-1]) < 4e-5


def test_a_bar_is_its_section_drawn_out():
    corners = section(rng(1), "L")
    points, normals = bar(rng(2), corners, 3.0, 5000)
    outline = Polygon(corners).exterior
    assert max(outline.distance(Point(point)) for point in points[:200, :2]) < 1e-12
    assert np.ptp(points[:, 2]) == pytest.approx(3.0, abs=0.01) and not normals[:, 2].any()
    # uniform in area: the lower leg's outer side holds as many as its share of the outline
    below = np.mean(points[:, 1] < 1e-9)
    sides = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    assert below == pytest.approx(sides[0] / sides.sum(), abs=4 * np.sqrt(0.25 / 5000))
