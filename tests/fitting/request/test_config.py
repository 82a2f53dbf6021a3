"""Options that are out of range are named; numbers of NumPy are numbers."""

import numpy as np
import pytest

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.clouds import EXAMPLES, noisy


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"kinds": ()}, "kinds"),
        ({"kinds": ("cube",)}, "kinds"),
        ({"kinds": ("plane", "plane")}, "kinds"),
        ({"criterion": "best"}, "criterion"),
        ({"max_error": 0.0}, "max_error"),
        ({"max_error": float("nan")}, "max_error"),
        ({"max_error": 2.0}, "max_error"),
        ({"max_error": "small"}, "max_error"),
        ({"seed": -1}, "seed"),
        ({"seed": 1.5}, "seed"),
        ({"kinds": "plane"}, "kinds"),
        ({"kinds": {"plane": 1}}, "kinds"),
        ({"unit": ""}, "unit"),
        ({"unit": "millimeters of"}, "unit"),
        ({"unit": 5}, "unit"),
    ],
)
def test_options_out_of_range_are_named(options: dict, field: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        Config(**options)
    assert caught.value.field == field


def test_numbers_of_numpy_are_numbers() -> None:
    points = noisy(EXAMPLES["plane"], 100, 0.01)
    config = Config(seed=np.int64(3), max_error=np.float32(0.5))  # type: ignore[arg-type]
    assert recognize(points, config).to_json() == recognize(points, Config(seed=3, max_error=0.5)).to_json()


def test_a_number_just_beyond_a_limit_is_told_from_it() -> None:
    with pytest.raises(InvalidOptionError, match=r"max_error is 1\.0000000000000002; it is a share"):
        Config(max_error=1.0 + 2.0**-52)
