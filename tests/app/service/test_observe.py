"""What the log tells of a request, on a real service."""

import json
from typing import Any

from tests.app.serving import ALICE, wait_for
from tests.paths import EXAMPLES

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
KEY = {"X-API-Key": ALICE}


def _line(service: Any, request_id: str) -> dict[str, Any]:
    """The one line of the log that belongs to this request."""

    def lines() -> list[dict[str, Any]]:
        every = [json.loads(line) for line in service.log.read_text().splitlines()]
        return [line for line in every if line.get("request_id") == request_id]

    wait_for(lambda: bool(lines()))
    (line,) = lines()
    return line


def test_a_fit_is_one_line_with_its_facts(guarded_service: Any) -> None:
    headers = {**KEY, "X-Request-Id": "fit-1", "Content-Type": "text/csv"}
    guarded_service.client.post("/fit?seed=3", content=CSV, headers=headers)
    line = _line(guarded_service, "fit-1")
    assert {name: line.pop(name) for name in ("time", "seconds", "fit_seconds")}.keys()
    assert line == {
        "level": "info",
        "message": "request",
        "request_id": "fit-1",
        "method": "POST",
        "path": "/fit",
        "status": 200,
        "address": "127.0.0.1",
        "client": "alice",
        "received_bytes": len(CSV),
        "fit_status": "fitted",
        "fit_kind": "cylinder",
        "n_points": 300,
        "attempts": 1,
    }


def test_a_refusal_is_a_line_that_names_the_problem_and_holds_nothing_of_the_input(
    guarded_service: Any,
) -> None:
    headers = {**KEY, "X-Request-Id": "bad-1", "Content-Type": "text/csv"}
    guarded_service.client.post("/fit?s3cret=1", content=b"s3cret,1\n", headers=headers)
    line = _line(guarded_service, "bad-1")
    assert (line["status"], line["problem"], line["received_bytes"]) == (422, "invalid-options", 9)
    assert "s3cret" not in guarded_service.log.read_text()


def test_the_trace_of_a_client_is_named_and_nothing_else_is_taken_for_one(guarded_service: Any) -> None:
    trace = "0af7651916cd43dd8448eb211c80319c"
    for name, parent in (
        ("traced-1", f"00-{trace}-b7ad6b7169203331-00"),
        ("traced-2", f"00-{trace}-s3cret-01"),
    ):
        headers = {**KEY, "X-Request-Id": name, "traceparent": parent}
        guarded_service.client.get("/version", headers=headers)
    assert _line(guarded_service, "traced-1")["trace_id"] == trace
    assert "trace_id" not in _line(guarded_service, "traced-2")


def test_a_path_cannot_forge_a_line(guarded_service: Any) -> None:
    headers = {**KEY, "X-Request-Id": "odd-1"}
    guarded_service.client.get("/odd%0a%22,%22path/" + "x" * 1000, headers=headers)
    line = _line(guarded_service, "odd-1")
    assert line["path"].startswith("/odd%0a%22,%22path/xxx") and len(line["path"]) == 200


def test_probes_leave_no_line(guarded_service: Any) -> None:
    guarded_service.client.get("/livez", headers={"X-Request-Id": "probe-1"})
    guarded_service.client.get("/version", headers={**KEY, "X-Request-Id": "after-the-probe"})
    _line(guarded_service, "after-the-probe")
    assert "probe-1" not in guarded_service.log.read_text()


def test_text_has_the_same_facts(service: Any) -> None:
    headers = {"X-Request-Id": "text-1", "Content-Type": "text/csv"}
    service.client.post("/fit", content=CSV, headers=headers)
    wait_for(lambda: "text-1" in service.log.read_text())
    (line,) = (line for line in service.log.read_text().splitlines() if "text-1" in line)
    assert " INFO request request_id=text-1 method=POST path=/fit status=200 " in line
    assert "fit_status=fitted fit_kind=cylinder n_points=300 attempts=1" in line
