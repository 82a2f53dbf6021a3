"""The service over HTTP: the same answer by every way in, problem documents, and the OpenAPI document."""

import base64
import gzip
import io
import json
from collections.abc import Callable
from typing import Any

import httpx
import numpy as np
import pytest
import zstandard

from primfit.app.engine.answer import answer, to_json
from primfit.app.engine.fit import fit
from primfit.app.readers import read
from primfit.app.service.media_types import MEDIA_TYPES
from primfit.app.wire.schemas import FitAnswer, KindName, Problem
from primfit.fitting.names import KINDS
from tests.paths import EXAMPLES

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
REQUEST = (EXAMPLES / "request.json").read_bytes()
SMALL = json.loads(REQUEST)


def _npy(points: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points)
    return stream.getvalue()


def _encoded(points: np.ndarray) -> dict[str, Any]:
    encoded = base64.b64encode(points.astype("<f8").tobytes()).decode()
    return {"dtype": "float64", "shape": list(points.shape), "base64": encoded}


def _problem(response: httpx.Response, status: int, slug: str) -> dict[str, Any]:
    assert response.status_code == status, response.text
    assert response.headers["content-type"] == "application/problem+json"
    assert len(response.content) <= 24 * 1024
    problem = response.json()
    Problem.model_validate(problem, strict=True)
    assert problem["status"] == status
    assert problem["type"] == f"urn:primfit:problem:{slug}"
    assert problem["instance"] == f"/requests/{response.headers['x-request-id']}"
    return problem


def test_every_way_in_gives_the_same_numbers(service: Any, cylinder: np.ndarray) -> None:
    ways = {
        "csv": service.post(CSV, "text/csv"),
        "npy": service.post(_npy(cylinder), "application/x-npy"),
        "json": service.client.post("/fit", json={"points": cylinder.tolist()}),
        "base64": service.client.post("/fit", json={"points": _encoded(cylinder)}),
        "upload": service.client.post("/fit", files={"file": ("cloud.csv", CSV)}),
        "upload of npy": service.client.post("/fit", files={"file": ("cloud.csv", _npy(cylinder))}),
    }
    answers = {name: response.json() for name, response in ways.items()}
    for response in ways.values():
        assert response.status_code == 200, response.text
        FitAnswer.model_validate(response.json(), strict=True)
    for name, body in answers.items():
        receipt = body.pop("receipt")
        assert receipt["n_points"] == 300
        assert receipt["columns"] == ["x", "y", "z"]
        formats = {"csv": "text", "upload": "text", "json": "json", "base64": "json"}
        assert receipt["format"] == formats.get(name, "npy")
        assert body == answers["csv"]
    expected = fit(cylinder)
    assert answers["csv"]["primitive"]["kind"] == "cylinder"
    assert answers["csv"]["primitive"]["radius"] == expected.primitive.radius  # type: ignore[union-attr]


def test_the_body_is_the_one_of_the_library_byte_for_byte_on_every_worker(service: Any) -> None:
    cloud = read(CSV)
    options = {"kinds": ["cylinder", "cone"], "seed": 5}
    expected = to_json(answer(fit(cloud.points, **options), cloud, options))  # type: ignore[arg-type]
    bodies = {service.post(CSV, "text/csv", **options).content for _ in range(5)}
    assert bodies == {expected}


@pytest.mark.parametrize("where", ["query", "body", "upload"])
def test_options_act_wherever_they_stand(service: Any, where: str) -> None:
    options = {"kinds": ["sphere", "plane"], "classifier": "none", "criterion": "least_squares"}
    options |= {"max_error": 0.25, "tolerance": 0.5, "seed": 12}
    if where == "query":
        response = service.post(CSV, "text/csv", **options)
    elif where == "body":
        response = service.client.post("/fit", json={**SMALL, "options": options})
    else:
        files = {"file": ("a", CSV), "options": (None, json.dumps(options).encode(), "application/json")}
        response = service.client.post("/fit", files=files)
    assert response.status_code == 200, response.text
    assert response.json()["receipt"]["options"] == options | {"constraints": None, "initial_guess": None}
    assert {attempt["kind"] for attempt in response.json()["attempts"]} <= {"sphere", "plane"}


def test_a_sphere_asked_of_a_cylinder_is_no_fit(service: Any) -> None:
    response = service.post(CSV, "text/csv", kinds=["sphere"])
    assert response.json()["status"] == "no_fit"
    FitAnswer.model_validate(response.json(), strict=True)


BAD_OPTIONS: dict[str, tuple[dict[str, Any], str]] = {
    "unknown name": ({"kind": ["plane"]}, "options.kind"),
    "unknown kind": ({"kinds": ["plane", "cube"]}, "options.kinds[1]"),
    "no kinds": ({"kinds": []}, "options.kinds"),
    "a kind twice": ({"kinds": ["plane", "plane"]}, "options.kinds"),
    "many kinds": ({"kinds": ["plane"] * 100_000}, "options"),
    "kinds as string": ({"kinds": "plane"}, "options.kinds"),
    "kinds of numbers": ({"kinds": [1]}, "options.kinds[0]"),
    "unknown classifier": ({"classifier": "oracle"}, "options.classifier"),
    "classifier as null": ({"classifier": None}, "options.classifier"),
    "unknown criterion": ({"criterion": "l1"}, "options.criterion"),
    "no kind of the criterion": ({"kinds": ["cone"], "criterion": "maximum_inscribed"}, "options.kinds"),
    "max_error zero": ({"max_error": 0}, "options.max_error"),
    "max_error above one": ({"max_error": 1.5}, "options.max_error"),
    "max_error as string": ({"max_error": "0.1"}, "options.max_error"),
    "max_error as boolean": ({"max_error": True}, "options.max_error"),
    "tolerance zero": ({"tolerance": 0}, "options.tolerance"),
    "tolerance negative": ({"tolerance": -1.0}, "options.tolerance"),
    "tolerance beyond all lengths": ({"tolerance": 1e101}, "options.tolerance"),
    "tolerance as string": ({"tolerance": "0.1 mm"}, "options.tolerance"),
    "seed negative": ({"seed": -1}, "options.seed"),
    "seed beyond 64 bits": ({"seed": 2**63}, "options.seed"),
    "seed with a fraction": ({"seed": 1.5}, "options.seed"),
    "long name": ({"x" * 10_000: 1}, "options." + "x" * 72),
}


@pytest.mark.parametrize(("options", "field"), BAD_OPTIONS.values(), ids=BAD_OPTIONS)
def test_bad_options_are_named(service: Any, options: dict[str, Any], field: str) -> None:
    response = service.client.post("/fit", json={**SMALL, "options": options})
    problem = _problem(response, 422, "invalid-options")
    assert [error["field"] for error in problem["errors"]] == [field]


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("kind=plane", "kind"),
        ("kinds=cube", "kinds[0]"),
        ("seed=one", "seed"),
        ("seed=1&seed=2", "seed"),
        ("max_error=nan", "max_error"),
        ("tolerance=nan", "tolerance"),
        ("tolerance=1&tolerance=2", "tolerance"),
        (f"seed={'1' * 400}", "seed"),
        (f"seed={'1' * 5000}", "seed"),
    ],
)
def test_bad_options_in_the_query_are_named(service: Any, query: str, field: str) -> None:
    response = service.client.post(f"/fit?{query}", content=CSV, headers={"Content-Type": "text/csv"})
    assert _problem(response, 422, "invalid-options")["errors"][0]["field"] == field


def test_an_option_in_two_places_is_refused(service: Any) -> None:
    response = service.client.post("/fit?seed=1", json={**SMALL, "options": {"seed": 2}})
    assert _problem(response, 422, "invalid-options")["errors"][0]["field"] == "options.seed"


def test_a_file_of_json_may_hold_options(service: Any) -> None:
    body = json.dumps({**SMALL, "options": {"seed": 9}}).encode()
    raw = service.post(body, "application/octet-stream", kinds=["sphere"])
    assert raw.json()["receipt"]["options"]["seed"] == 9
    assert raw.json()["receipt"]["options"]["kinds"] == ["sphere"]
    files = {"file": ("a.json", body), "options": (None, b'{"seed": 9}', "application/json")}
    problem = _problem(service.client.post("/fit", files=files), 422, "invalid-options")
    assert problem["errors"] == [{"field": "options.seed", "message": "given in two places; keep one"}]


def test_every_bad_option_is_counted(service: Any) -> None:
    options = {f"option{i}": i for i in range(100)}
    problem = _problem(
        service.client.post("/fit", json={**SMALL, "options": options}), 422, "invalid-options"
    )
    assert "100" in problem["detail"] and len(problem["errors"]) == 20


def test_unknown_options_are_told_what_is_allowed(service: Any) -> None:
    response = service.client.post("/fit", json={**SMALL, "options": {"color": 1}})
    message = _problem(response, 422, "invalid-options")["errors"][0]["message"]
    assert "kinds, classifier, criterion, max_error, tolerance, seed" in message


CLOUDS: dict[str, list[list[float]]] = {
    "no points": [],
    "one point": [[1, 2, 3]],
    "two points": [[1, 2, 3], [4, 5, 6]],
    "identical": [[1, 2, 3]] * 50,
    "collinear": [[i, 2 * i, 3 * i] for i in range(50)],
}


@pytest.mark.parametrize("points", CLOUDS.values(), ids=CLOUDS)
def test_what_cannot_be_a_cloud_is_refused(service: Any, points: list[list[float]]) -> None:
    problem = _problem(service.client.post("/fit", json={"points": points}), 422, "invalid-points")
    assert problem["errors"][0]["field"] == "points"


HOSTILE = {
    "NaN": (b'{"points": [[1, 2, NaN]]}', "application/json", "points"),
    "1e400": (b'{"points": [[1e400, 2, 3]]}', "application/json", "points[0][0]"),
    "nan as string": (b'{"points": [["nan", 2, 3]]}', "application/json", "points[0][0]"),
    "nan in csv": (b"1,2,3\nnan,2,3\n", "text/csv", "points"),
    "depth": (b"[" * 100_000, "application/json", "body"),
    "100,000 bad rows": (b'{"points": [' + b",".join([b'["s3cret", 1]'] * 100_000) + b"]}",
                         "application/json", "points[0]"),
    "100,000 bad lines": (b"1,2,3\n" + b"1,s3cret,3\n" * 100_000, "text/csv", "line 2, column 2"),
    "a long string": (b'{"points": "' + b"s3cret" * 100_000 + b'"}', "application/json", "points"),
    "a long key": (b'{"' + b"s3cret" * 100_000 + b'": 1}', "application/json", "s3cret" * 6 + "s3cr"),
    "a long header": (b"x,y," + b"s3cret" * 10_000 + b"\n1,2,3\n", "text/csv", "header"),
    "garbage": (bytes(range(256)) * 100, "application/octet-stream", "file"),
    "empty": (b"", "text/csv", "file"),
    "multipart without boundary": (b"--x\r\n", "multipart/form-data", "Content-Type"),
    "multipart cut": (b'--x\r\nContent-Disposition: form-data; name="file"\r\n\r\n1 2',
                      "multipart/form-data; boundary=x", "body"),
    "multipart that is none": (b"1,2,3", "multipart/form-data; boundary=x", "body"),
    "multipart empty": (b"--x--\r\n", "multipart/form-data; boundary=x", "file"),
}  # fmt: skip


@pytest.mark.parametrize(("body", "media_type", "field"), HOSTILE.values(), ids=HOSTILE)
def test_hostile_bodies_get_a_small_answer_that_names_the_field(
    service: Any, body: bytes, media_type: str, field: str
) -> None:
    response = service.post(body, media_type)
    assert response.status_code == 422
    problem = _problem(response, 422, response.json()["type"].rpartition(":")[2])
    assert problem["errors"][0]["field"] == field
    assert len(problem["errors"]) <= 20
    if "key" not in field and not field.startswith("s3cret"):
        assert b"s3cret" not in response.content
    assert service.client.post("/fit", json=SMALL).status_code == 200


@pytest.mark.parametrize(
    ("files", "field"),
    [
        ({"cloud": ("a.csv", CSV)}, "cloud"),
        ({"options": (None, b"{}")}, "file"),
        ({"file": ("a.csv", CSV), "options": (None, b"{")}, "options"),
        ({"file": ("a.csv", CSV), "options": (None, b"[1]")}, "options"),
        ({"file": ("a.csv", CSV), "options": (None, b" " * 70_000)}, "options"),
        ([("file", ("a.csv", CSV)), ("file", ("b.csv", CSV))], "file"),
    ],
    ids=["other part", "no file", "no json", "no object", "long options", "file twice"],
)
def test_bad_uploads_are_named(service: Any, files: Any, field: str) -> None:
    response = service.client.post("/fit", files=files)
    assert _problem(response, 422, "unreadable-input")["errors"][0]["field"] == field


@pytest.mark.parametrize("name", ["../../etc/passwd", "a" * 300, "a\0b.ply", "cloud.ply", ""])
def test_the_name_of_an_upload_does_not_matter(service: Any, name: str) -> None:
    body = b'--x\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n' % name.encode()
    response = service.post(body + CSV + b"\r\n--x--\r\n", "multipart/form-data; boundary=x")
    if "\0" in name and response.status_code == 422:
        return
    assert response.json()["primitive"]["kind"] == "cylinder"


@pytest.mark.parametrize("media_type", ["image/png", "nonsense"])
def test_other_media_types_are_refused(service: Any, media_type: str) -> None:
    problem = _problem(service.post(CSV, media_type), 415, "unsupported-media-type")
    assert problem["detail"].endswith(MEDIA_TYPES[-1])
    assert "accept-encoding" not in service.post(CSV, media_type).headers  # RFC 9110, 12.5.3


@pytest.mark.parametrize("coding", ["br", "deflate", "gzip, gzip", "gzip;q=1"])
def test_other_content_encodings_are_refused_and_those_that_are_read_named(service: Any, coding: str) -> None:
    headers = {"Content-Type": "text/csv", "Content-Encoding": coding}
    response = service.client.post("/fit", content=CSV, headers=headers)
    _problem(response, 415, "unsupported-media-type")
    assert response.headers["accept-encoding"] == "gzip, zstd"


@pytest.mark.parametrize("coding", ["gzip", "X-GZIP", "zstd", "identity", "identity, gzip"])
def test_a_body_may_be_packed(service: Any, coding: str) -> None:
    pack = {"zstd": zstandard.compress, "identity": bytes}.get(coding, gzip.compress)
    upload = b'--x\r\nContent-Disposition: form-data; name="file"\r\n\r\n' + CSV + b"\r\n--x--\r\n"
    bodies = {"text/csv": CSV, "multipart/form-data; boundary=x": upload, "application/json": REQUEST}
    for media_type, body in bodies.items():
        plain = service.post(body, media_type)
        headers = {"Content-Type": media_type, "Content-Encoding": coding}
        packed = service.client.post("/fit", content=pack(body), headers=headers)
        assert packed.status_code == 200, packed.text
        assert packed.content == plain.content


@pytest.mark.parametrize("pack", [gzip.compress, zstandard.compress])
def test_a_file_may_be_packed(service: Any, pack: Callable[[bytes], bytes]) -> None:
    plain = service.post(CSV, "text/csv").content
    assert service.post(pack(CSV), "application/octet-stream").content == plain
    assert service.client.post("/fit", files={"file": ("cloud.csv.gz", pack(CSV))}).content == plain


@pytest.mark.parametrize("media_type", MEDIA_TYPES[2:])
def test_every_raw_media_type_is_read_by_content(service: Any, media_type: str) -> None:
    assert service.post(CSV, media_type).status_code == 200


def test_other_paths_and_methods_are_problems(service: Any) -> None:
    _problem(service.client.get("/nothing/here"), 404, "not-found")
    _problem(service.client.post("/fit/", json=SMALL), 404, "not-found")
    refused = service.client.get("/fit")
    _problem(refused, 405, "method-not-allowed")
    assert refused.headers["allow"] == "OPTIONS, POST"


def test_health_and_versions(service: Any) -> None:
    assert service.client.get("/livez").json() == {"status": "alive"}
    assert service.client.get("/readyz").json() == {"status": "ready", "workers": 2}
    versions = service.client.get("/version").json()
    assert versions == service.client.post("/fit", json=SMALL).json()["receipt"]["versions"]
    assert len(versions["weights"]) == 64


def test_times_and_ids_travel_in_headers_only(service: Any) -> None:
    first = service.client.post("/fit", json=SMALL, headers={"X-Request-Id": "my-id_7"})
    assert first.headers["x-request-id"] == "my-id_7"
    names = [item.partition(";")[0] for item in first.headers["server-timing"].split(", ")]
    assert names == ["receive", "read", "fit", "encode", "total"]
    other = service.client.post("/fit", json=SMALL, headers={"X-Request-Id": "<script>"})
    assert "<" not in other.headers["x-request-id"]
    assert first.content == other.content


def test_the_docs_page_needs_nothing_from_elsewhere(service: Any) -> None:
    page = service.client.get("/docs")
    assert page.headers["content-type"].startswith("text/html")
    # The name of SVG looks like an address.
    assert "http" not in page.text.replace("http://www.w3.org/2000/svg", "")
    assert "openapi.json" in page.text


def test_the_document_has_real_examples_for_every_body_answer_and_problem(service: Any) -> None:
    document = service.client.get("/openapi.json").json()
    assert document["openapi"].startswith("3.1")
    operations = {op["operationId"]: op for path in document["paths"].values() for op in path.values()}
    assert set(operations) == {
        "capabilities",
        "dismiss_job",
        "fit",
        "fit_batch",
        "fit_export",
        "job_events",
        "job_results",
        "job_status",
        "list_jobs",
        "livez",
        "metrics",
        "readyz",
        "submit_job",
        "version",
    }
    content = operations["fit"]["requestBody"]["content"]
    assert tuple(content) == MEDIA_TYPES
    examples = content["application/json"]["examples"]
    response = service.client.post("/fit", json=examples["cylinder"]["value"])
    assert service.client.post("/fit", json=examples["cylinder_in_base64"]["value"]).text == response.text
    answers = operations["fit"]["responses"]["200"]["content"]["application/json"]
    shown = answers["examples"]["cylinder"]["value"]
    FitAnswer.model_validate(shown, strict=True)
    assert response.json()["receipt"]["input_sha256"] == shown["receipt"]["input_sha256"]
    for status, described in operations["fit"]["responses"].items():
        if status != "200":
            media = described["content"]["application/problem+json"]
            assert media["schema"] == {"$ref": "#/components/schemas/Problem"}
            for example in media["examples"].values():
                assert str(Problem.model_validate(example["value"], strict=True).status) == status


def test_every_reference_of_the_document_is_there(service: Any) -> None:
    text = service.client.get("/openapi.json").text
    components = json.loads(text)["components"]
    for part in text.split('"$ref":"#/components/')[1:]:
        group, _, name = part.partition('"')[0].partition("/")
        assert name in components[group]
    assert text.count('"$ref":"') == text.count('"$ref":"#/components/')


def test_the_wire_names_the_kinds_that_there_are() -> None:
    assert KindName.__value__.__args__ == KINDS
