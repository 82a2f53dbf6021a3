"""Annealing locks on what is exact."""

import numpy as np
import pytest

from primfit.fitting.cloud.cloud import Cloud
from primfit.fitting.search.anneal import anneal
from primfit.fitting.solver.refine import refine, stepped
from primfit.fitting.trial.trial import Trial
from tests.fitting.clouds import EXAMPLES, sample


def test_annealing_locks_on_a_quarter_of_exact_points() -> None:
    cylinder = EXAMPLES["cylinder"]
    points = sample(cylinder, 500)
    points[:375] += np.random.default_rng(3).uniform(-0.15, 0.15, (375, 3))
    cloud = Cloud.prepare(points, None, np.random.default_rng(0))
    start = refine(stepped(cloud.frame.bring(cylinder), np.full(5, 0.05)), cloud.working)
    found = anneal(Trial("cylinder", cloud), start.primitive.row(), cloud.working)
    assert found.exact_share == pytest.approx(0.25, abs=0.01)
