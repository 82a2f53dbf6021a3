"""What a report says of itself comes from the query, from flags and from the name of the file."""

import io
import zipfile
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from primfit.app.cli.commands import app

CSV = Path(__file__).parents[3] / "app" / "examples" / "cylinder.csv"
GIVEN = {"title": "Bore 3", "operator": "A. Example", "date": "29.11.2026"}
ABOUT = "".join(
    f"<div><dt>{name}</dt><dd>{text}</dd></div>"
    for name, text in (("file", "bore 3.csv"), ("date", GIVEN["date"]), ("operator", GIVEN["operator"]))
)


def _report(archive: bytes) -> str:
    with zipfile.ZipFile(io.BytesIO(archive)) as files:
        return files.read("report.html").decode()


def test_the_query_gives_them_and_the_upload_its_name(service: Any) -> None:
    upload = {"file": (r"C:\scans\bore 3.csv", CSV.read_bytes(), "text/csv")}
    response = service.client.post("/fit/export", params={"artifacts": "report", **GIVEN}, files=upload)
    assert response.status_code == 200, response.text
    report = _report(response.content)
    assert "<h1>Bore 3<" in report and ABOUT in report
    response = service.client.post("/fit/export", params={"artifacts": "report"}, content=CSV.read_bytes())
    report = _report(response.content)
    assert "<h1>Cylinder<" in report and "<dt>file" not in report and "<dt>date" not in report


@pytest.mark.parametrize(
    ("query", "told"),
    [
        ([("title", "x" * 201)], "title is 201 characters long; at most 200 are allowed"),
        ([("operator", "a\tb")], "operator holds line breaks or other characters that cannot be printed"),
        ([("date", "today"), ("date", "today")], "given more than once"),
    ],
)
def test_bad_ones_are_named(service: Any, query: list[tuple[str, str]], told: str) -> None:
    params = [("artifacts", "report"), *query]
    response = service.client.post("/fit/export", params=params, content=CSV.read_bytes())
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert (error["field"], error["message"]) == (query[0][0], told)


def test_flags_give_them_and_the_file_its_name(tmp_path: Path) -> None:
    scan, report = tmp_path / "bore 3.csv", tmp_path / "report.html"
    scan.write_bytes(CSV.read_bytes())
    flags = [word for name, text in GIVEN.items() for word in (f"--{name}", text)]
    result = CliRunner().invoke(app, ["fit", str(scan), "--report", str(report), *flags])
    assert result.exit_code == 0, result.stderr
    content = report.read_text()
    assert "<h1>Bore 3<" in content and ABOUT in content and str(tmp_path) not in content
    result = CliRunner().invoke(app, ["fit", "-", "--report", str(report)], input=CSV.read_bytes())
    assert result.exit_code == 0 and "<dt>file" not in report.read_text()
    result = CliRunner().invoke(app, ["fit", str(scan), "--report", str(report), "--title", "x" * 201])
    assert result.exit_code == 2 and "--title: title is 201 characters long" in result.stderr
