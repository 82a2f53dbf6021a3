"""What is a cloud, and what is refused with the place named."""

import numpy as np
import pytest

from primfit.fitting.errors import InvalidPointCloudError
from primfit.fitting.recognize import recognize
from tests.fitting.clouds import EXAMPLES, noisy, sample

LINE = np.outer(np.linspace(-1, 1, 50), [1.0, 2.0, 3.0])


def test_normals_are_used_when_given() -> None:
    cylinder = EXAMPLES["cylinder"]
    points = noisy(cylinder, 300, 0.01)
    answer = recognize(points, normals=3.0 * cylinder.gradient(points))
    assert answer.status == "fitted" and answer.primitive is not None and answer.primitive.kind == "cylinder"
    with pytest.raises(InvalidPointCloudError, match=r"\(299, 3\)"):
        recognize(points, normals=cylinder.gradient(points)[:-1])


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((0, 3)), "0 points"),
        (np.zeros((2, 3)), "2 points given; at least 3"),
        (np.ones((50, 3)), "all 50 points are the same"),
        (LINE, "collinear"),
        (LINE + 1e6, "collinear"),
        (np.repeat(np.eye(3)[:2], 30, axis=0), "collinear"),
        (np.ones((50, 2)), r"shape \(50, 2\)"),
        (np.ones(9), r"shape \(9,\)"),
        ([[1, 2, 3], [4, 5]], "cannot be read"),
        ([["a", "b", "c"]] * 4, "cannot be read"),
        (1e120 * sample(EXAMPLES["sphere"], 20), "limit is 1e\\+100"),
        (1e-120 * sample(EXAMPLES["sphere"], 20), "limit is 1e-100"),
    ],
)
def test_what_cannot_be_a_cloud_is_an_error(points: object, message: str) -> None:
    with pytest.raises(InvalidPointCloudError, match=message):
        recognize(points)  # type: ignore[arg-type]


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_non_finite_coordinates_are_named(value: float) -> None:
    points = sample(EXAMPLES["sphere"], 50)
    points[17, 2] = value
    with pytest.raises(InvalidPointCloudError, match=r"1 of 50 points .* points\[17\]"):
        recognize(points)
