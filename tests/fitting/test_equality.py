"""Answers and primitives are equal where all that is in them is, also after they were pickled."""

import pickle
from copy import copy
from dataclasses import replace

import numpy as np
import pytest

import primfit
from primfit.fitting.equality import equal
from tests.fitting.clouds import EXAMPLES, noisy


@pytest.mark.parametrize("kind", EXAMPLES)
def test_an_answer_is_equal_to_itself_after_pickling_and_to_that_of_another_fit(kind: str) -> None:
    points = noisy(EXAMPLES[kind], 300, 0.01)
    found = primfit.fit(points, kinds=[kind])
    assert found.extents is not None and found.uncertainty is not None
    again = pickle.loads(pickle.dumps(found))
    assert found == again == primfit.fit(points.copy(), kinds=[kind])
    assert hash(found.primitive) == hash(again.primitive)
    assert found != primfit.fit(points, kinds=[kind], include=["extents"])
    assert found != primfit.fit(1.001 * points, kinds=[kind])


@pytest.mark.parametrize("kind", EXAMPLES)
def test_primitives_are_equal_by_their_parameters(kind: str) -> None:
    one = EXAMPLES[kind]
    for name, value in primfit.parameters(one).items():
        if name != "kind":
            changed = replace(one, **{name: np.roll(value, 1) if isinstance(value, list) else value / 2.0})  # type: ignore[type-var]
            assert one != changed
    assert {one: kind}[copy(one)] == kind
    assert one != kind


def test_segments_and_what_is_made_of_answers_are_equal_after_pickling() -> None:
    points = noisy(EXAMPLES["sphere"], 300, 0.01)
    found = primfit.fit(points)
    made = [
        *primfit.fit_segments(points, [1] * 298 + [2] * 2),
        primfit.residuals(found),
        primfit.form_errors(found),
    ]
    assert made == pickle.loads(pickle.dumps(made))
    assert made[0] != made[1]


def test_arrays_are_equal_by_shape_and_numbers_and_nan_equals_nan() -> None:
    numbers = np.array([[1.0, np.nan]])
    assert equal(numbers, numbers.copy()) and equal(np.nan, float("nan"))
    assert not equal(numbers, numbers[0])
    assert not equal(numbers, None) and not equal(None, numbers)
    assert not equal(numbers, [[1.0, np.nan]])
    assert equal({"a": (numbers, 1)}, {"a": (numbers.copy(), 1)})
    assert not equal({"a": numbers}, {"b": numbers}) and not equal((1,), (1, 2))
