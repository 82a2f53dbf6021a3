"""The files in `readers/inputs`, through the command line, the service and Python."""

import json
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from tests.app.serving import Service
from tests.paths import ROOT

INPUTS = ROOT / "tests" / "app" / "readers" / "inputs"
EXPECTED: dict[str, dict[str, Any]] = json.loads((INPUTS / "expected.json").read_bytes())
RADIUS, AXIS = 1e-3, 2e-3
"""How exactly a radius (relative) and the components of an axis are told."""


def test_every_file_has_its_expectation() -> None:
    assert {path.name for path in INPUTS.iterdir()} == {*EXPECTED, "expected.json", "README.md"}
    assert len(EXPECTED) == 27


def _check(answer: dict[str, Any], expected: dict[str, Any]) -> None:
    found, receipt = answer["primitive"], answer["receipt"]
    kinds = {found["kind"], *(other["kind"] for other in answer["alternatives"])}
    if "accept" in expected:
        kind = found["kind"] if answer["status"] == "fitted" else answer["status"]
        assert kind in expected["accept"] and (kind != "ambiguous" or "cone" in kinds)
        return
    assert answer["status"] == "fitted" or (answer["status"] == "ambiguous" and "axis" not in expected)
    assert found["kind"] == expected["kind"]
    assert found["radius"] == pytest.approx(expected["radius"], rel=RADIUS)
    if "axis" in expected:
        assert abs(np.dot(found["axis"], expected["axis"])) == pytest.approx(1.0, abs=AXIS)
    assert receipt["n_points"] == expected.get("n_points", receipt["n_points"])
    assert sum(receipt["dropped"].values()) or not expected.get("dropped")


def _words(expected: dict[str, Any]) -> list[str]:
    assert "or_refused" in expected or "refused" in expected.get("accept", ())
    return [*expected.get("or_refused", ()), *expected.get("words", ())]


@pytest.mark.parametrize("name", EXPECTED)
def test_a_file_as_a_program_writes_it_is_read_or_told_what_is_wrong(service: Service, name: str) -> None:
    data, expected = (INPUTS / name).read_bytes(), EXPECTED[name]
    response = service.post(data, "application/octet-stream")
    result = CliRunner().invoke(app, ["fit", "--json", str(INPUTS / name)])
    if response.status_code == 422:
        for told in (response.json()["detail"], result.stderr):
            assert any(word in told for word in _words(expected))
        assert result.exit_code == 2
        with pytest.raises(ValueError, match="|".join(_words(expected))):
            primfit.fit(INPUTS / name)
        return
    assert response.status_code == 200
    _check(response.json(), expected)
    assert json.loads(result.stdout) == response.json()
    assert primfit.fit(INPUTS / name).to_dict().items() <= response.json().items()
