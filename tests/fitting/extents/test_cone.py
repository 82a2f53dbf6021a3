"""Pieces of a cone with known cuts, with and without the apex."""

from typing import Any

import numpy as np
import pytest

from tests.fitting.extents.cuts import CONE, TURN, check_arc, extents, piece, spoils


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
    check_arc(found, CONE, start, span)
