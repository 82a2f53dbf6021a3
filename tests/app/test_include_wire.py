"""`include` by every way in: what is not asked for is null, the rest is the same, and the receipt says it."""

import io
import json
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import primfit
from primfit.app.cli.commands import app
from primfit.fitting.names import ANSWER_PARTS
from tests.app.serving import EXAMPLES, Service
from tests.fitting.clouds import EXAMPLES as PRIMITIVES
from tests.fitting.clouds import noisy

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
SUBSETS: list[list[str]] = [[], ["extents"], ["uncertainty"], [*ANSWER_PARTS]]
REFUSED = "include names uncertainty; STEP files and meshes need extents, where the primitive ends"


def _run(*args: object) -> Any:
    return CliRunner().invoke(app, [str(arg) for arg in args])


def _flags(include: Iterable[str]) -> list[str]:
    return [text for part in list(include) or ["none"] for text in ("--include", part)]


def _reduced(answer: dict[str, Any], include: list[str]) -> dict[str, Any]:
    """A whole answer as it should be with these parts only."""
    without = dict.fromkeys(set(ANSWER_PARTS) - set(include))
    reduced = answer | without | {"alternatives": [other | without for other in answer["alternatives"]]}
    if without and "receipt" in answer:
        options = answer["receipt"]["options"] | {"include": include}
        reduced["receipt"] = answer["receipt"] | {"options": options}
    return reduced


@pytest.mark.parametrize("include", SUBSETS)
def test_the_service_takes_it_in_the_query_the_body_and_beside_a_file(
    service: Service, include: list[str]
) -> None:
    expected = _reduced(service.post(CSV, "text/csv").json(), include)
    options = json.dumps({"include": include}).encode()
    upload = {"file": ("a.csv", CSV), "options": (None, options, "application/json")}
    assert service.post(CSV, "text/csv", include=include or "").json() == expected
    assert service.client.post("/fit", files=upload).json() == expected
    lines = service.client.post("/fit/batch", files=upload).text.splitlines()
    assert json.loads(lines[0])["answer"] == expected
    in_json = service.client.post("/fit", json={**SMALL, "options": {"include": include}}).json()
    assert in_json == _reduced(service.client.post("/fit", json=SMALL).json(), include)


def test_all_parts_named_are_the_answer_without_the_option(service: Service) -> None:
    plain, named = service.post(CSV, "text/csv"), service.post(CSV, "text/csv", include=ANSWER_PARTS[::-1])
    assert named.content == plain.content and named.headers["etag"] == plain.headers["etag"]
    assert "include" not in plain.json()["receipt"]["options"]


def test_other_parts_are_another_question(service: Service) -> None:
    asked: list[Any] = ["", "extents", "uncertainty", ANSWER_PARTS]
    assert len({service.post(CSV, "text/csv", include=parts).headers["etag"] for parts in asked}) == 4


@pytest.mark.parametrize("include", SUBSETS)
def test_the_command_line_takes_it(tmp_path: Path, include: list[str]) -> None:
    file, flags = EXAMPLES / "cylinder.csv", _flags(include)
    expected = _reduced(json.loads(_run("fit", "--json", file).stdout), include)
    assert json.loads(_run("fit", "--json", *flags, file).stdout) == expected
    assert _run("batch", *flags, "--workers", 1, "--out", tmp_path, file).exit_code == 0
    assert json.loads((tmp_path / "cylinder.json").read_bytes()) == expected


@pytest.mark.parametrize("kind", sorted(PRIMITIVES))
@pytest.mark.parametrize("include", SUBSETS)
def test_what_is_left_out_changes_nothing_else(kind: str, include: Any) -> None:
    """The warnings of an uncertainty that is told without extents count the arcs of these all the same."""
    points = noisy(PRIMITIVES[kind], 300, 0.01)
    whole, part = primfit.fit(points), primfit.fit(points, include=include)
    assert part.to_dict() == _reduced(whole.to_dict(), include)
    assert part.include == tuple(include)
    assert repr(part) == repr(whole) and "kind" in str(part)


def test_python_takes_it_everywhere() -> None:
    points = noisy(PRIMITIVES["cylinder"], 200, 0.01)
    expected = primfit.fit(points, include=["extents"]).to_json()
    fitter = primfit.PrimitiveFitter(include=["extents"])
    assert fitter.get_params()["include"] == ["extents"]
    assert fitter.fit(points).recognition_.to_json() == expected
    assert primfit.recognize(points, primfit.Config(include=("extents",))).uncertainty is None
    (segment,) = primfit.fit_segments(points, np.zeros(200, int), include=["extents"])
    assert segment.recognition is not None and segment.recognition.to_json() == expected


def test_the_service_refuses_what_is_no_part(service: Service) -> None:
    said = "Input should be 'extents' or 'uncertainty'"
    in_json = {**SMALL, "options": {"include": ["noise"]}}
    for field, response in (
        ("include[0]", service.post(CSV, "text/csv", include="extent")),
        (
            "options.include[0]",
            service.client.post("/fit", json=in_json),
        ),
        ("include[1]", service.post(CSV, "text/csv", include=["extents", ""])),
    ):
        assert response.status_code == 422
        assert response.json()["type"] == "urn:primfit:problem:invalid-options"
        (error,) = response.json()["errors"]
        assert (error["field"], error["message"]) == (field, said)
    twice = service.post(CSV, "text/csv", include=["extents", "extents"])
    assert twice.status_code == 422 and "the same part twice" in twice.json()["detail"]


@pytest.mark.parametrize(
    ("include", "said"),
    [
        (["extent"], "include holds 'extent'; allowed are extents, uncertainty"),
        ("extents", "include must be a sequence of names out of extents, uncertainty"),
        (7, "include must be a sequence of names out of extents, uncertainty"),
        ({"extents": 1}, "include must be a sequence of names out of extents, uncertainty"),
        (["extents", "extents"], "include names the same part twice"),
    ],
)
def test_python_refuses(include: Any, said: str) -> None:
    points = noisy(PRIMITIVES["plane"], 50, 0.01)
    for call in (
        lambda: primfit.fit(points, include=include),
        lambda: primfit.fit_segments(points, np.zeros(50, int), include=include),
        lambda: primfit.Config(include=include),
    ):
        with pytest.raises(primfit.InvalidOptionError) as caught:
            call()
        assert (str(caught.value), caught.value.field) == (said, "include")


def test_the_command_line_refuses_before_any_file_is_read(tmp_path: Path) -> None:
    for parts, said in (
        (("none", "extents"), "include names none beside a part"),
        (("extents", "none", "none"), "include names none beside a part"),
        (("extents", "extents"), "include names the same part twice"),
        (("none", "none"), "include names none twice"),
    ):
        result = _run("fit", *_flags(parts), tmp_path / "missing.csv")
        assert (result.exit_code, result.stdout) == (2, "")
        assert result.stderr == f"primfit: --include: {said}\n"
    assert _run("fit", "--include", "extent", tmp_path / "missing.csv").exit_code == 2


@pytest.mark.parametrize("format", ["step", "glb", "obj", "stl", "ply"])
def test_an_artifact_of_extents_is_refused_before_the_fit(service: Service, format: str) -> None:
    def export(content: bytes) -> Any:
        params = {"artifacts": f"csv,{format}", "include": "uncertainty"}
        return service.client.post("/fit/export", content=content, params=params)

    response = export(CSV)
    assert response.status_code == 422
    assert response.json()["type"] == "urn:primfit:problem:invalid-options"
    assert response.json()["errors"] == [{"field": "options.include", "message": REFUSED}]
    # Three collinear points cannot be fitted: the complaint about them would come later.
    assert export(b"0,0,0\n1,1,1\n2,2,2\n").json()["errors"][0]["message"] == REFUSED


def test_other_artifacts_need_neither_part(service: Service) -> None:
    params = {"artifacts": "csv,shrec22,residuals_npy,form,report", "include": ""}
    response = service.client.post("/fit/export", content=CSV, params=params)
    assert response.status_code == 200
    with zipfile.ZipFile(io.BytesIO(response.content)) as archive:
        report = archive.read("report.html").decode()
        assert json.loads(archive.read("answer.json"))["receipt"]["options"]["include"] == []
    assert "The uncertainty was not requested." in report
    assert "extents were not requested" in report


def test_exports_of_the_command_line_and_of_python_are_refused(tmp_path: Path) -> None:
    file, out = EXAMPLES / "cylinder.csv", tmp_path / "part.step"
    result = _run("fit", "--include", "uncertainty", "--step", out, file)
    assert (result.exit_code, result.stderr) == (2, f"primfit: --include: {REFUSED}\n")
    asking = tmp_path / "asking.json"
    asking.write_text(json.dumps({**SMALL, "options": {"include": ["uncertainty"]}}))
    result = _run("fit", "--step", out, asking)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"primfit: {asking}: {REFUSED}\n")
    assert _run("fit", "--form", tmp_path / "form.json", asking).exit_code == 0
    assert not out.exists()
    points = noisy(PRIMITIVES["cylinder"], 200, 0.01)
    recognition = primfit.fit(points, include=["uncertainty"])
    with pytest.raises(primfit.InvalidOptionError) as caught:
        primfit.export(recognition, ["csv", "step"], points)
    assert (str(caught.value), caught.value.field) == (REFUSED, "include")
    report = primfit.export(recognition, "report", points, options={"include": ["uncertainty"]}).decode()
    assert "extents were not requested" in report and "The uncertainty was not" not in report
