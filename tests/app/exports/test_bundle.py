"""One call, several artifacts: over HTTP as a ZIP, on the command line, in Python."""

import csv
import io
import json
import re
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from primfit.app.exports import FORMATS

NAMED = b"<div><dt>file</dt><dd>cylinder.csv</dd></div>"
"""What the report says where points came from a file: a plain body and arrays have no name."""

CSV = Path(__file__).parents[3] / "app" / "examples" / "cylinder.csv"


def _export(service: Any, content: bytes, media_type: str, **params: object) -> Any:
    headers = {"Content-Type": media_type}
    return service.client.post("/fit/export", content=content, headers=headers, params=params)


def test_a_zip_holds_the_answer_and_the_artifacts(service: Any) -> None:
    plain = service.post(CSV.read_bytes(), "text/csv", unit="m")
    response = _export(service, CSV.read_bytes(), "text/csv", artifacts=",".join(FORMATS), unit="m")
    assert response.status_code == 200, response.text
    assert response.headers["content-type"] == "application/zip"
    again = _export(service, CSV.read_bytes(), "text/csv", artifacts=list(FORMATS), unit="m")
    assert again.content == response.content
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        assert archive.testzip() is None
        assert archive.namelist() == ["answer.json", *(format.file_name for format in FORMATS.values())]
        assert archive.read("answer.json") == plain.content
        assert b"SI_UNIT($,.METRE.)" in archive.read("primitive.step")
        header, row = archive.read("primitive.csv").decode().splitlines()
    body, written = plain.json(), dict(zip(header.split(","), row.split(","), strict=True))
    assert written["kind"] == "cylinder" and written["status"] == "fitted"
    assert float(written["radius"]) == body["primitive"]["radius"]
    assert float(written["point_z"]) == body["primitive"]["point"][2]
    assert float(written["rms"]) == body["error"]["rms"]


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ({"artifacts": "step,dwg"}, "artifacts[1]"),
        ({"artifacts": ""}, "artifacts[0]"),
        ({"artifacts": "step", "unit": "furlong"}, "unit"),
        ({"artifacts": "step", "unit": ["m", "mm"]}, "unit"),
        ({"artifacts": "glb", "chord_error": "nan"}, "chord_error"),
        ({"artifacts": "glb", "chord_error": "fine"}, "chord_error"),
        ({"artifacts": "glb", "chord_error": "0"}, "chord_error"),
        ({"unit": "m"}, "artifacts"),
    ],
)
def test_bad_artifacts_are_named(service: Any, query: dict[str, Any], field: str) -> None:
    response = _export(service, CSV.read_bytes(), "text/csv", **query)
    assert response.status_code == 422
    assert response.json()["type"] == "urn:primfit:problem:invalid-options"
    assert [error["field"] for error in response.json()["errors"]] == [field]


def test_an_unknown_option_is_told_those_of_exports(service: Any) -> None:
    response = _export(service, CSV.read_bytes(), "text/csv", artifacts="step", units="m")
    (error,) = response.json()["errors"]
    assert error["field"] == "units" and error["message"].endswith(
        "artifacts, chord_error, export_kind, title, operator, date"
    )
    plain = service.client.post("/fit", content=CSV.read_bytes(), params={"units": "m"})
    assert plain.json()["errors"][0]["message"].endswith("unit")


def test_nothing_to_export_is_a_problem(service: Any) -> None:
    flat = np.random.default_rng(0).uniform(-1, 1, (100, 3)) * [1, 1, 0]
    request = json.dumps({"points": flat.tolist(), "options": {"kinds": ["torus"]}}).encode()
    response = _export(service, request, "application/json", artifacts="step", unit="mm")
    assert response.status_code == 422
    assert response.json()["type"] == "urn:primfit:problem:nothing-to-export"


def test_only_what_shrinks_is_packed(service: Any) -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(0, 1, (2000, 3))
    points *= rng.normal(1, 0.01, (2000, 1)) / np.linalg.norm(points, axis=1, keepdims=True)
    content = io.BytesIO()
    np.save(content, points)
    response = _export(service, content.getvalue(), "application/x-npy", artifacts="residuals_ply,csv,report")
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        assert archive.testzip() is None
        packing = {each.filename: each.compress_type for each in archive.infolist()}
        (ply,) = [each for each in archive.infolist() if each.filename.endswith(".ply")]
    assert packing.pop(ply.filename) == zipfile.ZIP_STORED
    assert packing["answer.json"] == zipfile.ZIP_DEFLATED
    assert len(packing) == 3


def _names(response: Any) -> tuple[list[str], list[dict[str, str]]]:
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        names = archive.namelist()
        return names, json.loads(archive.read("problems.json")) if "problems.json" in names else []


def test_what_cannot_be_made_leaves_the_others_alone(service: Any, tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    spindle = primfit.Torus([0, 0, 0], [0, 0, 1], 1.0, 2.0)
    points = spindle.surface(rng.uniform(0, 6.28, 2000), rng.uniform(-1.5, 1.5, 2000))
    request = json.dumps({"points": points.tolist(), "options": {"kinds": ["torus"], "unit": "mm"}}).encode()
    names, problems = _names(_export(service, request, "application/json", artifacts="step,csv"))
    assert names == ["answer.json", "primitive.csv", "problems.json"]
    assert [each["artifact"] for each in problems] == ["step"] and "major radius" in problems[0]["problem"]
    np.savetxt(tmp_path / "cloud.xyz", points)
    files = ("--step", tmp_path / "a.step", "--csv-row", tmp_path / "a.csv")
    words = ("fit", tmp_path / "cloud.xyz", "--kind", "torus", "--unit", "mm", *files)
    result = CliRunner().invoke(app, [str(word) for word in words])
    assert result.exit_code == 2 and "a.step: not written: " in result.stderr
    assert (tmp_path / "a.csv").exists() and not (tmp_path / "a.step").exists()


def test_any_kind_of_an_ambiguous_answer_is_exported(service: Any) -> None:
    rng = np.random.default_rng(1)
    pipe = primfit.Cylinder([0, 0, 1], [0, 0, 0], 100.0)
    strip = pipe.surface(rng.uniform(0.0, 0.1, 40), rng.uniform(0.0, 30.0, 40))
    strip += rng.normal(0.0, 0.02, strip.shape)
    found = primfit.fit(strip, unit="mm")
    assert found.status == "ambiguous"
    kinds = [each.kind for each in (found.primitive, *(other.primitive for other in found.alternatives))]  # type: ignore[union-attr]
    for kind in kinds:
        (row,) = csv.DictReader(primfit.export(found, "csv", export_kind=kind).decode().splitlines())
        (noise,) = (tried.noise for tried in found.attempts if tried.kind == kind)
        assert row["kind"] == kind and float(row["noise_scale"]) == noise.scale  # type: ignore[union-attr]
        page = primfit.export(found, "report", export_kind=kind).decode()
        others = [f"Alternative: {other}" for other in kinds if other != kind]
        assert re.findall("Alternative: [a-z]+", page) == others
        request = json.dumps({"points": strip.tolist()}).encode()
        response = _export(service, request, "application/json", artifacts="csv", export_kind=kind)
        with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
            assert f",{kind},".encode() in archive.read("primitive.csv")
    with pytest.raises(primfit.NothingToExportError, match="the answer holds no torus; it holds "):
        primfit.export(found, "csv", export_kind="torus")


def test_constraints_act_on_the_kind_that_is_exported(service: Any) -> None:
    rng = np.random.default_rng(1)
    pipe = primfit.Cylinder([0, 0, 1], [0, 0, 0], 100.0)
    strip = pipe.surface(rng.uniform(0.0, 0.1, 40), rng.uniform(0.0, 30.0, 40))
    strip += rng.normal(0.0, 0.02, strip.shape)
    given = {"radius": {"min": 50}, "normal": {"direction": [1, 0, 0], "max_angle": 1}}
    found = primfit.fit(strip, constraints=given)
    assert found.status == "ambiguous" and "bounds, not active" in found.active_constraints["radius"]
    page = found.export("report", export_kind="plane").decode()
    (table,) = re.findall("<h2>Constraints</h2>.*?</table>", page, re.S)
    assert "not applicable: a plane has no radius" in table and "largest angle, not active" in table
    request = {"points": strip.tolist(), "options": {"constraints": given}}
    response = _export(
        service, json.dumps(request).encode(), "application/json", artifacts="report", export_kind="plane"
    )
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        assert table.encode() in archive.read("report.html")


def test_an_stl_far_from_the_origin_is_about_an_origin_that_it_tells(service: Any) -> None:
    points = np.loadtxt(CSV, delimiter=",", skiprows=2) + np.array([500_000.0, 5_400_000.0, 0.0])
    request = json.dumps({"points": points.tolist()}).encode()
    response = _export(service, request, "application/json", artifacts="stl,obj")
    (said,) = _names(response)[1]
    assert said["artifact"] == "stl" and "less (500" in said["warning"]
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        content = archive.read("primitive.stl")
    with pytest.warns(UserWarning, match="STL holds float32, too coarse so far from the origin"):
        primfit.export(primfit.fit(points), "stl")
    with pytest.warns(
        UserWarning, match=r"GLB .* its mesh is about \(500\d\d\d, 5399\d\d\d, \d+ mm\), where"
    ):
        primfit.export(primfit.fit(points, unit="mm"), "glb")
    origin = [float(word) for word in content[:80].decode().partition(" about ")[2].split()]
    corners = np.frombuffer(content[84:], np.dtype([("n", "<f4", 3), ("c", "<f4", (3, 3)), ("a", "<u2")]))[
        "c"
    ]
    found = primfit.fit(points).primitive
    assert found is not None
    assert np.abs(found.signed_distance(corners.reshape(-1, 3) + origin)).max() < 1e-4


def test_the_command_line_and_python_write_the_same_bytes(service: Any, tmp_path: Path) -> None:
    flags = {name: f"--{name.replace('_', '-')}" for name in FORMATS}
    flags |= {"ply": "--ply-mesh", "csv": "--csv-row"}
    words = [word for name, flag in flags.items() for word in (flag, str(tmp_path / name))]
    result = CliRunner().invoke(app, ["fit", "--json", "--unit", "inch", str(CSV), *words])
    assert result.exit_code == 0, result.stderr
    response = _export(service, CSV.read_bytes(), "text/csv", artifacts=",".join(FORMATS), unit="inch")
    points = np.loadtxt(CSV, delimiter=",", skiprows=2)
    exported = primfit.export(primfit.fit(points, unit="inch"), list(FORMATS), points, options={})
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        for name, format in FORMATS.items():
            written = (tmp_path / name).read_bytes()
            assert archive.read(format.file_name) == written.replace(NAMED, b"")
            assert exported[name].replace(b"<code>array: ", b"<code>text: ") == written.replace(NAMED, b"")


def test_the_command_line_says_what_it_cannot_write(tmp_path: Path) -> None:
    def complaint(*words: object) -> str:
        result = CliRunner().invoke(app, ["fit", *map(str, words)])
        assert result.exit_code == 2
        return result.stderr

    assert "of one FILE, not of 2" in complaint(CSV, CSV, "--step", tmp_path / "a")
    assert "not of the segments" in complaint(CSV, "--labels", "auto", "--step", tmp_path / "a")
    assert "--chord-error: " in complaint(CSV, "--glb", tmp_path / "a", "--chord-error", "2")
    assert "cannot be written: " in complaint(CSV, "--glb", tmp_path / "missing" / "a")
    np.savetxt(tmp_path / "flat.csv", np.random.default_rng(0).uniform(-1, 1, (100, 3)) * [1, 1, 0])
    assert "not written: " in complaint(
        tmp_path / "flat.csv", "--kind", "torus", "--unit", "mm", "--step", tmp_path / "a"
    )


def test_the_command_line_overwrites_neither_its_input_nor_another_export(tmp_path: Path) -> None:
    cloud, link, other, wanted = (tmp_path / name for name in ("cloud.csv", "link", "other", "wanted"))
    cloud.write_bytes(CSV.read_bytes())
    link.symlink_to(cloud)
    other.hardlink_to(cloud)
    for words, lost in (
        *(([flag, name], "the input") for name in (cloud, link, other) for flag in ("--report", "--csv-row")),
        (["--step", wanted, "--glb", wanted], "the export step"),
    ):
        result = CliRunner().invoke(app, ["fit", str(cloud), *map(str, words)])
        assert result.exit_code == 2 and not result.stdout
        assert f"would overwrite {lost}" in result.stderr
    assert cloud.read_bytes() == CSV.read_bytes() and not wanted.exists()


def test_two_exports_are_not_written_to_one_file_by_its_two_names(tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_bytes(b"as before")
    two.hardlink_to(one)
    result = CliRunner().invoke(app, ["fit", str(CSV), "--csv-row", str(one), "--form", str(two)])
    assert result.exit_code == 2 and "would overwrite the export csv" in result.stderr
    assert one.read_bytes() == b"as before"


def test_unknown_formats_are_refused() -> None:
    recognition = primfit.fit(np.loadtxt(CSV, delimiter=",", skiprows=2))
    with pytest.raises(primfit.InvalidOptionError, match=r"allowed are step, .*report"):
        primfit.export(recognition, "dwg")


def test_bad_options_are_named_with_what_was_found() -> None:
    points = np.loadtxt(CSV, delimiter=",", skiprows=2)
    recognition = primfit.fit(points)
    for said, wanted in (
        ("unit is 'yd'; allowed are um, mm, cm, m, ", {"unit": "yd"}),
        ("chord_error is 2; it is a share", {"chord_error": 2}),
        ("chord_error is 'fine', not a number", {"chord_error": "fine"}),
        ("options holds 'kindz'; allowed are kinds, ", {"options": {"kindz": ["plane"]}}),
    ):
        with pytest.raises(primfit.InvalidOptionError, match=said):
            primfit.export(recognition, "report", points, **wanted)
