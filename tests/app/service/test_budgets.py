"""Limits by criterion follow from the time that a fit may take."""

import pytest

from primfit.app.readers import Limits, TooLargeError
from primfit.app.service.budgets import POINTS_A_SECOND, points_by_criterion
from primfit.app.service.settings import Settings
from primfit.fitting.names import CRITERIA


def test_every_criterion_has_a_limit() -> None:
    assert set(POINTS_A_SECOND) < set(CRITERIA)
    assert tuple(Settings().limits.criterion_points) == CRITERIA


def test_the_limit_grows_with_the_time_up_to_that_of_all_clouds() -> None:
    rate = POINTS_A_SECOND["minimum_zone"]
    assert points_by_criterion(2.0, 10**9)["minimum_zone"] == 2 * rate
    assert points_by_criterion(2.0, 5)["minimum_zone"] == 5
    assert points_by_criterion(1e-9, 5)["minimum_zone"] == 1
    assert points_by_criterion(1e-9, 5)["least_squares"] == 5


def test_a_cloud_at_the_limit_is_fitted() -> None:
    limits = Limits(criterion_points={"huber": 10})
    limits.check_criterion(10, "huber")
    limits.check_criterion(11, "robust")
    with pytest.raises(TooLargeError, match="11 points; the limit of the criterion huber is 10"):
        limits.check_criterion(11, "huber")
