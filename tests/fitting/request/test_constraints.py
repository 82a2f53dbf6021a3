"""Constraints as a caller gives them: what is wrong is named."""

import math
from typing import Any

import numpy as np
import pytest

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints, Direction, Range
from tests.fitting.clouds import EXAMPLES


@pytest.mark.parametrize(
    ("constraints", "field", "said"),
    [
        ({"radius": {"value": -1.0}}, "constraints.radius.value", "-1"),
        ({"radius": {"value": np.nan}}, "constraints.radius.value", "nan"),
        ({"radius": {"value": 1, "min": 1}}, "constraints.radius", "either"),
        ({"radius": {}}, "constraints.radius", "either"),
        ({"radius": {"min": 3, "max": 2}}, "constraints.radius", "min 3 over the max 2"),
        ({"radius": {"low": 3}}, "constraints.radius", "'low'"),
        ({"radius": 5}, "constraints.radius", "mapping"),
        ({"radius": {"value": "5"}}, "constraints.radius.value", "not a number"),
        ({"half_angle": {"value": 1.6}}, "constraints.half_angle", "pi/2"),
        ({"axis": {"direction": [0, 0, 0]}}, "constraints.axis.direction", "zero"),
        ({"axis": {"direction": [0, 1]}}, "constraints.axis.direction", "2 numbers"),
        ({"axis": {"direction": [0, 1, np.inf]}}, "constraints.axis.direction", "inf"),
        ({"axis": {"direction": [0, 0, 1], "max_angle": 2}}, "constraints.axis.max_angle", "pi/2"),
        ({"axis": {"max_angle": 0.1}}, "constraints.axis", "direction"),
        ({"axis": [0, 0, 1]}, "constraints.axis", "mapping"),
        ({"center": [1, 2]}, "constraints.center", "2 numbers"),
        ({"center": 3.0}, "constraints.center", "[x, y, z]"),
        ({"tip": [1, 2, 3]}, "constraints", "apex"),
        ([1], "constraints", "mapping"),
    ],
)
def test_bad_constraints_are_named(constraints: Any, field: str, said: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        Constraints.of(constraints)
    assert caught.value.field == field
    assert said in str(caught.value)


def test_a_constraint_that_no_allowed_kind_has_is_refused() -> None:
    with pytest.raises(InvalidOptionError, match=r"apex.*cylinder, sphere; cone have it") as caught:
        Config(("cylinder", "sphere"), constraints=Constraints.of({"apex": [0, 0, 0]}))
    assert caught.value.field == "constraints.apex"
    with pytest.raises(InvalidOptionError, match="initial_guess is a cone"):
        Config(("cylinder",), initial_guess=EXAMPLES["cone"])


def test_what_is_built_by_hand_is_checked_too() -> None:
    with pytest.raises(InvalidOptionError, match="mapping"):
        Constraints(radius=5.0)  # type: ignore[arg-type]
    with pytest.raises(InvalidOptionError, match="min 3 over the max 2"):
        Constraints(radius=Range(3.0, 2.0))
    with pytest.raises(InvalidOptionError, match=r"Constraints\.of"):
        Config(constraints={"radius": {"value": 5}})  # type: ignore[arg-type]
    with pytest.raises(InvalidOptionError, match="not a primitive"):
        Config(initial_guess=5)  # type: ignore[arg-type]
    given = {
        "radius": {"min": 1.0},
        "axis": {"direction": [0.0, 0.0, 2.0], "max_angle": 0.1},
        "apex": [1.0, 2.0, 3.0],
    }
    assert Constraints.of(given).plain() == given


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (Range(-5.0, 3.0), "constraints.radius.min is -5; it must be positive"),
        (Range(math.nan, 3.0), "constraints.radius.min is nan"),
        (Range(3.0, -math.inf), "constraints.radius.max is -inf"),
        (Range("4", 6.0), "constraints.radius.min is '4', not a number"),  # type: ignore[arg-type]
        (Range(), "constraints.radius needs either a value, or a min"),
    ],
)
def test_an_end_of_a_range_is_never_dropped_in_silence(given: Range, said: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        Constraints(radius=given)
    assert said in str(caught.value)


def test_an_end_of_a_range_may_be_none_as_in_plain_values() -> None:
    assert Constraints(radius=Range(12.0, None)) == Constraints(radius=Range(12.0))  # type: ignore[arg-type]
    assert Constraints(radius=Range(None, 5.0)) == Constraints(radius=Range(high=5.0))  # type: ignore[arg-type]
    with pytest.raises(InvalidOptionError, match=r"constraints\.axis needs a direction"):
        Constraints(axis=Direction(None))  # type: ignore[arg-type]


def test_what_is_built_by_hand_is_the_same_as_what_is_parsed() -> None:
    plain = {"radius": {"min": 4, "max": 6}, "axis": {"direction": [0, 0, 2]}, "center": [1, 2, 3]}
    parsed = Constraints.of(plain)
    assert Constraints(**plain) == parsed  # type: ignore[arg-type]
    assert Constraints(Range(4.0, 6.0), axis=Direction((0.0, 0.0, 2.0)), center=(1.0, 2.0, 3.0)) == parsed
    assert Constraints.of(parsed) is parsed
    with pytest.raises(InvalidOptionError, match="min 3 over the max 2"):
        Constraints(radius=Range(3.0, 2.0))
