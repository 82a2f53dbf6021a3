"""Annealing locks on what is exact."""

import numpy as np
import pytest

from primfit.fitting.search.anneal import anneal
from primfit.fitting.solver.refine import refine, stepped
from tests.fitting.clouds import EXAMPLES, sample


def test_annealing_locks_on_a_quarter_of_exact_points() -> None:
    cylinder = EXAMPLES["cylinder"]
    points = sample(cylinder, 500)
    points[:375] += np.random.default_rng(3).uniform(-0.15, 0.15, (375, 3))
    center = points.mean(axis=0)
    start = refine(stepped(cylinder.transformed(np.eye(3), -center, 1.0), np.full(5, 0.05)), points - center)
    found = anneal("cylinder", start.primitive.row(), points - center, 1e-13)
    assert found.exact_share == pytest.approx(0.25, abs=0.01)
