"""Half a 95% interval: that of SciPy, which is not imported for it."""

import numpy as np
import pytest
from scipy.special import ndtri, stdtrit

from primfit.fitting.noise.student import MANY, NORMAL, half_interval


@pytest.mark.parametrize("free", [1.0, 1.01, 1.5, 2.0, 2.7, 3.0, 10.0, 31.5])
def test_few_degrees_of_freedom(free: float) -> None:
    assert half_interval(free) == pytest.approx(stdtrit(free, 0.975), rel=3e-14)


def test_any_degrees_of_freedom() -> None:
    free = np.exp(np.random.default_rng(0).uniform(0.0, np.log(1e5), 300))
    assert [half_interval(each) for each in free] == pytest.approx(stdtrit(free, 0.975), rel=1e-12)


def test_both_ways_agree_where_they_meet() -> None:
    assert half_interval(MANY) == pytest.approx(half_interval(np.nextafter(MANY, 0.0)), rel=1e-12)


def test_many_are_as_if_the_deviation_were_known() -> None:
    assert half_interval(None) == NORMAL == pytest.approx(ndtri(0.975), rel=1e-15)
    assert half_interval(1e9) == pytest.approx(NORMAL, rel=2e-9) and half_interval(1e9) > NORMAL
