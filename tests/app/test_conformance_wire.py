"""`nominal` and `form_tolerance` through REST, batches, the command line, Python, and on what is printed."""

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from tests.app.serving import EXAMPLES, Service
from tests.fitting.clouds import EXAMPLES as PRIMITIVES
from tests.fitting.clouds import noisy

FILE = EXAMPLES / "cylinder.csv"
CSV = FILE.read_bytes()
NOMINAL = {"kind": "cylinder", "radius": {"value": 12.5, "tolerance": 0.05}}
OPTIONS = {"nominal": NOMINAL, "form_tolerance": 0.01}


def _run(*args: object) -> Any:
    return CliRunner().invoke(app, [str(arg) for arg in args])


def _check(answer: dict[str, Any]) -> None:
    found = answer["conformance"]
    assert (found["verdict"], found["kind"]) == ("beyond", "cylinder")
    form, radius = found["checks"]
    assert (form["name"], form["verdict"], form["upper"]) == ("form", "beyond", 0.01)
    assert form["measured"] == answer["error"]["inlier_zone"]
    assert (radius["name"], radius["verdict"]) == ("radius", "within")
    assert radius["deviation"] == answer["primitive"]["radius"] - 12.5
    used = answer["receipt"]["options"]
    assert used["nominal"] == NOMINAL and used["form_tolerance"] == 0.01


def test_the_service_takes_them_in_the_body_and_beside_a_file(service: Service) -> None:
    upload = {"file": ("a.csv", CSV), "options": (None, json.dumps(OPTIONS), "application/json")}
    points = json.loads((EXAMPLES / "request.json").read_bytes())["points"]
    for response in (
        service.client.post("/fit", files=upload),
        service.client.post("/fit", json={"points": points, "options": OPTIONS}),
    ):
        assert response.status_code == 200, response.text
        _check(response.json())
    first, _ = service.client.post("/fit/batch", files=upload).text.splitlines()
    _check(json.loads(first)["answer"])
    alone = service.post(CSV, "text/csv", form_tolerance=1.0).json()
    assert alone["conformance"]["verdict"] == "within"
    plain = service.post(CSV, "text/csv").json()
    assert plain["conformance"] is None and "nominal" not in plain["receipt"]["options"]


def test_the_command_line_takes_them_and_prints_the_verdict(tmp_path: Path) -> None:
    words = ("--nominal", json.dumps(NOMINAL), "--form-tolerance", "0.01")
    _check(json.loads(_run("fit", "--json", *words, FILE).stdout))
    shown = _run("fit", *words, "--unit", "mm", FILE).stdout
    assert "verdict          beyond tolerance" in shown
    assert "allowed up to 0.01 mm: beyond" in shown and "allowed ± 0.05 mm: within" in shown
    assert _run("batch", *words, "--workers", 1, "--out", tmp_path, FILE).exit_code == 0
    _check(json.loads((tmp_path / "cylinder.json").read_bytes()))


def test_python_takes_them() -> None:
    found = primfit.fit(FILE, nominal=NOMINAL, form_tolerance=0.01)
    assert found.conformance is not None and found.conformance.verdict == "beyond"
    assert "verdict" in str(found)


@pytest.mark.parametrize(
    ("options", "field"),
    [
        ({"nominal": {"radius": 5}}, "options.nominal.kind"),
        ({"nominal": {"kind": "plane", "radius": 5}}, "options.nominal"),
        ({"nominal": 5}, "options.nominal"),
        ({"form_tolerance": 0}, "options.form_tolerance"),
    ],
)
def test_what_cannot_be_meant_is_named(service: Service, options: dict[str, Any], field: str) -> None:
    points = noisy(PRIMITIVES["cylinder"], 50, 0.01).tolist()
    response = service.client.post("/fit", json={"points": points, "options": options})
    assert response.status_code == 422
    assert response.json()["type"] == "urn:primfit:problem:invalid-options"
    assert response.json()["errors"][0]["field"] == field
