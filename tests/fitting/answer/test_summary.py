"""What an answer looks like when it is printed, and as plain values."""

import json

import numpy as np
import pytest

from primfit.fitting.answer.summary import summary
from primfit.fitting.primitives import parameters
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.fitting.by_hand import ambiguous
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


def test_far_from_the_origin_a_print_keeps_the_digits_that_are_known() -> None:
    points = noisy(EXAMPLES["sphere"], 300, 1e-4) + np.array([450_000.0, 5_400_000.0, 0.0])
    recognition = recognize(points, Config(kinds=("sphere",)))
    line = next(line for line in str(recognition).splitlines() if line.startswith("center"))
    assert recognition.primitive is not None
    shown = np.array(line.split()[1:], dtype=float)
    np.testing.assert_allclose(shown, recognition.primitive.center, rtol=0.0, atol=1e-6)


def test_a_coordinate_that_the_points_do_not_bound_is_said_to_be_open() -> None:
    answer = recognize(noisy(EXAMPLES["sphere"], 50, 0.01), Config(kinds=("sphere",))).to_dict()
    answer["uncertainty"]["intervals"]["center.x"]["high"] = None
    answer["uncertainty"]["intervals"]["radius"]["low"] = None
    lines = summary(answer).splitlines()
    assert lines[3].split()[0] == "open" and lines[3].count("±") == 2
    assert "  at most " in lines[4]


def test_a_cloud_without_an_answer_prints_the_best_try() -> None:
    recognition = recognize(np.random.default_rng(1).normal(size=(100, 3)), Config(kinds=("sphere", "plane")))
    lines = str(recognition).splitlines()
    assert lines[0].startswith("no fit  no allowed kind explains the cloud")
    assert lines[1].startswith("best try      ")
    assert repr(recognition).startswith("<Recognition: no_fit, best try ")


def test_an_ambiguous_answer_prints_every_kind_with_its_intervals_and_error() -> None:
    recognition = ambiguous()
    lines = str(recognition).splitlines()
    assert lines[1] == "kind          cylinder, with 95 % intervals"
    noise = next(i for i, line in enumerate(lines) if line.startswith("noise"))
    for other in recognition.alternatives:
        assert noise < lines.index(f"or            {other.primitive.kind}, with 95 % intervals")
        start = lines.index(f"or            {other.primitive.kind}, with 95 % intervals")
        end = next(i for i in range(start, len(lines)) if lines[i].startswith("error"))
        text = "\n".join(lines[start:end])
        assert "±" in text and "evidence" not in text
        for value in parameters(other.primitive).values():
            numbers = value if isinstance(value, list) else [value]
            assert all(f"{number:.9g}" in text for number in numbers if not isinstance(number, str))
        assert lines[end].startswith(f"error         rms {other.error.rms:.3g}  mean ")
        assert lines[end + 1].strip() == f"rms of the inliers {other.error.inlier_rms:.3g}"
    assert max(map(len, lines[1:-1])) <= 80
    assert repr(recognition).startswith("<Recognition: ambiguous, cylinder or plane or sphere or ")


def test_warnings_of_an_alternative_stand_below_it() -> None:
    answer = ambiguous().to_dict()
    told = {"code": "short_arc", "message": "the points cover an arc of 5 degrees"}
    answer["alternatives"][1]["uncertainty"]["warnings"] = [told]
    answer["alternatives"][2]["uncertainty"] = None
    lines = summary(answer).splitlines()
    assert lines.count("warning       the points cover an arc of 5 degrees") == 1
    kind = answer["alternatives"][2]["kind"]
    assert (
        lines[lines.index("warning       the points cover an arc of 5 degrees") + 1]
        == f"or            {kind}"
    )


def test_deviations_that_neighbours_share_are_said_in_words() -> None:
    answer = ambiguous().to_dict()
    text = summary(answer)
    assert "\n              neighbouring points share a deviation of 0.004 over 0.35\n" in text
    assert "\n              the points deviate smoothly by 0.4 over 60\n" in text
    answer["noise"] |= {"correlated": None, "smooth": None}
    assert "deviat" not in summary(answer)


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
