"""What an answer looks like when it is printed, and as plain values."""

import json
import re
from typing import Any

import numpy as np
import pytest

from primfit.fitting.answer.summary import summary
from primfit.fitting.primitives import parameters
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from tests.fitting.by_hand import ambiguous
from tests.fitting.clouds import EXAMPLES, noisy, sample


@pytest.mark.parametrize("kind", EXAMPLES)
def test_a_print_shows_every_parameter_with_its_interval(kind: str) -> None:
    recognition = recognize(noisy(EXAMPLES[kind], 300, 0.01), Config(kinds=(kind,), unit="mm"))
    lines = str(recognition).splitlines()
    assert lines[0] == f"kind             {kind}, with 95% intervals"
    assert f"fitted           {recognition.message}" in lines
    assert lines[-1] == f"tried            {kind} (accepted)"
    text = "\n".join(lines)
    for name, value in recognition.to_dict()["primitive"].items():
        if isinstance(value, list):
            assert all(f"{number:.9g}" in text for number in value), name
    intervals = recognition.to_dict()["uncertainty"]["intervals"]
    others = ("\naxis  ", "\nnormal  ", "position", "diameter  ")
    assert text.count("±") == len(intervals) + sum(name in text for name in others)
    assert max(len(line) for line in lines if recognition.message not in line) <= 80
    assert repr(recognition) == f"<Recognition: fitted, {kind}, 300 points>"


@pytest.mark.parametrize("kind", EXAMPLES)
def test_the_headline_says_what_one_looks_for_first(kind: str) -> None:
    recognition = recognize(noisy(EXAMPLES[kind], 300, 0.01), Config(kinds=(kind,), unit="mm"))
    error, truth = recognition.error, parameters(EXAMPLES[kind])
    assert error is not None and recognition.uncertainty is not None
    rows = str(recognition).split("\nfitted ")[0].splitlines()
    said = {line[:17].strip(): line[17:] for line in rows}
    for name, interval in recognition.uncertainty.intervals.items():
        if name in truth:
            label = name.replace("half_angle", "half-angle").replace("_", " ")
            value, half = said[label].split(" ± ")
            scale = 180.0 / np.pi if label == "half-angle" else 1.0
            assert abs(float(value) - scale * truth[name]) < 2.0 * float(half.split()[0])  # type: ignore[operator]
            wide = scale * (interval.high - interval.low) / 2.0  # type: ignore[operator]
            assert float(half.split()[0]) == pytest.approx(wide, rel=0.1)
    assert ("diameter" in said) == ("radius" in said) == ("radius" in truth)
    assert said["form error"] == f"{error.zone:#.3g} mm, over all points"
    assert said["inliers"] == f"all 300, rms {error.inlier_rms:#.3g} mm"
    shown = {"plane": "size", "sphere": "part", "torus": "around the axis"}.get(kind, "length")
    assert shown in said


def test_the_diameter_is_twice_the_radius_with_twice_its_interval() -> None:
    lines = str(recognize(noisy(EXAMPLES["cylinder"], 300, 0.01), Config(kinds=("cylinder",)))).splitlines()
    shown = {line.split()[0]: line.split()[1:] for line in lines[1:3]}
    assert float(shown["diameter"][0]) == pytest.approx(2.0 * float(shown["radius"][0]), abs=2e-4)
    assert float(shown["diameter"][2]) == pytest.approx(2.0 * float(shown["radius"][2]), rel=0.1)


def test_outliers_are_counted_and_points_of_no_weight_are_not() -> None:
    points = noisy(EXAMPLES["sphere"], 400, 0.01)
    points[:20] += 5.0
    recognition = recognize(points, Config(kinds=("sphere",)))
    assert "\ninliers          380 of 400, rms 0.0" in str(recognition)
    assert ", over the inliers\n" in str(recognition)
    receipt = {"n_points": 500, "weights_sha256": "abc", "unit": None}
    assert "\ninliers          95% of the points, rms 0.0" in summary(
        recognition.to_dict() | {"receipt": receipt}
    )
    assert "\ninliers          95% of the points, rms 0.0" in summary(recognition.to_dict())


def test_a_short_arc_is_shown_by_its_ends_and_what_is_held_without() -> None:
    # A tenth of a radian of arc: the interval of the radius leans to the long side.
    rng = np.random.default_rng(3)
    arc = EXAMPLES["cylinder"].surface(rng.uniform(0.0, 0.5, 200), rng.uniform(0.0, 2.0, 200))
    arc += rng.normal(0.0, 0.005, arc.shape)
    text = str(recognize(arc, Config(kinds=("cylinder",), criterion="least_squares")))
    for label in ("diameter", "radius"):
        line = next(line for line in text.splitlines() if line.startswith(label))
        value, low, high = map(float, re.fullmatch(r"\w+ +(.*) \((.*) to (.*)\)", line).groups())  # type: ignore[union-attr]
        assert low < value < high
    assert "\nwarning          The points cover an arc of " in text


def test_what_is_held_is_said_to_be_fixed() -> None:
    given = Constraints.of({"radius": {"value": 0.8}})
    text = str(recognize(noisy(EXAMPLES["cylinder"], 300, 0.01), Config(("cylinder",), constraints=given)))
    assert "\nradius           0.8, fixed\n" in text and "\ndiameter         1.6, fixed\n" in text
    assert "\nconstraints      radius: fixed at 0.8\n" in text


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
    text = summary(answer)
    assert re.search(r"\n +open +± \S+ +± \S+\n", text)
    assert re.search(r"\nradius +\S+ \(at most \S+\)\n", text)


def test_a_cloud_without_an_answer_prints_the_best_try() -> None:
    recognition = recognize(np.random.default_rng(1).normal(size=(100, 3)), Config(kinds=("sphere", "plane")))
    lines = str(recognition).splitlines()
    assert lines[0].startswith("best try         ")
    assert any(
        line.startswith("no fit           None of the allowed kinds explains the points") for line in lines
    )
    assert repr(recognition).startswith("<Recognition: no_fit, best try ")


def test_an_ambiguous_answer_prints_every_kind_with_its_intervals_and_error() -> None:
    recognition = ambiguous()
    lines = str(recognition).splitlines()
    others = "plane, sphere, cone or torus"
    assert lines[0] == f"kind             cylinder, with 95% intervals; or a {others}, see below"
    noise = next(i for i, line in enumerate(lines) if line.startswith("noise"))
    for other in recognition.alternatives:
        start = lines.index(f"or               {other.primitive.kind}, with 95% intervals")
        assert noise < start
        end = next(i for i in range(start, len(lines)) if lines[i].startswith("distances"))
        text = "\n".join(lines[start:end])
        assert "±" in text and "evidence" not in text
        for value in parameters(other.primitive).values():
            if isinstance(value, list):
                assert all(f"{number:.9g}" in text for number in value)
        assert lines[end].startswith(f"distances        rms {other.error.rms:#.3g}, mean ")
        assert f"\nform error       {other.error.zone:#.3g}, over all points\n" in text
        assert f"\ninliers          all 200, rms {other.error.inlier_rms:#.3g}\n" in text
    assert max(len(line) for line in lines[1:-1] if recognition.message not in line) <= 80
    assert repr(recognition).startswith("<Recognition: ambiguous, cylinder or plane or sphere or ")


def test_warnings_of_an_alternative_stand_below_it() -> None:
    answer = ambiguous().to_dict()
    told = {"code": "short_arc", "message": "the points cover an arc of 5 degrees"}
    answer["alternatives"][1]["uncertainty"]["warnings"] = [told]
    answer["alternatives"][2]["uncertainty"] = None
    lines = summary(answer).splitlines()
    said = "warning          the points cover an arc of 5 degrees"
    assert lines.count(said) == 1
    assert lines[lines.index(said) + 1] == f"or               {answer['alternatives'][2]['kind']}"


def test_warnings_about_the_points_are_shown() -> None:
    answer = ambiguous().to_dict() | {"warnings": ["3 points are missing."]}
    assert "\nwarning          3 points are missing.\n" in summary(answer)


def test_deviations_that_neighbors_share_are_said_in_words() -> None:
    answer = ambiguous().to_dict()
    text = summary(answer)
    assert "\n                 neighboring points share a deviation of 0.00400 over 0.350\n" in text
    assert "\n                 the points deviate smoothly by 0.400 over 60.0\n" in text
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
    assert "100% on it exactly" in text and "±" in text


def _checked(**check: Any) -> str:
    """The line of a radius, or another check, in millimeters."""
    given = {
        "name": "radius",
        "nominal": 5.0,
        "deviation": 0.1,
        "low": None,
        "high": None,
        "verdict": "within",
    }
    answer = recognize(noisy(EXAMPLES["sphere"], 50, 0.01), Config(kinds=("sphere",), unit="mm")).to_dict()
    found = {"verdict": "within", "kind": "sphere", "checks": [given | check]}
    text = summary(answer | {"conformance": found, "receipt": {"unit": "mm", "n_points": 50}})
    return text.split("\nverdict ")[1].splitlines()[1].partition("  ")[2].strip()


@pytest.mark.parametrize(
    ("check", "said"),
    [
        ({"low": 0.05, "high": 0.15, "lower": -0.2, "upper": 0.2},
         "deviation 0.100 mm (0.0500 to 0.150 mm), allowed ± 0.2 mm: within"),
        ({"low": 0.05, "high": 0.15, "lower": 0.0, "upper": 0.3},
         "deviation 0.100 mm (0.0500 to 0.150 mm), allowed 0 to 0.3 mm: within"),
        ({"low": 0.05, "lower": -0.2, "upper": 0.2, "verdict": "undecided"},
         "deviation 0.100 mm (at least 0.0500 mm), allowed ± 0.2 mm: undecided"),
        ({"lower": -0.2, "upper": 0.2}, "deviation 0.100 mm (interval not known), allowed ± 0.2 mm: within"),
        ({"lower": -0.2, "upper": 0.2, "verdict": "undecided"},
         "deviation 0.100 mm (not bounded by the points), allowed ± 0.2 mm: undecided"),
        ({"name": "form", "deviation": 0.20004, "lower": 0.0, "upper": 0.2, "verdict": "beyond"},
         "error 0.20004 mm, allowed up to 0.2 mm: beyond"),
        ({"name": "center", "nominal": [1, 2, 3], "low": 0.0, "high": 0.15, "lower": 0.0, "upper": 0.2},
         "deviation 0.100 mm (0 to 0.150 mm), allowed up to 0.2 mm: within"),
    ],
)  # fmt: skip
def test_a_deviation_is_said_beside_what_is_allowed(check: dict[str, Any], said: str) -> None:
    assert _checked(**check) == said


def test_a_verdict_where_nothing_fits_claims_no_other_shape() -> None:
    blob = np.random.default_rng(0).normal(size=(300, 3))
    text = str(recognize(blob, Config(form_tolerance=1.0)))
    assert "\nverdict          beyond tolerance: no kind explains the points\n" in text


def test_a_verdict_names_the_kind_where_it_is_not_the_first() -> None:
    answer = ambiguous().to_dict()
    first, other = answer["primitive"]["kind"], answer["alternatives"][0]["kind"]
    for verdict, kind, said in (
        ("undecided", other, f"undecided as a {other}: an interval reaches over its tolerance"),
        ("beyond", other, f"beyond tolerance as a {other}"),
        ("within", first, "within tolerance"),
    ):
        found = {"verdict": verdict, "kind": kind, "checks": []}
        assert f"\nverdict          {said}\n" in summary(answer | {"conformance": found})


def test_numbers_of_a_vector_never_touch() -> None:
    answer = recognize(noisy(EXAMPLES["cylinder"], 300, 0.01), Config(kinds=("cylinder",))).to_dict()
    axis = [-0.000391588896123, -0.000102541885123, -0.999999917]
    answer["primitive"] |= {"axis": axis, "point": [-1.2345678e-07, -5.76498154e-05, -1234567.891]}
    for label in ("axis", "point"):
        (line,) = (line for line in summary(answer).splitlines() if line.startswith(label))
        shown = np.array(line.split()[1:], dtype=float)
        np.testing.assert_allclose(shown, answer["primitive"][label], rtol=1e-7)
