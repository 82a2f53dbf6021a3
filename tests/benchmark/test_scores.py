"""Rates and spreads against numbers worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest

from primfit.benchmark.scores import (
    ANSWERS,
    among,
    averages,
    confusion,
    is_close,
    is_exact,
    macro,
    named,
    over_least_squares,
    rates,
    share,
    spread,
    standard_errors,
)
from primfit.fitting.names import KINDS
from tests.benchmark.made import record


def test_confusion_matrix_with_its_rejections():
    answers = ["plane", "plane", "sphere", "ambiguous", "no_fit", "failed"]
    counts = confusion([*(record("plane", answer) for answer in answers), record("foreign", "plane")])
    assert counts.shape == (len(KINDS), len(ANSWERS)) and counts.sum() == 6
    assert dict(zip(ANSWERS, counts[0].tolist(), strict=True)) == {
        "plane": 2,
        "sphere": 1,
        "cylinder": 0,
        "cone": 0,
        "torus": 0,
        "ambiguous": 1,
        "no_fit": 1,
        "failed": 1,
    }


def test_rates_by_hand():
    """Ten clouds: 4 planes (3 right, 1 taken for a sphere), 6 spheres (4 right, 1 as plane, 1 no_fit)."""
    counts = np.zeros((5, 8), int)
    counts[0, :2] = 3, 1
    counts[1, :2] = 1, 4
    counts[1, ANSWERS.index("no_fit")] = 1
    found = rates(counts)
    plane = {name: values[0] for name, values in found.items()}
    # TP 3, FP 1, FN 1, TN 5
    assert plane == pytest.approx({"PPV": 3 / 4, "NPV": 5 / 6, "TPR": 3 / 4, "TNR": 5 / 6, "ACC": 8 / 10})
    sphere = {name: values[1] for name, values in found.items()}
    # TP 4, FP 1, FN 2 (one of them rejected), TN 3
    assert sphere == pytest.approx({"PPV": 4 / 5, "NPV": 3 / 5, "TPR": 4 / 6, "TNR": 3 / 4, "ACC": 7 / 10})
    # Nobody is or was called a cone.
    assert np.isnan(found["PPV"][3]) and np.isnan(found["TPR"][3])
    assert (found["NPV"][3], found["TNR"][3], found["ACC"][3]) == (1.0, 1.0, 1.0)
    assert macro(found["PPV"]) == pytest.approx((3 / 4 + 4 / 5) / 2)
    assert np.isnan(macro(np.array([np.nan])))


def test_a_kind_that_is_not_there_has_no_precision():
    """Twelve planes, one of which is called a torus."""
    counts = np.zeros((5, 8), int)
    counts[0, [0, KINDS.index("torus")]] = 11, 1
    assert averages(counts)["PPV"] == 1.0 and averages(counts)["TPR"] == pytest.approx(11 / 12)
    assert averages(counts)["TNR"] == pytest.approx((3 + 11 / 12) / 4)


def test_quartiles_count_what_is_wrong_and_moments_do_not():
    found = spread([4.0, np.inf, 1.0, 3.0, 2.0])
    assert (found.q1, found.q2, found.q3) == (2.0, 3.0, 4.0)
    assert (found.mean, found.std) == pytest.approx((2.5, np.sqrt(1.25)))
    assert spread([1.0, np.inf]).q2 == 1.0 and spread([1.0, np.inf, np.inf]).q2 == np.inf
    assert np.isnan(spread([]).q2) and np.isnan(spread([np.inf]).mean)


def test_close_is_right_and_near():
    assert is_close(record("plane", "plane", surface=0.01))
    assert not is_close(record("plane", "plane", surface=0.011))
    assert not is_close(record("plane", "sphere", surface=0.0))
    assert not is_close(record("plane", "plane", errors={"surface": None}))
    assert is_close(record("foreign", "no_fit")) and not is_close(record("foreign", "plane"))
    assert is_exact(record("plane", "plane", surface=1e-9))
    assert not is_exact(record("plane", "plane", surface=1.1e-9))
    assert not is_exact(record("plane", "sphere", surface=0.0))
    assert share([record("plane", "plane"), record("plane", "cone")], is_close) == 0.5
    assert np.isnan(share([], is_close))


def test_errors_of_wrong_answers_are_infinite():
    assert record("plane", "plane", surface=0.5).error("surface") == 0.5
    assert record("plane", "sphere", surface=0.5).error("surface") == np.inf
    assert record("plane", "plane").error("l2") == np.inf


def test_errors_over_those_of_least_squares_by_hand():
    """Answers are off by 3 and 4, references by 1 and 2; what is wrong or has none does not count."""
    records = [
        record("plane", "plane", surface=0.3, reference_errors={"surface": 0.1, "expected": 0.1}),
        record("plane", "plane", surface=0.004, reference_errors={"surface": 0.002, "expected": 0.001}),
        record("plane", "sphere", surface=9.0, reference_errors={"surface": 0.1, "expected": 0.1}),
        record("plane", "plane", surface=9.0),
        record("plane", "plane", surface=9.0, reference_errors={"surface": None, "expected": 0.1}),
    ]
    ratio, clouds = over_least_squares(records)
    assert ratio == pytest.approx(np.sqrt((9 + 16) / (1 + 4))) and clouds == 2
    ratio, clouds = over_least_squares(records[2:])
    assert np.isnan(ratio) and clouds == 0


def test_standard_errors_by_hand():
    """Mean 2, deviation 2, four values: a standard error of 1."""
    assert standard_errors([2 - np.sqrt(3), 2 + np.sqrt(3), 2 - np.sqrt(3), 2 + np.sqrt(3)]) == pytest.approx(
        2.0
    )
    assert np.isnan(standard_errors([0.0, 0.0]))


def test_the_truth_among_several():
    right, wrong, refused = record("cone", "cone"), record("cone", "torus"), record("cone", "no_fit")
    several = replace(
        record("cone", "ambiguous"), answer={"kind": "torus"}, alternatives=("cylinder", "cone")
    )
    assert named(several) == ("torus", "cylinder", "cone") and named(right) == ("cone",)
    assert named(refused) == named(replace(refused, answer={"kind": "cone"})) == ()
    assert [among(each) for each in (right, wrong, refused, several)] == [True, False, False, True]
    assert not among(replace(several, alternatives=("cylinder",)))


def test_a_kind_without_a_surface_is_close_when_it_is_right():
    assert is_close(record("cone", "cone", errors={"mfe": 0.1}))
    assert not is_close(record("cone", "torus", errors={"mfe": 0.1}))
