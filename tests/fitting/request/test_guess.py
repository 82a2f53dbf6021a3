"""Initial guesses: used beside the starts, read from plain values, and checked."""

from typing import Any

import numpy as np
import pytest

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.guess import guess_of
from tests.fitting.clouds import EXAMPLES
from tests.fitting.constrained import CLOUDS, FAR, TRUTH, fit, tilted


def test_an_initial_guess_joins_the_starts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without any start of its own the search comes from the guess, in input units, to the same end."""
    expected = fit("cylinder", {})
    monkeypatch.setattr(Cylinder, "initial_guesses", classmethod(lambda *_: np.empty((0, 9))))
    assert fit("cylinder", {}).primitive is None
    guess = Cylinder(tilted(TRUTH["cylinder"].axis, 0.2), FAR, 1.2)  # type: ignore[attr-defined]
    guided = recognize(CLOUDS["cylinder"], Config(("cylinder",), "least_squares", initial_guess=guess))
    assert expected.error is not None and guided.error is not None
    assert guided.error.rms == pytest.approx(expected.error.rms, rel=1e-12)


@pytest.mark.parametrize(
    ("guess", "field", "said"),
    [
        (5, "initial_guess", "primitive"),
        ({"kind": "egg"}, "initial_guess.kind", "'egg'"),
        ({"kind": "sphere", "center": [0, 0, 0]}, "initial_guess", "kind, center, radius"),
        ({"kind": "sphere", "center": [0, 0], "radius": 1}, "initial_guess.center", "2 numbers"),
        ({"kind": "sphere", "center": [0, 0, 0], "radius": -1}, "initial_guess.radius", "-1"),
        ({"kind": "plane", "normal": [0, 0, 0], "point": [0, 0, 0]}, "initial_guess.normal", "zero"),
        (
            {"kind": "cone", "apex": [0, 0, 0], "axis": [0, 0, 1], "half_angle": 2},
            "initial_guess.half_angle",
            "pi/2",
        ),
    ],
)
def test_bad_guesses_are_named(guess: Any, field: str, said: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        guess_of(guess)
    assert caught.value.field == field
    assert said in str(caught.value)


@pytest.mark.parametrize("kind", EXAMPLES)
def test_a_guess_in_plain_values_is_the_primitive(kind: str) -> None:
    read, given = (parameters(each) for each in (guess_of(parameters(EXAMPLES[kind])), EXAMPLES[kind]))
    assert list(read) == list(given)
    assert read.pop("kind") == given.pop("kind")
    assert all(read[name] == pytest.approx(value, rel=1e-15) for name, value in given.items())


@pytest.mark.parametrize(
    ("guess", "field"),
    [
        (Sphere([0.0, 0.0, 0.0], -1.0), "initial_guess.radius"),
        (Sphere([0.0, np.nan, 0.0], 1.0), "initial_guess.center"),
        (Cone([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 2.0), "initial_guess.half_angle"),
    ],
)
def test_a_guess_built_by_hand_is_checked_too(guess: Primitive, field: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        Config(initial_guess=guess)
    assert caught.value.field == field
