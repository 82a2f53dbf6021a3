"""`POST /fit/batch` against a real service: order, the bytes of `POST /fit`, failures that cost one item."""

import gzip
import io
import json
import os
import re
import shlex
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from primfit.app.wire.schemas import BatchAnswer, BatchProblem, BatchSummary
from tests.app.processes import needs_proc, ticks
from tests.app.service.scans import csv, many
from tests.app.serving import PATIENCE, Service, running, wait_for, workers
from tests.paths import DOCS, EXAMPLES, ROOT

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
SAME_ID = {"X-Request-Id": "batch-1"}
ROWS = np.loadtxt(EXAMPLES / "cylinder.csv", delimiter=",", skiprows=2)


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with one worker and room for seven items in a batch."""
    with running(tmp_path_factory.mktemp("bodies"), workers=1, max_batch_items=7) as started:
        yield started


@pytest.fixture(scope="module")
def hurried(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with one worker, five seconds for an item and one for a client that takes nothing."""
    times = {"fit_time_limit": 5.0, "send_timeout": 1.0}
    with running(tmp_path_factory.mktemp("bodies"), workers=1, queue_size=1, **times) as started:
        yield started


def _npy(array: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


def _big(n_points: int = 2_000_000) -> bytes:
    """A cloud whose minimum zone takes seconds."""
    rng = np.random.default_rng(1)
    angle, height = rng.uniform(0, 5, (2, n_points))
    radius = rng.normal(1.0, 0.01, n_points)
    return _npy(np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height]).astype(np.float32))


def _post(service: Service, *files: tuple[str, bytes], **more: Any) -> list[dict[str, Any]]:
    """The lines of the answer, each held against its model."""
    parts = [("file", file) for file in files]
    response = service.client.post("/fit/batch", files=parts, headers=SAME_ID, **more)
    return _lines(response)


def _lines(response: httpx.Response) -> list[dict[str, Any]]:
    assert response.status_code == 200, response.text
    assert response.headers["content-type"] == "application/x-ndjson"
    lines = [json.loads(line) for line in response.content.splitlines()]
    for line in lines:
        _check(line)
    assert lines[-1]["summary"]["items"] == len(lines) - 1
    return lines


def _check(line: dict[str, Any]) -> None:
    for model, name in ((BatchAnswer, "answer"), (BatchProblem, "problem"), (BatchSummary, "summary")):
        if name in line:
            model.model_validate(line, strict=True)
            return
    pytest.fail(f"a line of no sort: {line}")


def _is_clean(service: Service) -> bool:
    return not list(service.temporary_directory.iterdir())


def test_each_item_is_answered_in_order_as_fit_would(service: Service) -> None:
    other = ROWS * 2.0 + 1.0
    labeled = csv(np.vstack([other, ROWS, ROWS[:2]]), ["wall b"] * 300 + ["wall a"] * 300 + ["crumb"] * 2)
    files = [("part.csv", CSV), ("words.txt", b"no cloud\n"), ("scan.csv", labeled), ("part.csv", CSV)]
    options = {"kinds": ["cylinder", "cone"], "seed": 5}
    parts = [("file", file) for file in files] + [("options", (None, json.dumps(options).encode()))]
    response = service.client.post("/fit/batch", files=parts, headers=SAME_ID)
    lines = response.content.splitlines()
    heads = [
        ("part.csv", "part.csv", None),
        ("words.txt", "words.txt", None),
        ("scan.csv#crumb", "scan.csv", "crumb"),
        ("scan.csv#wall a", "scan.csv", "wall a"),
        ("scan.csv#wall b", "scan.csv", "wall b"),
        ("part.csv~2", "part.csv", None),
    ]
    alone = [CSV, b"no cloud\n", csv(ROWS[:2]), csv(ROWS), csv(other), CSV]
    for line, (item, file, label), body in zip(lines, heads, alone, strict=False):
        said = service.client.post(
            "/fit", content=body, params=options, headers=SAME_ID | {"Content-Type": "text/csv"}
        )
        head = json.dumps({"id": item, "file": file, "label": label}, separators=(",", ":")).encode()
        name = b"answer" if said.status_code == 200 else b"problem"
        assert line == head[:-1] + b',"' + name + b'":' + said.content + b"}"
    counts = {"items": 6, "fitted": 4, "ambiguous": 0, "no_fit": 0, "problems": 2}
    assert json.loads(lines[-1]) == {"summary": counts} and len(lines) == 7
    _lines(response)
    wait_for(lambda: _is_clean(service))


def test_normals_go_with_their_segment(service: Service) -> None:
    names = [(name, "f8") for name in ("x", "y", "z", "nx", "ny", "nz")]
    rng = np.random.default_rng(4)
    angle, height = rng.uniform(0, 5, 400), rng.uniform(-1, 1, 400)
    normals = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    points = 2 * normals + [0, 0, 1] * height[:, None]
    table = np.zeros(400, [*names, ("segment", "i4")])
    for i, (name, _) in enumerate(names):
        table[name] = np.hstack([points, 3 * normals])[:, i]
    table["segment"] = rng.integers(-1, 2, 400)
    answers = _post(service, ("scan.npy", _npy(table)))[:-1]
    assert [line["label"] for line in answers] == [-1, 0, 1]
    for line in answers:
        rows = table[table["segment"] == line["label"]]
        said = service.client.post("/fit", content=_npy(rows), headers={"Content-Type": "application/x-npy"})
        assert said.json() == line["answer"]
        assert said.json()["receipt"]["columns"] == ["x", "y", "z", "nx", "ny", "nz"]


@pytest.mark.parametrize("where", ["query", "part"])
def test_the_column_of_labels_is_named_or_not_wanted(service: Service, where: str) -> None:
    body = csv(np.vstack([ROWS, ROWS + 1.0]), [1] * 300 + [2] * 300)
    other = body.replace(b"label", b"color")

    def labels(name: str, file: bytes) -> list[Any]:
        parts: list[Any] = [("file", ("scan.csv", file))]
        params = {"labels": name} if where == "query" else {}
        if where == "part":
            parts.append(("labels", (None, name.encode())))
        lines = _lines(service.client.post("/fit/batch", files=parts, params=params))
        return [
            line["problem"]["errors"][0]["field"] if "problem" in line else line["label"]
            for line in lines[:-1]
        ]

    assert labels("color", other) == [1, 2]
    assert labels("auto", body) == [1, 2]
    assert labels("auto", other) == [None]
    assert labels("", body) == [None]
    assert labels("color", body) == ["labels"]


@pytest.mark.parametrize("media_type", ["text/csv", "application/octet-stream"])
def test_a_raw_body_is_one_file(service: Service, media_type: str) -> None:
    body = csv(np.vstack([ROWS, ROWS + 1.0]), [1] * 300 + [2] * 300)
    response = service.client.post("/fit/batch?seed=3", content=body, headers={"Content-Type": media_type})
    lines = _lines(response)
    assert [(line["id"], line["file"], line["label"]) for line in lines[:-1]] == [
        ("file-1#1", None, 1),
        ("file-1#2", None, 2),
    ]
    assert {line["answer"]["receipt"]["options"]["seed"] for line in lines[:-1]} == {3}


def test_json_is_one_file_whose_options_are_its_own(service: Service) -> None:
    good, _ = _lines(service.client.post("/fit/batch", json=SMALL))
    assert good["answer"] == service.client.post("/fit", json=SMALL).json()
    mixed = json.dumps({**SMALL, "options": {"seed": 9}}).encode()
    first, second, _ = _post(service, ("a.json", mixed), ("b.csv", CSV), params={"seed": 1})
    assert first["problem"]["errors"][0]["field"] == "options.seed"
    assert second["answer"]["receipt"]["options"]["seed"] == 1


def test_what_stands_beside_points_in_json_goes_with_their_segment(service: Service) -> None:
    weights = np.random.default_rng(2).uniform(1, 2, 300)
    labels = ["up" if z > ROWS[:, 2].mean() else "down" for z in ROWS[:, 2]]
    scan = {"points": ROWS.tolist(), "weights": weights.tolist(), "labels": labels, "options": {"seed": 2}}
    lines = _lines(service.client.post("/fit/batch", json=scan))[:-1]
    assert [line["label"] for line in lines] == ["down", "up"]
    for line in lines:
        rows = [i for i, label in enumerate(labels) if label == line["label"]]
        alone = {"points": ROWS[rows].tolist(), "weights": weights[rows].tolist(), "options": {"seed": 2}}
        assert line["answer"] == service.client.post("/fit", json=alone).json()
    short = _lines(service.client.post("/fit/batch", json={**scan, "weights": [1.0]}))
    assert short[0]["problem"]["errors"][0]["field"] == "weights"


@pytest.mark.parametrize("n_bytes", [10**3, 10**6])
def test_bodies_and_files_may_be_packed(service: Service, n_bytes: int) -> None:
    """Small ones in memory, and ones that are kept on disk."""
    scan = many(2) + b"\n" * n_bytes
    part = b'--x\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n%s\r\n'
    body = part % (b"a.csv", scan) + part % (b"b.csv", CSV) + b"--x--\r\n"
    headers = {"Content-Type": "multipart/form-data; boundary=x", **SAME_ID}
    plain = service.client.post("/fit/batch", content=body, headers=headers)
    assert len(_lines(plain)) == 4
    packed = service.client.post(
        "/fit/batch", content=gzip.compress(body), headers=headers | {"Content-Encoding": "gzip"}
    )
    assert packed.content == plain.content
    files = [("file", (name, gzip.compress(file))) for name, file in (("a.csv", scan), ("b.csv", CSV))]
    assert service.client.post("/fit/batch", files=files, headers=SAME_ID).content == plain.content
    twice = service.client.post(
        "/fit/batch",
        content=gzip.compress(part % (b"a", gzip.compress(CSV)) + b"--x--\r\n"),
        headers=headers | {"Content-Encoding": "gzip"},
    )
    assert "compressed twice" in _lines(twice)[0]["problem"]["detail"]
    broken = service.client.post("/fit/batch", content=b"1", headers=headers | {"Content-Encoding": "gzip"})
    assert broken.status_code == 422 and broken.json()["errors"][0]["field"] == "body"
    wait_for(lambda: _is_clean(service))


REFUSED: dict[str, tuple[dict[str, Any], str, str]] = {
    "unknown option": ({"params": {"seeds": 1}}, "invalid-options", "seeds"),
    "option out of range": ({"params": {"max_error": 2}}, "invalid-options", "max_error"),
    "options that contradict": (
        {"params": {"kinds": "cone", "criterion": "maximum_inscribed"}}, "invalid-options", "options.kinds"),
    "option twice": ({"params": {"seed": 1}, "options": b'{"seed": 2}'}, "invalid-options", "options.seed"),
    "bad options": ({"options": b"{"}, "unreadable-input", "options"),
    "labels twice": ({"params": {"labels": "a"}, "labels": b"a"}, "invalid-options", "labels"),
    "long labels": ({"labels": b"a" * 1000}, "invalid-options", "labels"),
    "no file": ({"file": None}, "unreadable-input", "file"),
    "unknown part": ({"cloud": b"1 2 3"}, "unreadable-input", "cloud"),
}  # fmt: skip


@pytest.mark.parametrize(("given", "slug", "field"), REFUSED.values(), ids=REFUSED)
def test_what_is_wrong_altogether_is_refused_before_a_line(
    service: Service, given: dict[str, Any], slug: str, field: str
) -> None:
    parts = {"file": CSV} | {name: value for name, value in given.items() if name != "params"}
    files = {name: (None, value) for name, value in parts.items() if value is not None}
    response = service.client.post(
        "/fit/batch", files=files or {"options": (None, b"{}")}, params=given.get("params")
    )
    assert response.status_code == 422, response.text
    assert response.headers["content-type"] == "application/problem+json"
    assert response.json()["type"] == f"urn:primfit:problem:{slug}"
    assert response.json()["errors"][0]["field"] == field


def test_any_number_of_workers_gives_the_same_bytes(service: Service, single: Service) -> None:
    files = [("file", (f"{i}.csv", many(i))) for i in (2, 1, 3)]
    replies = [s.client.post("/fit/batch", files=files, headers=SAME_ID).content for s in (service, single)]
    assert replies[0] == replies[1]
    assert replies[0].count(b"\n") == 7


def test_the_order_holds_whatever_takes_longest(service: Service) -> None:
    files = [("a.npy", _big(200_000)), ("b.csv", many(40, 30)), ("c.npy", _big(100_000)), ("d.csv", CSV)]
    lines = _post(service, *files)
    assert [line["id"] for line in lines[:-1]] == [
        "a.npy",
        *(f"b.csv#{i}" for i in range(40)),
        "c.npy",
        "d.csv",
    ]


NAMES = {
    "../../etc/passwd": "passwd",
    "C:\\scans\\part.ply": "part.ply",
    "a\0b.ply": "a_b.ply",
    "a" * 300: "a" * 80,
    "größe 1.csv": "größe 1.csv",
    "‮gpj.csv\x07": "_gpj.csv_",
    "..": None,
    "": None,
    "<b>|.csv": "_b__.csv",
}


def test_hostile_names_are_made_harmless(service: Service) -> None:
    parts = [
        b'--x\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n1 2 3\r\n' % name.encode()
        for name in NAMES
        if "\0" not in name and "\x07" not in name
    ]
    media_type = {"Content-Type": "multipart/form-data; boundary=x"}
    body = b"".join(parts) + b"--x--\r\n"
    *lines, _ = _lines(service.client.post("/fit/batch", content=body, headers=media_type))
    wanted = [shown for name, shown in NAMES.items() if "\0" not in name and "\x07" not in name]
    assert [line["file"] for line in lines] == wanted
    ids = [line["id"] for line in lines]
    assert len(set(ids)) == len(ids) and all(len(i) <= 80 and i.isprintable() and "/" not in i for i in ids)


@pytest.mark.parametrize("name", [name for name in NAMES if "\0" in name or "\x07" in name])
def test_a_name_with_control_characters_is_refused_or_made_harmless(service: Service, name: str) -> None:
    part = b'--x\r\nContent-Disposition: form-data; name="file"; filename="%s"\r\n\r\n1 2 3\r\n--x--\r\n'
    response = service.client.post(
        "/fit/batch",
        content=part % name.encode(),
        headers={"Content-Type": "multipart/form-data; boundary=x"},
    )
    if response.status_code == 200:
        assert _lines(response)[0]["file"] == NAMES[name]
    else:
        assert response.status_code == 422 and response.json()["errors"][0]["field"] == "body"


def test_labels_from_outside_give_ids_that_differ(service: Service) -> None:
    labels = ["a/b", "a_b", "A_B", "x" * 90, "x" * 89 + "y"]
    scan = csv(np.tile(ROWS[:2], (5, 1)), np.repeat(labels, 2))
    lines = _post(service, ("n" * 100 + ".csv", scan))[:-1]
    assert sorted(line["label"] for line in lines) == sorted(labels)
    ids = [line["id"].casefold() for line in lines]
    assert len(set(ids)) == 5 and max(map(len, ids)) <= 80
    long = _post(service, ("a.csv", csv(ROWS[:2], ["x" * 201] * 2)))
    assert (
        long[0]["problem"]["errors"][0]["field"] == "labels"
        and "200 characters" in long[0]["problem"]["detail"]
    )


def test_items_are_limited(single: Service) -> None:
    eight = [("file", ("a.csv", CSV))] * 8
    response = single.client.post("/fit/batch", files=eight)
    assert response.status_code == 413 and "more than 7 files" in response.json()["detail"]
    assert [line["id"] for line in _post(single, ("a.csv", many(6)), ("b.csv", CSV))[:-1]] == [
        *(f"a.csv#{i}" for i in range(6)),
        "b.csv",
    ]
    lines = _post(single, ("a.csv", many(3)), ("b.csv", many(4)), ("c.csv", many(2)), ("d.csv", CSV))
    assert [line["id"] for line in lines[:-1]] == [
        "a.csv#0",
        "a.csv#1",
        "a.csv#2",
        "b.csv",
        "c.csv#0",
        "c.csv#1",
        "d.csv",
    ]
    assert lines[3]["problem"]["type"] == "urn:primfit:problem:too-large"
    whole = _post(single, ("a.csv", many(8)))
    assert "8 segments" in whole[0]["problem"]["detail"]


def test_bodies_and_points_are_limited_as_ever(strict_service: Service) -> None:
    files = [("file", ("a.csv", b"1,2,3\n" * 100_000)) for _ in range(2)]
    response = strict_service.client.post("/fit/batch", files=files)
    assert response.status_code == 413 and response.json()["type"] == "urn:primfit:problem:too-large"
    lines = _post(strict_service, ("a.npy", _big(20_001)), ("b.csv", CSV))
    assert "20001 points; the limit is 20000" in lines[0]["problem"]["detail"]
    assert "answer" in lines[1]


def _streamed(service: Service, *files: tuple[str, bytes], **options: str) -> Any:
    parts = [("file", file) for file in files]
    return service.client.stream("POST", "/fit/batch", files=parts, params=options)


def _wait_for_work(service: Service) -> int:
    """The only worker, once it has been at work for a fifth of a second."""
    (worker,) = workers(service.pid)
    before = ticks(worker)
    wait_for(lambda: ticks(worker) > before + 20)
    return worker


@needs_proc
def test_lines_come_before_the_last_item_is_done_and_a_lost_worker_costs_one(single: Service) -> None:
    """The worker is killed over the second file, when the first line is there: so the line did not wait."""
    files = ("a.csv", CSV), ("b.npy", _big()), ("c.csv", many(2))
    with _streamed(single, *files, criterion="minimum_zone") as response:
        lines = response.iter_lines()
        first = json.loads(next(lines))
        os.kill(_wait_for_work(single), signal.SIGKILL)
        rest = [json.loads(line) for line in lines]
    assert first["id"] == "a.csv" and first["answer"]["status"] == "fitted"
    assert rest[0]["problem"]["type"] == "urn:primfit:problem:worker-died"
    assert [line["id"] for line in rest[1:-1]] == ["c.csv#0", "c.csv#1"]
    assert all(line["answer"]["status"] == "fitted" for line in rest[1:-1])
    assert rest[-1]["summary"] == {"items": 4, "fitted": 3, "ambiguous": 0, "no_fit": 0, "problems": 1}
    wait_for(lambda: _is_clean(single))


@needs_proc
def test_other_requests_have_their_turn(hurried: Service) -> None:
    """The worker is at work after the answer to another request: so the batch was not done before it."""
    with _streamed(hurried, ("a.csv", many(300, 300))) as response:
        lines = response.iter_lines()
        next(lines)
        other = httpx.post(f"http://127.0.0.1:{hurried.port}/fit", json=SMALL, timeout=60)
        _wait_for_work(hurried)
    assert other.status_code == 200
    wait_for(lambda: _is_clean(hurried))


@needs_proc
def test_an_item_over_the_time_limit_costs_that_item(hurried: Service) -> None:
    with _streamed(hurried, ("a.csv", many(60, 300))) as response:
        lines = response.iter_lines()
        next(lines)
        os.kill(_wait_for_work(hurried), signal.SIGSTOP)
        rest = [json.loads(line) for line in lines]
    problems = [line["problem"]["type"] for line in rest if "problem" in line]
    assert problems == ["urn:primfit:problem:time-limit"]
    assert rest[-1]["summary"]["fitted"] == 59


@needs_proc
def test_a_client_that_goes_away_stops_the_rest(hurried: Service) -> None:
    with _streamed(hurried, ("a.csv", many(500, 300))) as response:
        lines = response.iter_lines()
        next(lines)
    wait_for(lambda: _is_clean(hurried))
    (worker,) = workers(hurried.pid)
    time.sleep(0.3)
    before = ticks(worker)
    time.sleep(0.5)
    assert ticks(worker) - before < 10
    assert hurried.client.post("/fit", json=SMALL).status_code == 200


@needs_proc
def test_a_client_that_takes_nothing_is_given_up(hurried: Service) -> None:
    """Nothing is read until the service has thrown the batch away: more than the buffers between hold."""
    part = b'--x\r\nContent-Disposition: form-data; name="file"\r\n\r\n1,2,3\n' + b"a,b,c\n" * 20 + b"\r\n"
    body = part * 4000 + b"--x--\r\n"
    head = (
        "POST /fit/batch HTTP/1.1\r\nHost: localhost\r\nContent-Type: multipart/form-data; boundary=x\r\n"
        f"Content-Length: {len(body)}\r\n\r\n"
    )
    with socket.socket() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.connect(("127.0.0.1", hurried.port))
        connection.sendall(head.encode() + body)
        wait_for(lambda: not _is_clean(hurried))
        wait_for(lambda: _is_clean(hurried))
        connection.settimeout(60)
        received = b""
        while piece := connection.recv(1 << 20):
            received += piece
    assert b'"id":"file-1"' in received
    assert b'"summary"' not in received
    assert hurried.client.post("/fit", json=SMALL).status_code == 200


def test_open_batches_are_limited(hurried: Service) -> None:
    with _streamed(hurried, ("a.csv", many(300, 300))) as response:
        lines = response.iter_lines()
        next(lines)
        refused = httpx.post(f"http://127.0.0.1:{hurried.port}/fit/batch", json=SMALL, timeout=PATIENCE)
    assert refused.status_code == 503 and refused.headers["retry-after"] == "1"
    assert refused.json()["type"] == "urn:primfit:problem:busy"
    wait_for(lambda: _is_clean(hurried))
    assert len(_lines(hurried.client.post("/fit/batch", json=SMALL))) == 2


def test_the_document_shows_a_line_of_each_sort(service: Service) -> None:
    operation = service.client.get("/openapi.json").json()["paths"]["/fit/batch"]["post"]
    lines = operation["responses"]["200"]["content"]["application/x-ndjson"]
    assert lines["schema"] == {"$ref": "#/components/schemas/BatchLine"}
    assert set(lines["examples"]) == {"answer", "problem", "summary"}
    for example in lines["examples"].values():
        _check(example["value"])
    assert "labels" in {parameter.get("name") for parameter in operation["parameters"]}
    upload = operation["requestBody"]["content"]["multipart/form-data"]["examples"]["cylinder"]["value"]
    files = [("file", (f"{i}.csv", text.encode())) for i, text in enumerate(upload["file"])]
    options = ("options", (None, json.dumps(upload["options"]).encode()))
    assert len(_lines(service.client.post("/fit/batch", files=[*files, options]))) == 3


@pytest.mark.skipif(not shutil.which("curl"), reason="runs the lines of the documentation as they stand")
def test_the_curl_line_of_the_documentation_runs(service: Service) -> None:
    (line,) = re.findall(r"^curl .*/fit/batch .*$", (DOCS / "api.md").read_text(), re.MULTILINE)
    command = shlex.split(line.replace("localhost:8000", f"127.0.0.1:{service.port}"))
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60)
    *items, end = map(json.loads, done.stdout.splitlines())
    assert [(item["id"], item["answer"]["primitive"]["kind"]) for item in items] == [
        ("segments.csv#1", "plane"),
        ("segments.csv#2", "sphere"),
        ("segments.csv#3", "cylinder"),
        ("cylinder.csv", "cylinder"),
    ]
    assert end["summary"]["fitted"] == 4


def test_a_batch_that_is_still_being_sent_keeps_nobody_out(hurried: Service) -> None:
    """Only one batch may be open there."""
    head = (
        "POST /fit/batch HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/csv\r\n"
        "Content-Length: 100000\r\n\r\n"
    )
    with socket.create_connection(("127.0.0.1", hurried.port)) as slow:
        slow.sendall(head.encode())
        time.sleep(0.2)
        response = hurried.client.post("/fit/batch", content=CSV, headers={"Content-Type": "text/csv"})
    assert response.status_code == 200 and '"status":"fitted"' in response.text
