"""Extents of every kind: they move with the cloud, and few points do not fail."""

import numpy as np
import pytest

from primfit.fitting.extents import extents_of
from primfit.fitting.names import KINDS
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.extents.cuts import OF_KIND, extents, piece


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
