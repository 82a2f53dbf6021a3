"""`tolerance` through REST, batches, the command line and Python: used, in the receipt, refused if bad."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from tests.app.serving import EXAMPLES, Service
from tests.fitting.clouds import EXAMPLES as PRIMITIVES
from tests.fitting.clouds import Array, noisy

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
BAD = [0.0, -0.5, 1e101]
LENGTHS = ("rms", "mean", "p95", "max", "zone", "inlier_rms")


def _run(*args: object) -> Any:
    return CliRunner().invoke(app, [str(arg) for arg in args])


def _used(answer: dict[str, Any]) -> float | None:
    return answer["receipt"]["options"]["tolerance"]  # type: ignore[no-any-return]


def test_the_service_takes_it_in_the_query_the_body_and_beside_a_file(service: Service) -> None:
    upload = {"file": ("a.csv", CSV), "options": (None, b'{"tolerance": 0.25}', "application/json")}
    for response in (
        service.post(CSV, "text/csv", tolerance=0.25),
        service.client.post("/fit", json={**SMALL, "options": {"tolerance": 0.25}}),
        service.client.post("/fit", files=upload),
    ):
        assert response.status_code == 200, response.text
        assert _used(response.json()) == 0.25
    lines = service.client.post("/fit/batch", files=upload).text.splitlines()
    assert _used(json.loads(lines[0])["answer"]) == 0.25
    assert _used(service.post(CSV, "text/csv").json()) is None


def test_another_tolerance_is_another_question(service: Service) -> None:
    tags = {service.post(CSV, "text/csv", tolerance=value).headers["etag"] for value in (0.1, 0.1, 0.2)}
    assert len(tags) == 2


def test_the_command_line_takes_it(tmp_path: Path) -> None:
    file = EXAMPLES / "cylinder.csv"
    assert _used(json.loads(_run("fit", "--json", "--tolerance", 0.25, file).stdout)) == 0.25
    assert _run("batch", "--tolerance", 0.25, "--workers", 1, "--out", tmp_path, file).exit_code == 0
    assert _used(json.loads((tmp_path / "cylinder.json").read_bytes())) == 0.25


def test_python_takes_it() -> None:
    points = noisy(PRIMITIVES["cylinder"], 200, 0.01)
    expected = primfit.fit(points, tolerance=0.05).to_json()
    fitter = primfit.PrimitiveFitter(tolerance=0.05)
    assert fitter.get_params()["tolerance"] == 0.05
    assert fitter.fit(points).recognition_.to_json() == expected
    assert primfit.recognize(points, primfit.Config(tolerance=0.05)).primitive is not None
    (segment,) = primfit.fit_segments(points, np.zeros(200, int), tolerance=0.05)
    assert segment.recognition is not None and segment.recognition.to_json() == expected
    report = primfit.export(segment.recognition, "report", points, options={"tolerance": 0.05}).decode()
    assert "<code>0.05</code>" in report


@pytest.mark.parametrize("value", BAD)
def test_the_service_refuses_with_the_field_the_value_and_the_limit(service: Service, value: float) -> None:
    limit = "at most 1e+100" if value > 0.0 else "greater than 0"
    for field, response in (
        ("tolerance", service.post(CSV, "text/csv", tolerance=value)),
        ("options.tolerance", service.client.post("/fit", json={**SMALL, "options": {"tolerance": value}})),
        ("tolerance", service.client.post("/fit/batch", files={"file": CSV}, params={"tolerance": value})),
    ):
        assert response.status_code == 422
        assert response.json()["type"] == "urn:primfit:problem:invalid-options"
        (error,) = response.json()["errors"]
        assert error["field"] == field
        assert error["message"] == f"tolerance is {value:g}; it must be {limit}"


@pytest.mark.parametrize("value", ["nan", "inf", "1e999", "1 mm", ""])
def test_what_is_no_length_is_refused_in_a_query(service: Service, value: str) -> None:
    response = service.post(CSV, "text/csv", tolerance=value)
    assert response.status_code == 422
    assert response.json()["errors"][0]["field"] == "tolerance"


@pytest.mark.parametrize("value", ["0.1", True, [0.1], {"mm": 0.1}])
def test_what_is_no_number_is_refused_in_json(service: Service, value: object) -> None:
    response = service.client.post("/fit", json={**SMALL, "options": {"tolerance": value}})
    assert response.status_code == 422
    assert response.json()["errors"][0]["field"] == "options.tolerance"


@pytest.mark.parametrize("value", [*BAD, float("nan"), float("inf")])
def test_the_command_line_refuses_before_any_file_is_read(value: float, tmp_path: Path) -> None:
    said = f"primfit: --tolerance: tolerance is {value:g}; it must be positive and at most 1e+100\n"
    for command in (["fit"], ["batch", "--out", tmp_path]):
        result = _run(*command, "--tolerance", value, tmp_path / "missing.csv")
        assert (result.exit_code, result.stdout, result.stderr) == (2, "", said)


@pytest.mark.parametrize("value", [*BAD, float("nan"), "0.1", True])
def test_python_refuses(value: Any) -> None:
    points = noisy(PRIMITIVES["plane"], 50, 0.01)
    for call in (
        lambda: primfit.fit(points, tolerance=value),
        lambda: primfit.PrimitiveFitter(tolerance=value).fit(points),
        lambda: primfit.fit_segments(points, np.zeros(50, int), tolerance=value),
        lambda: primfit.Config(tolerance=value),
    ):
        with pytest.raises(primfit.InvalidOptionError, match="tolerance is ") as caught:
            call()
        assert caught.value.field == "tolerance"


def test_the_service_tells_its_range(service: Service) -> None:
    options = {option["name"]: option for option in service.client.get("/capabilities").json()["options"]}
    told = options["tolerance"]
    assert (told["type"], told["exclusive_minimum"], told["maximum"]) == ("number", 0, 1e100)
    assert told["default"] is None


def _wavy(points: Array) -> Array:
    """A cylinder whose radius swells and shrinks by two noise scales along its axis."""
    cylinder = PRIMITIVES["cylinder"]
    along = (points - cylinder.point) @ cylinder.axis  # type: ignore[union-attr]
    return points + 0.02 * np.sin(4.0 * along)[:, None] * cylinder.gradient(points)


def _lengths(answer: dict[str, Any]) -> dict[str, float | None]:
    """Every length of the new fields and beside them, by name; None where a deviation was not found."""
    noise = answer["noise"]
    found = {name: answer["error"][name] for name in LENGTHS} | {"scale": noise["scale"]}
    found["radius"] = answer["primitive"]["radius"]
    for name in ("correlated", "smooth"):
        for of in ("size", "range"):
            found[f"{name} {of}"] = None if noise[name] is None else noise[name][of]
    return found


def test_lengths_are_in_the_unit_of_the_input() -> None:
    meters = _wavy(noisy(PRIMITIVES["cylinder"], 600, 0.01))
    options: dict[str, Any] = {"kinds": ["cylinder"], "criterion": "least_squares"}
    small = primfit.fit(meters, tolerance=0.05, **options).to_dict()
    large = primfit.fit(1000.0 * meters, tolerance=50.0, **options).to_dict()
    assert small["status"] == large["status"]
    for name, value in _lengths(small).items():
        scaled = _lengths(large)[name]
        assert (value is None) == (scaled is None), name
        if value is not None:
            assert scaled == pytest.approx(1000.0 * value, rel=1e-6), name
    assert [attempt["evidence"] for attempt in small["attempts"]] == pytest.approx(
        [attempt["evidence"] for attempt in large["attempts"]], abs=1e-6
    )
