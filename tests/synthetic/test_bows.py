"""Pieces that can be told, and smooth deviations from them that are what they are called."""

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.synthetic.bows import (
    ARC,
    DEVIATIONS,
    DEVIATIONS_OF,
    HALF_ANGLE,
    LOBES,
    RADIUS_CHANGE,
    SWEEP,
    TORUS_RATIO,
    Piece,
    barrel,
    bow,
    draw_piece,
    lobe,
    piece_of,
)

SMALL = 1e-4
"""Of a deviation, so that its square is beneath notice."""


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def moved(piece: Piece, field: np.ndarray) -> np.ndarray:
    return piece.points + SMALL * field[:, None] * piece.primitive.gradient(piece.points)


@pytest.mark.parametrize("kind", KINDS)
def test_pieces_lie_on_their_surface_and_can_be_told(kind):
    for seed in range(20):
        piece = draw_piece(rng(seed), kind, 500)
        assert np.abs(piece.primitive.signed_distance(piece.points)).max() < 1e-12
        assert -1.0 <= piece.along.min() and piece.along.max() <= 1.0 and len(piece.points) == 500
        truth, arc = piece.primitive, np.degrees(np.ptp(piece.around))
        if kind in ("cylinder", "cone"):
            assert 0.95 * ARC.low < arc <= 360.0
        if kind == "cone":
            rho = np.hypot(piece.points[:, 0], piece.points[:, 1])
            assert HALF_ANGLE.low <= np.degrees(truth.half_angle) <= HALF_ANGLE.high
            assert 0.95 * RADIUS_CHANGE.low < rho.max() / rho.min() <= RADIUS_CHANGE.high
        if kind == "torus":
            assert TORUS_RATIO.low <= truth.major_radius / truth.minor_radius <= TORUS_RATIO.high
            assert 0.95 * SWEEP.low < arc <= 360.0


def test_points_are_uniform_in_area():
    """On a frustum the mean slant is 2/3 (1 - s^3) / (1 - s^2); on half a torus the outer side holds more."""
    piece = draw_piece(rng(3), "cone", 40_000)
    slant = np.linalg.norm(piece.points, axis=1)
    start = slant.min()
    assert slant.mean() == pytest.approx(2 / 3 * (1 - start**3) / (1 - start**2), abs=4e-3)
    ring = draw_piece(rng(0), "torus", 40_000)
    truth, height = ring.primitive, np.hypot(ring.points[:, 0], ring.points[:, 1])
    tube = np.arctan2(ring.points[:, 2], height - truth.major_radius)
    span = np.ptp(tube)
    if span > 6.28:
        # A whole tube: the density is (R + r cos) / (2 pi R), so that the mean cosine is r / (2 R).
        assert np.cos(tube).mean() == pytest.approx(truth.minor_radius / (2 * truth.major_radius), abs=0.01)


def test_a_bent_cylinder_is_a_piece_of_a_wide_torus():
    piece = draw_piece(rng(1), "cylinder", 800)
    away = bow(rng(5), piece)
    turn = rng(5).uniform(0.0, 2 * np.pi)
    half = (piece.points[:, 2] / piece.along)[np.argmax(np.abs(piece.along))]
    bend = half**2 / (2 * SMALL)
    outward = piece.primitive.surface(np.array([turn]), np.zeros(1))[0]
    torus = Torus(bend * outward, np.cross(outward, [0, 0, 1]), bend, 1.0)
    assert np.abs(torus.signed_distance(moved(piece, away))).max() < SMALL**2 * 100


def test_a_bow_of_a_plane_is_a_cap_or_a_sag():
    piece = draw_piece(rng(2), "plane", 500)
    corner = (np.linalg.norm(piece.points, axis=1) / piece.along)[0]
    radius = corner**2 / (2 * SMALL)
    seen = set()
    for seed in range(8):
        points = moved(piece, bow(rng(seed), piece))
        turn = rng(seed).uniform(0.0, 2 * np.pi)
        ball = Sphere([0, 0, radius], radius)
        roll = Cylinder([-np.sin(turn), np.cos(turn), 0.0], [0, 0, radius], radius)
        off = [np.abs(surface.signed_distance(points)).max() for surface in (ball, roll)]
        assert min(off) < SMALL**2 * 10
        seen.add(int(np.argmin(off)))
    assert seen == {0, 1}


@pytest.mark.parametrize("kind", ["cylinder", "cone", "torus", "sphere"])
def test_lobes_go_around_two_to_five_times(kind):
    turn = np.linspace(0.0, 2 * np.pi, 720, endpoint=False)
    truth = draw_piece(rng(0), kind, 10).primitive
    piece = Piece(truth, np.zeros((720, 3)), turn, np.zeros(720))
    counts = {int(np.argmax(np.abs(np.fft.rfft(lobe(rng(seed), piece))))) for seed in range(40)}
    assert counts == set(LOBES)


def test_a_barrel_is_highest_in_the_middle_and_the_same_all_around():
    piece = draw_piece(rng(4), "cylinder", 300)
    field = barrel(rng(0), piece)
    assert field[np.argmin(np.abs(piece.along))] == field.max()
    assert np.allclose(field, -(piece.along**2))


@pytest.mark.parametrize("kind", KINDS)
def test_any_part_of_a_surface_has_the_coordinates_of_a_piece(kind):
    """Turned, moved and scaled the fields are those of the piece itself, but for where azimuths start."""
    piece = draw_piece(rng(7), kind, 400)
    turned = np.linalg.qr(rng(8).standard_normal((3, 3)))[0]
    turned *= np.sign(np.linalg.det(turned))
    truth = piece.primitive.transformed(turned, np.array([5.0, -3.0, 2.0]), 2.0)
    points = 2.0 * piece.points @ turned.T + [5.0, -3.0, 2.0]
    found = piece_of(rng(9), truth, points)
    assert np.abs(found.along).max() <= 1.0 + 1e-12
    if kind in ("cylinder", "cone"):
        lows, highs = piece.along.min(), piece.along.max()
        own = (2 * piece.along - highs - lows) / (highs - lows)
        same = np.allclose(found.along, own, atol=0.1) or np.allclose(found.along, -own, atol=0.1)
        assert same
    for name in DEVIATIONS_OF[kind]:
        field = DEVIATIONS[name](rng(10), found)
        assert field.shape == (400,) and np.isfinite(field).all() and np.std(field) > 0.0


def test_a_plane_needs_no_axis():
    found = piece_of(
        rng(0), Plane([0, 0, 1], [0, 0, 3]), np.array([[1.0, 0, 3], [-1, 0, 3], [0, 2, 3], [0, -2, 3]])
    )
    np.testing.assert_allclose(found.along, [0.5, 0.5, 1.0, 1.0])
