"""What was measured, held against what it should be."""

import math
from typing import Any

import numpy as np
import pytest

from primfit.fitting.answer.conformance import Conformance
from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from primfit.fitting.request.nominal import Nominal

RNG = np.random.default_rng(12)
NOISE = 0.02
PIPE = Cylinder(np.array([0.0, 0.0, 1.0]), np.zeros(3), 25.0).surface(
    RNG.uniform(0.0, 6.0, 400), RNG.uniform(0.0, 50.0, 400)
) + RNG.normal(0.0, NOISE, (400, 3))


def _held(form_tolerance: float | None = None, points: Any = PIPE, **nominal: Any) -> Conformance:
    wanted = Nominal.of({"kind": "cylinder", **nominal}) if nominal else None
    found = recognize(points, Config(nominal=wanted, form_tolerance=form_tolerance)).conformance
    assert found is not None
    return found


def test_nothing_is_said_where_nothing_is_asked() -> None:
    assert recognize(PIPE).conformance is None


@pytest.mark.parametrize(
    ("tolerance", "verdict"), [(0.05, "within"), ([-0.01, 0.01], "within"), (1e-4, "undecided"),
                               ([0.02, 0.04], "beyond"), (None, None)]
)  # fmt: skip
def test_a_radius_is_judged_by_its_whole_interval(tolerance: Any, verdict: str | None) -> None:
    """Its interval is some 0.005 wide."""
    found = _held(radius={"value": 25.0, "tolerance": tolerance})
    (check,) = found.checks
    assert check.verdict == found.verdict == verdict
    assert check.low is not None and check.high is not None and check.low < check.deviation < check.high
    assert abs(check.deviation) < 0.005 < 0.02 > check.high - check.low
    assert check.deviation == check.measured - 25.0  # type: ignore[operator]


def test_directions_and_positions_deviate_by_angles_and_distances() -> None:
    tilted = [0.0, math.sin(0.1), -math.cos(0.1)]
    found = _held(
        axis={"value": tilted, "tolerance": 0.11}, point={"value": [3.0, 4.0, 77.0], "tolerance": 4.0}
    )
    axis, point = found.checks
    assert axis.deviation == pytest.approx(0.1, abs=0.001) and axis.verdict == "within"
    assert point.deviation == pytest.approx(5.0, abs=0.01) and point.verdict == found.verdict == "beyond"
    exact = _held(axis={"value": [0, 0, 1], "tolerance": 0.01})
    assert exact.verdict == "within" and exact.checks[0].low == 0.0


def test_a_point_deviates_from_a_plane_by_its_height_and_a_center_by_its_distance() -> None:
    flat = Plane(np.array([0.0, 0.0, 1.0]), np.zeros(3)).surface(*RNG.uniform(-9, 9, (2, 300)))
    plane = Nominal.of({"kind": "plane", "point": [5.0, 5.0, 2.0]})
    found = recognize(flat, Config(nominal=plane)).conformance
    assert found and found.checks[0].deviation == pytest.approx(2.0)
    ball = Sphere(np.array([1.0, 2.0, 2.0]), 5.0).surface(RNG.uniform(0, 6, 300), RNG.uniform(0, 3, 300))
    sphere = Nominal.of({"kind": "sphere", "center": {"value": [0, 0, 0], "tolerance": 1}})
    found = recognize(ball, Config(nominal=sphere)).conformance
    assert found and found.checks[0].deviation == pytest.approx(3.0) and found.verdict == "beyond"


@pytest.mark.parametrize("kind", ["cylinder", "plane"])
def test_far_along_an_axis_or_plane_a_position_is_known_less_well(kind: str) -> None:
    """A hundred lengths away, the least error of the direction moves it by more than that of the position."""
    surface: Any = Cylinder(np.array([0.0, 0.0, 1.0]), np.zeros(3), 5.0)
    first, second = RNG.uniform(0.0, 6.0, 400), RNG.uniform(0.0, 10.0, 400)
    if kind == "plane":
        surface = Plane(np.array([0.0, 0.0, 1.0]), np.zeros(3))
    points = surface.surface(first, second) + RNG.normal(0.0, NOISE, (400, 3))
    far = [1000.0, 0.0, 0.0] if kind == "plane" else [0.0, 0.0, 1000.0]
    for place, most in (([0.0, 0.0, 0.0], 0.02), (far, 5.0)):
        nominal = Nominal.of({"kind": kind, "point": {"value": place, "tolerance": 0.02}})
        found = recognize(points, Config(kinds=(kind,), nominal=nominal)).conformance  # type: ignore[arg-type]
        assert found is not None
        (check,) = found.checks
        assert check.low == 0.0 and check.high is not None and check.high < most
        assert check.verdict == ("within" if most == 0.02 else "undecided")


def test_the_form_error_is_that_of_the_inliers() -> None:
    stray = np.vstack([PIPE, [[60.0, 0.0, 10.0]]])
    for tolerance, verdict in ((0.2, "within"), (0.05, "beyond")):
        found = _held(tolerance, stray)
        (form,) = found.checks
        assert form.name == "form" and form.verdict == found.verdict == verdict
        assert 3.0 * NOISE < form.deviation < 8.0 * NOISE


def test_the_worst_of_the_verdicts_counts() -> None:
    found = _held(0.2, radius={"value": 25.0, "tolerance": 1e-4})
    assert [check.verdict for check in found.checks] == ["within", "undecided"]
    assert found.verdict == "undecided"


def test_another_kind_is_beyond_any_tolerance() -> None:
    found = recognize(PIPE, Config(nominal=Nominal.of({"kind": "sphere", "radius": 25.0}))).conformance
    assert found == Conformance("beyond", None, ())
    blob = RNG.normal(size=(300, 3))
    assert recognize(blob, Config(form_tolerance=100.0)).conformance == Conformance("beyond", None, ())


def test_a_kind_of_an_ambiguous_answer_is_compared() -> None:
    rng = np.random.default_rng(1)
    pipe = Cylinder(np.array([0.0, 0.0, 1.0]), np.zeros(3), 100.0)
    strip = pipe.surface(rng.uniform(0.0, 0.1, 40), rng.uniform(0.0, 30.0, 40)) + rng.normal(
        0.0, 0.02, (40, 3)
    )
    nominal = Nominal.of({"kind": "cylinder", "radius": {"value": 100.0, "tolerance": 30.0}})
    answer = recognize(strip, Config(nominal=nominal))
    assert answer.status == "ambiguous" and answer.primitive and answer.primitive.kind == "plane"
    assert answer.conformance and answer.conformance.kind == "cylinder"
    (check,) = answer.conformance.checks
    (known,) = (each.uncertainty for each in answer.alternatives if each.primitive.kind == "cylinder")
    assert known is not None
    interval = known.intervals["radius"]
    assert check.low is not None and check.high is not None
    assert (100.0 + check.low, 100.0 + check.high) == pytest.approx((interval.low, interval.high))
    assert check.verdict == "undecided"


def test_a_primitive_of_an_answer_is_a_nominal_one() -> None:
    answer = recognize(PIPE)
    assert answer.primitive is not None
    again = recognize(PIPE, Config(nominal=Nominal.of(parameters(answer.primitive)))).conformance
    assert again is not None and again.verdict is None
    assert max(check.deviation for check in again.checks) < 1e-6


def test_what_was_asked_reads_back() -> None:
    for given in (
        {"kind": "cylinder", "radius": {"value": 5.0, "tolerance": 0.1}},
        {"kind": "cylinder", "radius": {"value": 5.0, "tolerance": [-0.1, 0.2]}},
        {"kind": "cylinder", "radius": {"value": 5.0, "tolerance": [0.0, 0.2]}},
        {"kind": "cylinder", "axis": {"value": [0.0, 0.0, 1.0], "tolerance": 0.1}},
        {"kind": "cylinder", "point": {"value": [0.0, 0.0, 1.0]}},
    ):
        assert Nominal.of(given).plain() == given
        assert Nominal.of(Nominal.of(given)) == Nominal.of(given)


@pytest.mark.parametrize(
    ("given", "field"),
    [
        (7, "nominal"),
        ({"radius": 5}, "nominal.kind"),
        ({"kind": "cone", "radius": 5}, "nominal"),
        ({"kind": "sphere", "radius": -5}, "nominal.radius"),
        ({"kind": "sphere", "radius": {"tolerance": 5}}, "nominal.radius"),
        ({"kind": "sphere", "radius": {"value": 5, "limits": 5}}, "nominal.radius"),
        ({"kind": "sphere", "radius": {"value": 5, "tolerance": -1}}, "nominal.radius.tolerance"),
        ({"kind": "sphere", "radius": {"value": 5, "tolerance": "0.1"}}, "nominal.radius.tolerance"),
        ({"kind": "sphere", "radius": {"value": 5, "tolerance": [1, -1]}}, "nominal.radius.tolerance"),
        ({"kind": "sphere", "center": {"value": [0, 0, 0], "tolerance": [0, 1]}}, "nominal.center.tolerance"),
        ({"kind": "plane", "normal": [0, 0, 0]}, "nominal.normal"),
    ],
)
def test_what_cannot_be_meant_is_named(given: Any, field: str) -> None:
    with pytest.raises(InvalidOptionError) as caught:
        Nominal.of(given)
    assert caught.value.field == field
    assert "'0'" not in str(caught.value)
