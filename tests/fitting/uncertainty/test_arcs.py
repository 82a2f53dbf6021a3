"""Arcs and caps that points cover."""

import numpy as np
import pytest

from primfit.fitting.uncertainty.arcs import arcs_of, covered
from tests.fitting.clouds import EXAMPLES, sample


def test_arcs_are_those_of_the_points() -> None:
    assert covered(np.linspace(3.0, 3.5, 1000)) == pytest.approx(np.degrees(0.5), rel=0.02)
    cap = sample(EXAMPLES["sphere"], 10)[:1]
    assert arcs_of(EXAMPLES["sphere"], cap)["cap"] == pytest.approx(0.0, abs=1e-5)
    assert arcs_of(EXAMPLES["plane"], cap) == {}
