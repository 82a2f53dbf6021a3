"""Pieces of a torus with known cuts, around its axis and around its tube."""

from typing import Any

import numpy as np
import pytest

from tests.fitting.extents.cuts import TORUS, TURN, apart, check_arc, extents, piece, spoils


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
    assert apart(found.tube_start_angle, tube_start) < 0.01 * tube_span
    ends = np.sin(tube_start + tube_span) - np.sin(tube_start)
    assert found.area == pytest.approx(span * 0.6 * (2.0 * tube_span + 0.6 * ends), rel=0.02)
    assert found.coverage > 0.97
    check_arc(found, TORUS, start, span)
