"""Numbers of a report have the digits that are known, and no zeros that a smaller unit spares them."""

import pytest

from primfit.app.exports.report.numbers import Unit, column, measured, said, short
from primfit.fitting.uncertainty.values import Interval


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.0021, "mm", "2.100 µm"),
        (0.0999, "mm", "99.90 µm"),
        (0.128, "mm", "0.1280 mm"),
        (2.5e-6, "mm", "2.500 nm"),
        (2.5e-9, "mm", "0.002500 nm"),
        (0.0042, "m", "4.200 mm"),
        (0.0042, "inch", "0.004200 inch"),
        (0.0042, None, "0.004200"),
        (-0.0042, "mm", "-4.200 µm"),
        (0.0, "m", "0 m"),
        (12345.6, "mm", "12,346 mm"),
        (3e18, None, "3.000e+18"),
    ],
)
def test_lengths_have_no_leading_zeros(value: float, unit: str | None, text: str) -> None:
    assert said(value, unit) == text


@pytest.mark.parametrize(
    ("value", "low", "high", "found", "within"),
    [
        (8.000031, 7.999954, 8.000108, "8.000031", "±\u00a00.000077"),
        (1234571.56162, 1234571.56111, 1234571.56213, "1234571.56162", "±\u00a00.00051"),
        (477.285, -41.0, 995.5, "480", "±\u00a0520"),
        (0.0705, 0.0549, 0.1306, "0.070", "0.055 to 0.131"),
        (12.5, None, 14.2, "12.5", "at most 14.2"),
        (12.5, 11.4, None, "12.5", "at least 11.4"),
        (1234567.8, 1234560.1, None, "1234567.8", "at least 1234560.1"),
        (200.0, None, None, "200.0", "unbounded"),
        (2.0, 2.0 - 1e-16, 2.0 + 1e-16, "2.0000000000", "±\u00a0rounding"),
        (7e-17, -1e-16, 3e-16, "0.0000000000", "±\u00a0rounding"),
    ],
)
def test_a_number_and_its_interval_have_two_digits_of_half_of_it(
    value: float, low: float | None, high: float | None, found: str, within: str
) -> None:
    interval = Interval(low, high, 3.0, "profile")
    assert measured(value, interval, 5.0) == (found, within)


def test_a_smaller_unit_moves_the_digits_of_both() -> None:
    interval = Interval(0.0420, 0.0440, 0.0005, "linear")
    assert measured(0.0430, interval, 5.0, Unit.of(0.0430, "mm").factor) == ("43.0", "±\u00a01.0")
    assert measured(5.0, Interval(5.0, 5.0, 0.0, "held"), 5.0) == ("5", "held by a constraint")
    assert measured(5.0, None, 5.0) == ("5", "")


def test_a_column_has_as_many_decimals_as_its_size_asks_for() -> None:
    assert [column(value, 2.1) for value in (-3e-14, 2.1, -0.0313, 92690.1)] == [
        "0.000",
        "2.100",
        "-0.031",
        "92,690",
    ]
    assert column(5e-17, 5e-17) == short(5e-17) == "5.000e-17"
