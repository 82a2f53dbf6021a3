"""Numbers and sentences for people."""

import math

import numpy as np
import pytest

from primfit.fitting.words import as_given, between, digits, figure, listed, part, percent, sentences, unlike


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (0.02, "0.0200"),
        (0.000388, "0.000388"),
        (3.88e-5, "0.0000388"),
        (123456.0, "123000"),
        (-1.5, "-1.50"),
        (9.999, "10.0"),
        (3.88e-9, "3.88e-09"),
        (4e12, "4.00e+12"),
        (0.0, "0"),
        (math.inf, "inf"),
    ],
)
def test_a_measured_number_has_three_digits_and_no_needless_power_of_ten(value: float, said: str) -> None:
    assert digits(value) == said
    assert figure(value, "mm") == f"{said} mm" and figure(value) == said


@pytest.mark.parametrize(
    ("value", "said"), [(5, "5"), (12.5, "12.5"), (1 + 2**-52, "1.0000000000000002"), (1e100, "1e+100")]
)
def test_a_number_that_was_given_stands_as_it_was_given(value: float, said: str) -> None:
    assert as_given(value) == said and as_given(value, "mm") == f"{said} mm"


@pytest.mark.parametrize(
    ("low", "high", "said"),
    [
        (12.1, 14.9, "12.1 to 14.9 mm"),
        (4.9987, 5.0012, "4.9987 to 5.0012 mm"),
        (0.02, 0.02, "0.0200 mm"),
        (0.0, 0.5, "0 to 0.500 mm"),
        (-0.1, 1000.0, "-0.100 to 1000 mm"),
        (None, 5.0, "at most 5.00 mm"),
        (5.0, None, "at least 5.00 mm"),
        (None, None, "not bounded by the points"),
    ],
)
def test_a_range_in_words(low: float | None, high: float | None, said: str) -> None:
    assert between(low, high, "mm") == said


def test_ends_of_a_range_differ_however_near_they_are() -> None:
    rng = np.random.default_rng(4)
    for value in rng.uniform(0.1, 10.0, 50) * 10.0 ** rng.integers(-12, 12, 50):
        for wide in 10.0 ** np.arange(-15.0, 3.0):
            low, high = between(value, value * (1.0 + wide)).split(" to ")
            assert float(low) < float(high)


def test_numbers_that_are_compared_are_told_apart() -> None:
    assert unlike(0.0101, 0.01) == ("0.0101", "0.0100")
    assert unlike(0.010000001, 0.01) == ("0.010000001", "0.010000000")
    assert unlike(0.21996, 0.22, percent) == ("21.996%", "22.000%")
    assert unlike(1.0, 1.0) == ("1.00000000000000000"[:18], "1.00000000000000000"[:18])
    assert (part(0.9999), part(0.001), part(0.5), part(0.0), part(1.0)) == (
        "99.99%",
        "0.1%",
        "50%",
        "0%",
        "100%",
    )


def test_clauses_become_sentences() -> None:
    assert (
        sentences("the points lie on it", "", "6 points are few.")
        == "The points lie on it. 6 points are few."
    )
    assert listed(["a plane"], "or") == "a plane"
    assert listed(["a plane", "a cone", "a torus"], "or") == "a plane, a cone or a torus"
