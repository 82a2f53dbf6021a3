"""What an answer looks like when it is printed, and as plain values."""

import json

import numpy as np
import pytest

from fitting.config import Config
from fitting.recognize import recognize
from tests.fitting.clouds import EXAMPLES, noisy, sample


@pytest.mark.parametrize("kind", EXAMPLES)
def test_a_print_shows_every_parameter_with_its_interval(kind: str) -> None:
    recognition = recognize(noisy(EXAMPLES[kind], 300, 0.01), Config(kinds=(kind,)))
    lines = str(recognition).splitlines()
    assert lines[0] == f"fitted  {recognition.message}"
    assert lines[1] == f"kind          {kind}, with 95 % intervals"
    assert lines[-1] == f"tried         {kind} (accepted)"
    text = "\n".join(lines)
    for name, value in recognition.to_dict()["primitive"].items():
        if name != "kind":
            numbers = value if isinstance(value, list) else [value]
            assert all(f"{number:.9g}" in text for number in numbers), name
    intervals = recognition.to_dict()["uncertainty"]["intervals"]
    assert text.count("±") == len(intervals) + sum(
        name in text for name in ("axis  ", "normal  ", "position")
    )
    assert max(map(len, lines[1:])) <= 80
    assert repr(recognition) == f"<Recognition: fitted, {kind}, 300 points>"


def test_a_short_arc_is_shown_by_its_ends_and_what_is_held_without() -> None:
    # A tenth of a radian of arc: the interval of the radius leans to the long side.
    rng = np.random.default_rng(3)
    arc = EXAMPLES["cylinder"].surface(rng.uniform(0.0, 0.5, 200), rng.uniform(0.0, 2.0, 200))
    arc += rng.normal(0.0, 0.005, arc.shape)
    text = str(recognize(arc, Config(kinds=("cylinder",), criterion="least_squares")))
    ends = next(line.split() for line in text.splitlines() if line.startswith("radius"))
    assert ends[3] == "to" and float(ends[2]) < float(ends[1]) < float(ends[4])
    assert "\nwarning       the points cover an arc of " in text


def test_a_cloud_without_an_answer_prints_the_best_try() -> None:
    recognition = recognize(np.random.default_rng(1).normal(size=(100, 3)), Config(kinds=("sphere", "plane")))
    lines = str(recognition).splitlines()
    assert lines[0].startswith("no fit  no allowed kind explains the cloud")
    assert lines[1].startswith("best try      ")
    assert repr(recognition).startswith("<Recognition: no_fit, best try ")


def test_plain_values_survive_json_to_the_last_bit() -> None:
    recognition = recognize(noisy(EXAMPLES["torus"], 200, 0.01))
    values = recognition.to_dict()
    assert json.loads(recognition.to_json()) == values
    assert json.loads(json.dumps(values)) == values
    assert recognition.primitive is not None and recognition.uncertainty is not None
    assert values["primitive"]["major_radius"] == recognition.primitive.major_radius
    np.testing.assert_array_equal(values["uncertainty"]["covariance"], recognition.uncertainty.covariance)
    assert values["attempts"][0] == recognition.attempts[0].to_dict()


def test_an_exact_cloud_prints_too() -> None:
    text = str(recognize(sample(EXAMPLES["sphere"], 100)))
    assert "exact 100.0%" in text and "±" in text
