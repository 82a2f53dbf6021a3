"""Constraints, an initial guess and weights by every way in: the same answer, and mistakes named."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from primfit.app.cli import commands as cli
from primfit.app.cli.constraint_flags import parse_constraints
from primfit.app.engine.fit import InvalidOptionError, fit
from primfit.app.wire.schemas import FitAnswer
from primfit.fitting.primitives.cylinder import Cylinder

EXAMPLES = Path(__file__).parents[2] / "app" / "examples"
SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
CONSTRAINTS = {
    "radius": {"max": 12.4},
    "axis": {"direction": [1.0, 2.0, 2.0], "max_angle": 0.1},
    "half_angle": {"min": 0.1, "max": 0.5},
}
FLAGS = ["radius=..12.4", "axis=1,2,2@0.1", "half_angle=0.1..0.5"]
GUESS = {"kind": "cylinder", "axis": [1.0, 2.0, 2.0], "point": [40.0, -14.0, 120.0], "radius": 12.0}
OPTIONS = {"kinds": ["cylinder", "cone"], "constraints": CONSTRAINTS, "initial_guess": GUESS}


def test_service_command_line_and_python_agree(
    service: Any, tmp_path: Path, capsysbinary: pytest.CaptureFixture[bytes]
) -> None:
    response = service.client.post("/fit", json={**SMALL, "options": OPTIONS})
    body = response.json()
    FitAnswer.model_validate(body, strict=True)
    assert body["primitive"]["radius"] == 12.4
    assert body["active_constraints"] == {
        "radius": "at its upper bound 12.4",
        "axis": "largest angle, not active",
        "half_angle": "not applicable: a cylinder has no half-angle",
    }
    used = body["receipt"]["options"]
    assert used["constraints"] == CONSTRAINTS
    assert used["initial_guess"]["kind"] == "cylinder"
    assert used["initial_guess"]["axis"] == pytest.approx([1 / 3, 2 / 3, 2 / 3])
    expected = fit(SMALL["points"], **OPTIONS).primitive
    assert isinstance(expected, Cylinder)
    assert body["primitive"]["axis"] == expected.axis.tolist()

    (tmp_path / "cloud.json").write_text(json.dumps(SMALL))
    command = ["fit", str(tmp_path / "cloud.json"), "--json", "--kind", "cylinder", "--kind", "cone"]
    command += [part for flag in FLAGS for part in ("--constraint", flag)]
    command += ["--initial-guess", json.dumps(GUESS)]
    with pytest.raises(SystemExit):
        cli.app(command)
    assert capsysbinary.readouterr().out.rstrip(b"\n") == response.content


def test_people_see_how_a_constraint_acts(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.app(
            ["fit", str(EXAMPLES / "cylinder.csv"), "--kind", "cylinder", "--constraint", "radius=..12.4"]
        )
    assert "radius: at its upper bound 12.4" in capsys.readouterr().out


@pytest.mark.parametrize("name", ["weights", "standard_deviations"])
def test_weights_stand_beside_the_points(service: Any, name: str) -> None:
    values = np.random.default_rng(0).uniform(0.5, 2.0, len(SMALL["points"])).tolist()
    body = service.client.post("/fit", json={**SMALL, name: values}).json()
    FitAnswer.model_validate(body, strict=True)
    plain = service.client.post("/fit", json=SMALL).json()
    expected = fit(SMALL["points"], **{name: values}).primitive  # type: ignore[arg-type]
    assert isinstance(expected, Cylinder)
    assert body["primitive"]["radius"] == expected.radius != plain["primitive"]["radius"]
    assert body["receipt"]["columns"] == ["x", "y", "z", name]
    assert len(body["receipt"]["weights_sha256"]) == 64
    assert plain["receipt"]["weights_sha256"] is None


@pytest.mark.parametrize(("weights", "field"), [([1.0], "weights"), ("1", "weights"), ([True], "weights[0]")])
def test_bad_weights_are_named(service: Any, weights: Any, field: str) -> None:
    response = service.client.post("/fit", json={**SMALL, "weights": weights})
    assert response.status_code == 422
    assert response.json()["type"].endswith("invalid-points")
    assert response.json()["errors"][0]["field"] == field


@pytest.mark.parametrize(
    ("constraints", "field"),
    [
        ({"radius": {"value": -1}}, ".radius.value"),
        ({"radius": {"value": "5"}}, ".radius.value"),
        ({"radius": {"low": 1}}, ".radius.low"),
        ({"radius": {"min": 2, "max": 1}}, ".radius"),
        ({"axis": {"direction": [0, 0, 0]}}, ".axis.direction"),
        ({"apex": [0, 0, 0]}, ".apex"),
        ({"tip": [0, 0, 0]}, ".tip"),
    ],
)
def test_bad_constraints_are_named(service: Any, constraints: Any, field: str) -> None:
    options = {"constraints": constraints, "kinds": ["plane", "cylinder"]}
    response = service.client.post("/fit", json={**SMALL, "options": options})
    assert response.status_code == 422
    assert response.json()["type"].endswith("invalid-options")
    assert response.json()["errors"][0]["field"] == f"options.constraints{field}"


@pytest.mark.parametrize(
    ("guess", "field"),
    [
        ({"kind": "egg"}, ""),
        ({"radius": 2}, ""),
        (5, ""),
        ({**GUESS, "radius": -2}, ".radius"),
        ({**GUESS, "point": [0, 0]}, ".point"),
        ({**GUESS, "r": 2}, ".r"),
    ],
)
def test_bad_guesses_are_named(service: Any, guess: Any, field: str) -> None:
    response = service.client.post("/fit", json={**SMALL, "options": {"initial_guess": guess}})
    assert response.status_code == 422
    assert response.json()["errors"][0]["field"] == f"options.initial_guess{field}"
    assert "egg" not in response.text


def test_mistakes_are_told_in_words_of_json(service: Any) -> None:
    options = {"constraints": {"radius": 5, "tip": [0, 0, 0]}}
    body = service.client.post("/fit", json={**SMALL, "options": options}).json()
    assert body["errors"] == [
        {"field": "options.constraints.radius", "message": "an object is needed", "value": "number"},
        {"field": "options.constraints.tip", "message": "unknown field", "value": "array of 3"},
    ]
    assert body["detail"] == "2 mistakes, the first: options.constraints.radius: an object is needed"


def test_an_object_in_a_query_is_refused(service: Any) -> None:
    response = service.post(b"0,0,0\n1,0,0\n0,1,0\n", "text/csv", constraints='{"radius": {"value": 5}}')
    assert response.status_code == 422
    assert response.json()["errors"][0] == {
        "field": "constraints",
        "message": "an object does not fit into a query; give it in JSON",
    }


def test_flags_say_what_json_says() -> None:
    assert parse_constraints([*FLAGS, "center=1,-2,3e2", "minor_radius=5", "normal=0,0,1"]) == {
        **CONSTRAINTS,
        "center": [1.0, -2.0, 300.0],
        "minor_radius": {"value": 5.0},
        "normal": {"direction": [0.0, 0.0, 1.0]},
    }


@pytest.mark.parametrize(
    "flags", [["radius"], ["radius=a"], ["radius=1", "radius=2"], ["center=1,2,x"], ["axis=0,0,1@"]]
)
def test_flags_that_cannot_be_read(flags: list[str]) -> None:
    with pytest.raises(InvalidOptionError, match="constraint"):
        parse_constraints(flags)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--constraint", "tip=1,2,3"], "--constraint: constraints holds 'tip'"),
        (["--constraint", "radius=6..4"], "min 6 over the max 4"),
        (["--kind", "cone", "--constraint", "radius=5"], "--constraint: constraints.radius is given"),
        (
            ["--kind", "cone", "--criterion", "maximum_inscribed"],
            "--kind: criterion maximum_inscribed is",
        ),
        (["--initial-guess", "{"], "--initial-guess: not valid JSON at character "),
    ],
)
def test_bad_flags_end_with_status_2(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as caught:
        cli.app(["fit", str(EXAMPLES / "cylinder.csv"), *arguments])
    assert caught.value.code == 2
    assert said in capsys.readouterr().err


def test_a_weight_that_is_no_number_is_a_bad_point(service: Any) -> None:
    body = '{"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "weights": [1, NaN, 1]}'
    response = service.client.post("/fit", content=body, headers={"Content-Type": "application/json"})
    assert response.json()["type"].endswith("invalid-points")
    assert response.json()["errors"][0]["field"] == "weights[1]"
