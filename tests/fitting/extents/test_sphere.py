"""Caps and zones of a sphere."""

from typing import Any

import numpy as np
import pytest

from tests.fitting.clouds import rotation
from tests.fitting.extents.cuts import SPHERE, TURN, extents, piece, spoils


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
