"""The degrees that points cover: those that they were drawn over; strays do not make an arc whole."""

import numpy as np
import pytest

from primfit.fitting.recognize import recognize
from tests.fitting.clouds import EXAMPLES


def test_arcs_are_those_of_the_extents() -> None:
    rng = np.random.default_rng(3)
    azimuth = np.append(rng.uniform(0.0, np.radians(100.0), 2000), np.radians([200.0, 201.0]))
    points = EXAMPLES["cylinder"].surface(azimuth, rng.uniform(-1.0, 1.0, 2002))
    found = recognize(points + 1e-3 * rng.normal(size=points.shape))
    assert found.extents is not None and found.uncertainty is not None
    assert found.extents.arcs["about the axis"] == pytest.approx(100.0, abs=1.0)
    (warning,) = (each for each in found.uncertainty.warnings if each.code == "one_sided")
    assert "an arc of 100 degrees about the axis" in warning.message


def test_a_plane_has_no_arcs() -> None:
    square = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3)) * [1.0, 1.0, 0.0]
    found = recognize(square)
    assert found.extents is not None and found.extents.arcs == {}
