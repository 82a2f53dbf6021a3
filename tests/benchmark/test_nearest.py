"""How far points are off every kind, against what is known beforehand."""

import numpy as np
import pytest

from primfit.benchmark.nearest import ENOUGH, off_every_kind
from primfit.synthetic.sections import bar, deviation, section
from tests.fitting.clouds import EXAMPLES, sample


@pytest.mark.parametrize("kind", EXAMPLES)
def test_points_of_a_primitive_are_off_by_nothing(kind):
    assert off_every_kind(sample(EXAMPLES[kind], 800)) < 1e-9


def test_it_is_root_mean_square_and_in_the_unit_of_the_points():
    """Two planes at a distance of 2, each with half of the points, far wider than that."""
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.uniform(-100.0, 100.0, (ENOUGH, 2)), np.tile([-1.0, 1.0], ENOUGH // 2)])
    assert off_every_kind(points) == pytest.approx(1.0, rel=0.02)
    assert off_every_kind(1e3 * points + 5e4) == pytest.approx(1e3, rel=0.02)


def test_a_long_square_bar_is_off_as_its_section_says():
    rng = np.random.default_rng(2)
    corners = section(rng, "4 faces")
    points, _ = bar(rng, corners, 3.0, 4000)
    assert off_every_kind(points) == pytest.approx(deviation(corners), rel=0.1)
