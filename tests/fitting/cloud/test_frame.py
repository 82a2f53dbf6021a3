"""The frame of the search: centered, of size one, and without rounding."""

import numpy as np
import pytest

from primfit.fitting.cloud.frame import Frame
from tests.fitting.clouds import EXAMPLES, sample


@pytest.mark.parametrize("scale", [1e-300, 1e-12, 1e-4, 1.0, 1e4, 1e9, 1e90])
def test_the_frame_centers_and_scales_without_rounding(scale: float) -> None:
    points = scale * sample(EXAMPLES["cylinder"], 500)
    frame = Frame.of(points)
    inside = frame.normalize(points)
    assert np.abs(inside.mean(axis=0)).max() < 1e-9
    assert 0.5 < np.sqrt(np.mean(np.sum(inside**2, axis=1))) < 2.0
    assert np.log2(frame.scale) == np.round(np.log2(frame.scale))


def test_the_frame_subtracts_a_far_origin_exactly() -> None:
    points = np.round(sample(EXAMPLES["sphere"], 300) * 1024) / 1024 + 2.0**20
    frame = Frame.of(points)
    np.testing.assert_array_equal(frame.normalize(points) * frame.scale + frame.center, points)
