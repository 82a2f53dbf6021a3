"""Pieces of a cylinder with known cuts."""

from typing import Any

import numpy as np
import pytest

from tests.fitting.extents.cuts import CYLINDER, TURN, check_arc, extents, piece, spoils


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
    check_arc(found, CYLINDER, start, span)


def test_scan_lines_make_a_full_turn() -> None:
    angles, heights = np.meshgrid(np.arange(36) * TURN / 36, np.linspace(0.0, 3.0, 50))
    found = extents(CYLINDER.surface(angles.ravel(), heights.ravel()), "cylinder")
    assert found.full_turn
    half = extents(CYLINDER.surface(angles[:, :19].ravel(), heights[:, :19].ravel()), "cylinder")
    assert half.span == pytest.approx(np.pi, rel=0.01)
