"""Constraints and guesses beyond all proportion to the cloud."""

from typing import Any

import numpy as np
import pytest

from primfit.fitting.cloud.frame import Frame
from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.request.reach import FARTHEST, check_reach
from tests.fitting.constrained import CLOUDS

X = np.array([1.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("constraints", "guess", "field"),
    [
        ({"center": [1e60, 0.0, 0.0]}, None, "constraints.center"),
        ({"point": [1e99, 0.0, 0.0]}, None, "constraints.point"),
        ({"radius": {"min": 1e90}}, None, "constraints.radius"),
        ({"minor_radius": {"value": 1e20}}, None, "constraints.minor_radius"),
        ({}, Sphere([1e100, 0.0, 0.0], 1e100), "initial_guess"),
        ({}, Torus([1e50, 0.0, 0.0], [0.0, 0.0, 1.0], 1.0, 1e50), "initial_guess"),
    ],
)
@pytest.mark.parametrize("unit", [1.0, 1e-90])
def test_what_is_out_of_all_proportion_is_refused(
    constraints: dict[str, Any], guess: Primitive | None, field: str, unit: float
) -> None:
    """Every cloud lies within the rounding of a sphere whose center is 1e60 away."""
    config = Config(constraints=Constraints.of(constraints), initial_guess=guess)
    with pytest.raises(InvalidOptionError, match="extents of the cloud") as caught:
        recognize(unit * CLOUDS["cylinder"], config)
    assert caught.value.field == field


def test_a_far_guess_fools_nobody() -> None:
    config = Config(initial_guess=Sphere([1e9, 0.0, 0.0], 1e9))
    assert isinstance(recognize(CLOUDS["cylinder"], config).primitive, Cylinder)
    assert isinstance(recognize(CLOUDS["plane"], config).primitive, Plane)


@pytest.mark.parametrize("unit", [2.0**-60, 1.0, 2.0**60])
@pytest.mark.parametrize(
    "given",
    [
        lambda far, here: (Constraints.of({"center": (here + far * X).tolist()}), None),
        lambda far, here: (Constraints.of({"apex": (here - far * X).tolist()}), None),
        lambda far, here: (Constraints.of({"radius": {"min": far}}), None),
        lambda far, here: (Constraints.of({"major_radius": {"value": far}}), None),
        lambda far, here: (Constraints(), Sphere(here, far)),
        lambda far, here: (Constraints(), Plane(X, here + far * X)),
    ],
    ids=["center", "apex", "least radius", "known radius", "guess of that size", "guess from there"],
)
def test_the_limit_is_as_many_extents_in_any_unit(given: Any, unit: float) -> None:
    """A tenth less is let pass, a tenth more is not, wherever the cloud stands."""
    frame = Frame(unit * np.array([3.0, -5.0, 7.0]), 4.0 * unit)
    check_reach(*given(0.9 * FARTHEST * frame.scale, frame.center), frame)
    with pytest.raises(InvalidOptionError, match="extents of the cloud"):
        check_reach(*given(1.1 * FARTHEST * frame.scale, frame.center), frame)


def test_what_has_no_place_or_only_an_upper_end_is_never_out_of_reach() -> None:
    given = {"axis": {"direction": [0, 0, 1]}, "half_angle": {"value": 1e-3}, "radius": {"max": 1e30}}
    check_reach(Constraints.of(given), None, Frame(np.zeros(3), 1e-6))
