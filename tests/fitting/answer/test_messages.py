"""What an answer says in sentences: figures in the unit, and the constraint that the points contradict."""

import re

import numpy as np
import pytest

from primfit.fitting.answer.result import Recognition
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.constraints import Constraints
from primfit.fitting.uncertainty.warnings import Findings, warnings_of
from tests.fitting.clouds import EXAMPLES, noisy, sample
from tests.fitting.uncertainty.known import arc

CYLINDER = noisy(EXAMPLES["cylinder"], 600, 0.01)
"""Of radius 0.8."""


def within(points: Array, constraints: dict[str, object], *kinds: str, **options: object) -> Recognition:
    return recognize(points, Config(kinds, unit="mm", constraints=Constraints.of(constraints), **options))


def told(answer: Recognition) -> list[str]:
    """All that an answer says."""
    warnings = () if answer.uncertainty is None else answer.uncertainty.warnings
    reasons = (attempt.reason for attempt in answer.attempts)
    return [answer.message, *reasons, *(warning.message for warning in warnings)]


@pytest.mark.parametrize("kind", EXAMPLES)
@pytest.mark.parametrize("sigma", [0.0, 0.01, 0.5])
@pytest.mark.parametrize("n_points", [8, 400])
def test_all_that_is_said_is_in_sentences_without_needless_powers_of_ten(
    kind: str, sigma: float, n_points: int
) -> None:
    for text in told(recognize(noisy(EXAMPLES[kind], n_points, sigma), Config(unit="mm"))):
        assert re.fullmatch(r"([A-Z0-9].*\.)", text) and ".." not in text and " ;" not in text
        assert not re.search(r"\de(-0[1-6]|\+0[1-8])", text), text


def test_figures_have_the_unit_and_without_one_stand_alone() -> None:
    answer = recognize(noisy(EXAMPLES["sphere"], 600, 0.02), Config(unit="mm"))
    assert answer.noise is not None
    said = re.fullmatch(
        r"The points scatter by (.*) mm about the sphere and show no pattern\.", answer.message
    )
    assert said and float(said[1]) == pytest.approx(answer.noise.scale, rel=5e-3)
    alone = recognize(noisy(EXAMPLES["sphere"], 600, 0.02))
    assert alone.message == answer.message.replace(" mm", "")
    assert alone.to_dict() | {"message": "", "attempts": []} == answer.to_dict() | {
        "message": "",
        "attempts": [],
    }


def test_a_constraint_that_the_points_contradict_is_named_with_what_they_say() -> None:
    answer = within(CYLINDER, {"radius": {"value": 0.4}}, "cylinder")
    assert answer.status == "no_fit"
    assert "A cylinder does not explain the points." in answer.message
    assert "The radius fixed at 0.4 mm contradicts the points: without it half of them" in answer.message
    radius = re.search(r"with a radius of ([\d.]+) mm", answer.message)
    assert radius and float(radius[1]) == pytest.approx(0.8, abs=0.01)


def test_a_kind_that_is_answered_in_place_of_a_constrained_one_says_so() -> None:
    answer = within(CYLINDER, {"radius": {"value": 0.4}}, "cylinder", "cone")
    assert answer.primitive is not None and answer.primitive.kind == "cone"
    assert "The radius fixed at 0.4 mm contradicts the points" in answer.message
    assert "The radius fixed at 0.4 mm contradicts the points" in answer.attempts[0].reason


def test_a_constraint_without_a_number_is_named_as_one_says_it() -> None:
    answer = within(CYLINDER, {"axis": {"direction": [1, 0, 0]}}, "cylinder")
    assert "The fixed direction of the axis contradicts the points: without it" in answer.message


def test_several_constraints_are_named_together() -> None:
    given = {"radius": {"max": 0.5}, "axis": {"direction": [0, 0, 1]}}
    message = within(CYLINDER, given, "cylinder", criterion="least_squares").message
    assert "The radius at its upper bound 0.5 mm and the fixed direction of the axis contradict" in message
    assert "the cylinder is answered as the only kind allowed" in message


def test_constraints_that_hold_without_harm_are_named_and_loose_ones_are_not() -> None:
    fixed = within(CYLINDER, {"radius": {"value": 0.8}}, "cylinder").message
    assert fixed.startswith("With the radius fixed at 0.8 mm, the points scatter by ")
    assert "contradict" not in fixed
    loose = within(CYLINDER, {"radius": {"min": 0.1}}, "cylinder").message
    assert loose.startswith("The points scatter by ")
    cone = within(noisy(EXAMPLES["cone"], 400, 0.01), {"half_angle": {"max": 0.3}}, "cone").message
    assert "The half angle at its upper bound 17.1887 degrees contradicts" in cone.replace(
        "half-angle", "half angle"
    )


def test_what_is_wrong_is_said_of_the_best_try_where_it_is_wrong() -> None:
    volume = np.random.default_rng(1).normal(size=(500, 3))
    answer = recognize(volume)
    assert answer.status == "no_fit" and answer.primitive is not None
    kind = answer.primitive.kind
    assert answer.message.startswith(
        f"None of the allowed kinds explains the points; the best try is a {kind}. The points scatter by "
    )
    assert f" about the {kind}: they fill a volume, or lie on several surfaces." in answer.message


def test_max_error_is_told_from_the_error_however_near_they_are() -> None:
    mean = recognize(CYLINDER, Config(("cylinder",), "least_squares")).error
    assert mean is not None
    for share in (mean.relative_mean * (1.0 + 1e-9), mean.relative_mean * (1.0 - 1e-9)):
        answer = recognize(CYLINDER, Config(("cylinder",), "least_squares", max_error=share))
        said = re.search(
            r"that is ([\d.]+) of the diagonal.*(within|over) max_error \((.*?)\)", answer.message
        )
        assert said and float(said[3]) == share
        assert (float(said[1]) <= share) == (said[2] == "within") == (answer.status == "fitted")


def test_a_range_in_a_warning_has_the_unit_and_angles_are_in_degrees() -> None:
    found = recognize(arc(30.0, 300, 0.01, 1), Config(("cylinder",), unit="cm")).uncertainty
    assert found is not None
    short = next(each.message for each in found.warnings if each.code == "short_arc")
    low, high = (float(end) for end in re.findall(r"radius ([\d.]+) to ([\d.]+) cm", short)[0])
    interval = found.intervals["radius"]
    assert low == pytest.approx(interval.low, rel=5e-3) and high == pytest.approx(interval.high, rel=5e-3)
    cone = recognize(noisy(EXAMPLES["cone"], 20, 0.1), Config(("cone",), "least_squares")).uncertainty
    assert cone is not None
    weak = next(each.message for each in cone.warnings if each.code == "weak_size")
    assert re.fullmatch(r"The half-angle is weakly determined: [\d.]+ to [\d.]+ degrees\.", weak)


def test_exact_points_are_said_to_lie_on_the_surface() -> None:
    answer = recognize(sample(EXAMPLES["torus"], 200))
    assert answer.message == "Every point lies on the torus within the rounding of the coordinates."


@pytest.mark.parametrize(
    ("effective", "said"), [(0.3, "one alone"), (1.2, "one alone"), (38.2, "38 independent ones")]
)
def test_points_that_deviate_alike_tell_as_much_as_one_at_least(effective: float, said: str) -> None:
    found = Findings(
        kind="plane", n_points=400, dof=3, determined=True, few=False, arcs={}, sizes={}, axis_95=None,
        correlation_length=48.5, effective_points=effective, unit="mm",
    )  # fmt: skip
    (warning,) = warnings_of(found)
    assert warning.message == (
        f"Neighboring points deviate alike over about 48.5 mm: 400 points tell no more than {said}."
    )
