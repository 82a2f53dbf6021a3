"""Constraints and guesses beyond all proportion to the cloud."""

from typing import Any

import pytest

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.primitives import Primitive
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from tests.fitting.constrained import CLOUDS


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
    """Every cloud lies within the rounding of a sphere whose centre is 1e60 away."""
    config = Config(constraints=Constraints.of(constraints), initial_guess=guess)
    with pytest.raises(InvalidOptionError, match="extents of the cloud") as caught:
        recognize(unit * CLOUDS["cylinder"], config)
    assert caught.value.field == field


def test_a_far_guess_fools_nobody() -> None:
    config = Config(initial_guess=Sphere([1e9, 0.0, 0.0], 1e9))
    assert isinstance(recognize(CLOUDS["cylinder"], config).primitive, Cylinder)
    assert isinstance(recognize(CLOUDS["plane"], config).primitive, Plane)
