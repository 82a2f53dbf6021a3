"""`columns`, `missing` and `unit` through REST, batches, the command line and Python: the same everywhere."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from tests.app.serving import Service
from tests.fitting.clouds import EXAMPLES, noisy

POINTS = noisy(EXAMPLES["cylinder"], 200, 0.01)
TABLE = np.column_stack([np.full(200, 7.0), POINTS])
TABLE[[5, 9], 2] = np.nan
CSV = b"kind,A,B,H\n" + b"\n".join(b",".join(b"%.17g" % cell for cell in row) for row in TABLE.tolist())
KEPT = np.delete(POINTS, [5, 9], axis=0)
OPTIONS = {"columns": ["A", "B", "H"], "unit": "mm"}
WARNING = "Missing points were dropped: 2 with coordinates that are not finite."


def _run(*args: object) -> Any:
    return CliRunner().invoke(app, [str(arg) for arg in args])


def _check(answer: dict[str, Any]) -> None:
    receipt = answer["receipt"]
    assert receipt["n_points"] == 198 and receipt["columns"] == ["A", "B", "H"]
    assert receipt["dropped"] == {"not_finite": 2, "zero": 0}
    assert (receipt["unit"], receipt["unit_from"]) == ("mm", "option")
    assert answer["warnings"] == [WARNING]
    expected = primfit.fit(KEPT).to_dict()
    assert answer["primitive"] == expected["primitive"] and answer["error"] == expected["error"]
    assert " mm about the cylinder" in answer["message"]


def test_the_service_takes_them_in_the_query_and_beside_a_file(service: Service) -> None:
    upload = {"file": ("a.csv", CSV), "options": (None, json.dumps(OPTIONS), "application/json")}
    for response in (
        service.post(CSV, "text/csv", columns="A,B,H", unit="mm"),
        service.post(CSV, "text/csv", columns=["A", "B", "H"], unit="mm"),
        service.client.post("/fit", files=upload),
    ):
        assert response.status_code == 200, response.text
        _check(response.json())
    first, _ = service.client.post("/fit/batch", files=upload).text.splitlines()
    _check(json.loads(first)["answer"])


def test_the_command_line_takes_them(tmp_path: Path) -> None:
    file = tmp_path / "cloud.csv"
    file.write_bytes(CSV)
    words = ("--columns", "A,B,H", "--unit", "mm")
    _check(json.loads(_run("fit", "--json", *words, file).stdout))
    shown = _run("fit", *words, file).stdout
    assert WARNING in shown and "in mm" in shown
    assert _run("batch", *words, "--workers", 1, "--out", tmp_path / "out", file).exit_code == 0
    _check(json.loads((tmp_path / "out" / "cloud.json").read_bytes()))


def test_python_takes_them(tmp_path: Path) -> None:
    file = tmp_path / "cloud.csv"
    file.write_bytes(CSV)
    found = primfit.fit(file, columns="A,B,H", unit="mm")
    assert found.unit == "mm" and found.warnings == (WARNING,)
    for other in (
        primfit.fit(str(file), columns=[2, 3, 4], unit="mm"),
        primfit.fit(TABLE, columns=[2, 3, 4], unit="mm"),
        primfit.fit(TABLE[:, 1:], unit="mm"),
    ):
        assert other.to_json() == found.to_json()
    assert np.isnan(found.residuals).sum() == 2 and found.residuals.shape == found.inliers.shape == (200,)
    assert not found.inliers[[5, 9]].any()
    (segment,) = primfit.fit_segments(TABLE[:, 1:], np.zeros(200, int), unit="mm")
    assert segment.recognition is not None and segment.recognition.to_json() == found.to_json()


def test_missing_points_are_refused_by_their_places_where_that_is_asked_for(
    service: Service, tmp_path: Path
) -> None:
    response = service.post(CSV, "text/csv", columns="A,B,H", missing="error")
    assert response.status_code == 422
    assert [error["field"] for error in response.json()["errors"]] == ["points[5][1]", "points[9][1]"]
    (tmp_path / "cloud.csv").write_bytes(CSV)
    result = _run("fit", "--columns", "A,B,H", "--missing", "error", tmp_path / "cloud.csv")
    assert result.exit_code == 2 and "points[5][1]: 2 coordinates are NaN or infinite" in result.stderr
    with pytest.raises(primfit.InvalidPointCloudError, match="2 coordinates are NaN"):
        primfit.fit(TABLE[:, 1:], missing="error")


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ({"columns": "A,B"}, "columns"),
        ({"columns": "A,B,H,kind"}, "options.columns"),
        ({"columns": "A,B,B"}, "options.columns"),
        ({"columns": "A,B,Z"}, "columns"),
        ({"missing": "keep"}, "missing"),
        ({"unit": "furlong"}, "unit"),
        ({}, "header"),
    ],
)
def test_what_cannot_be_meant_is_named(service: Service, query: dict[str, Any], field: str) -> None:
    response = service.post(CSV, "text/csv", **query)
    assert response.status_code == 422
    assert response.json()["errors"][0]["field"] == field


def test_json_holds_missing_points_and_options(service: Service) -> None:
    rows = np.where(np.isfinite(TABLE[:, 1:]), TABLE[:, 1:], None).tolist()
    body = {"points": rows, "options": {"unit": "mm"}}
    answer = service.client.post("/fit", json=body).json()
    assert answer["receipt"]["dropped"]["not_finite"] == 2 and answer["receipt"]["unit"] == "mm"
    body["options"] = {"missing": "error"}
    assert service.client.post("/fit", json=body).json()["errors"][0]["field"] == "points[5][1]"
    text = json.dumps({"points": TABLE[:, 1:].tolist()})
    assert "NaN" in text
    again = service.client.post("/fit", content=text, headers={"Content-Type": "application/json"}).json()
    assert again["primitive"] == answer["primitive"]


def test_a_unit_against_that_of_the_file_brings_a_warning(service: Service) -> None:
    text = b"X [m],Y [m],Z [m]\n" + b"\n".join(b"%.17g,%.17g,%.17g" % tuple(row) for row in POINTS.tolist())
    told = service.post(text, "text/csv").json()
    assert (told["receipt"]["unit"], told["receipt"]["unit_from"], told["warnings"]) == ("m", "header", [])
    other = service.post(text, "text/csv", unit="mm").json()
    assert other["receipt"]["unit_from"] == "option"
    assert other["warnings"] == ["The file is in m by its header, but mm was asked for."]
    assert other["primitive"] == told["primitive"]


def test_what_was_read_is_fitted_and_cut_by_its_labels(tmp_path: Path) -> None:
    file = tmp_path / "cloud.csv"
    rows = [f"{x!r},{y!r},{z!r},{part}" for (x, y, z), part in zip(POINTS.tolist(), "ab" * 100, strict=True)]
    file.write_text("X [cm],Y [cm],Z [cm],part\n" + "\n".join(rows))
    cloud = primfit.read(file, labels="part")
    assert cloud == primfit.read(str(file), columns="X,Y [cm],3", labels="part")
    with pytest.raises(primfit.InvalidOptionError, match=r"was read already: give them to primfit\.read"):
        primfit.fit(cloud, columns="X,Y [cm],3")
    assert (
        primfit.fit(cloud).to_json()
        == primfit.fit(file).to_json()
        == primfit.fit(POINTS, unit="cm").to_json()
    )
    segments = primfit.fit_segments(cloud)
    assert [(each.label, len(each.rows)) for each in segments] == [("a", 100), ("b", 100)]
    assert segments[0].recognition == primfit.fit(POINTS[::2], unit="cm")
    assert segments.export("step").count(b"SI_UNIT(.CENTI.,.METRE.)") >= 1
    with pytest.raises(primfit.InvalidPointCloudError, match="labels are missing"):
        primfit.fit_segments(primfit.read(file))


def test_coarse_coordinates_bring_a_warning() -> None:
    far = (POINTS * 50.0 + [5e5, 5.4e6, 0.0]).astype(np.float32)
    (warning,) = primfit.fit(far, unit="m").warnings
    assert warning.startswith("The coordinates are float32 numbers in steps of 0.500 m: store float64")
    assert primfit.fit(far.astype(np.float64) + 0.1).warnings == ()


def test_options_in_a_file_and_in_the_call_do_not_disagree_in_silence(
    service: Service, tmp_path: Path
) -> None:
    file = tmp_path / "cloud.json"
    file.write_text(json.dumps({"points": POINTS.tolist(), "options": {"unit": "mm", "seed": 3}}))
    assert primfit.fit(file).unit == "mm" and primfit.fit(file, tolerance=0.01).unit == "mm"
    for given in ({"unit": "m"}, {"seed": 4}):
        ((name, value),) = given.items()
        with pytest.raises(primfit.InvalidOptionError, match="in the file; keep one") as caught:
            primfit.fit(file, **given)
        assert caught.value.field == name
        result = _run("fit", f"--{name}", value, file)
        assert result.exit_code == 2 and "given in two places; keep one" in result.stderr
        response = service.client.post(f"/fit?{name}={value}", files={"file": ("a.json", file.read_bytes())})
        assert response.status_code == 422
        assert response.json()["errors"][0]["field"] == f"options.{name}"


def test_the_report_of_a_file_says_which_it_is(tmp_path: Path) -> None:
    file = tmp_path / "pipe 7.csv"
    file.write_bytes(CSV)
    found = primfit.fit(file, columns="A,B,H")
    page = found.export("report").decode()
    assert "<code>text: A B H</code>" in page and "<dd>pipe 7.csv</dd>" in page
    page = primfit.export(found, "report", KEPT).decode()
    assert "<code>array: x y z</code>" in page and "pipe 7.csv" not in page
