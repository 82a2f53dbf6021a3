"""What is known of an answer, and where nothing is claimed."""

import numpy as np

from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.clouds import EXAMPLES, noisy
from tests.fitting.uncertainty.known import arc, codes, known


def test_a_surface_that_the_points_leave_open_has_no_intervals() -> None:
    found = known(arc(8.0, 100, 0.004, 4), "cylinder")
    assert found.covariance is None and codes(found) >= {"undetermined"}


def test_few_points_warn_and_the_fewest_know_nothing() -> None:
    points = noisy(EXAMPLES["sphere"], 12, 0.01)
    assert "few_points" in codes(known(points, "sphere"))
    fewest = known(points[:4], "sphere")
    assert fewest.covariance is None and fewest.noise_model == "unknown" and not fewest.intervals
    assert codes(fewest) >= {"minimal_sample"}


def test_nothing_is_claimed_where_nothing_fits_or_no_theory_holds() -> None:
    volume = np.random.default_rng(5).uniform(-1.0, 1.0, (500, 3))
    assert recognize(volume).uncertainty is None
    extreme = Config(kinds=("sphere",), criterion="minimum_zone")
    assert recognize(noisy(EXAMPLES["sphere"], 100, 0.01), extreme).uncertainty is None
