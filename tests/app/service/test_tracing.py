"""Traces: what a collector gets of requests to a real service, and what the log tells without one."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from primfit.app.service.tracing import provider
from tests.app.service.collector import Collector, attributes, collecting
from tests.app.serving import ALICE, Service, running, wait_for
from tests.paths import EXAMPLES, ROOT

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
TRACE, PARENT = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"
SERVER, ERROR = 2, 2
"""SPAN_KIND_SERVER and STATUS_CODE_ERROR of the protocol."""

Traced = tuple[Service, Collector]


@pytest.fixture(scope="module")
def traced(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Traced]:
    """A guarded service that logs in JSON and sends its spans to a collector at once."""
    with collecting() as collector, ExitStack() as stack:
        with pytest.MonkeyPatch.context() as environment:
            environment.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", collector.url)
            environment.setenv("OTEL_RESOURCE_ATTRIBUTES", "deployment.environment.name=test")
            environment.setenv("OTEL_BSP_SCHEDULE_DELAY", "50")
            settings = {"api_keys": f"alice:{ALICE}", "log_format": "json"}
            service = running(tmp_path_factory.mktemp("bodies"), workers=1, **settings)
            started = stack.enter_context(service)
        yield started, collector


def _ask(service: Service, request_id: str, path: str = "/fit", **more: Any) -> Any:
    given = {"X-API-Key": ALICE, "X-Request-Id": request_id, "Content-Type": "text/csv"}
    headers = given | more.pop("headers", {})
    return service.client.request("POST", path, **{"content": CSV, **more}, headers=headers)


def _line(service: Service, request_id: str) -> dict[str, Any]:
    def lines() -> list[dict[str, Any]]:
        every = [json.loads(line) for line in service.log.read_text().splitlines()]
        return [line for line in every if line.get("request_id") == request_id]

    wait_for(lambda: bool(lines()))
    return lines()[-1]


def test_a_fit_is_a_span_of_its_callers_trace_with_a_span_for_each_step(traced: Traced) -> None:
    service, collector = traced
    headers = {"traceparent": f"00-{TRACE}-{PARENT}-01", "tracestate": "vendor=1,other=2"}
    assert _ask(service, "fit-1", "/fit?kinds=cylinder", headers=headers).status_code == 200
    span, steps = collector.request("fit-1")
    assert (span.name, span.kind, span.status.code) == ("POST /fit", SERVER, 0)
    assert (span.trace_id.hex(), span.parent_span_id.hex()) == (TRACE, PARENT)
    assert span.trace_state == "vendor=1,other=2"
    known = attributes(span)
    assert known.pop("primfit.fit_seconds") > 0
    assert known.pop("user_agent.original").startswith("python-httpx/")
    assert known == {
        "http.request.method": "POST",
        "http.response.status_code": 200,
        "http.route": "/fit",
        "url.scheme": "http",
        "url.path": "/fit",
        "network.protocol.version": "1.1",
        "client.address": "127.0.0.1",
        "primfit.request_id": "fit-1",
        "primfit.client": "alice",
        "primfit.fit_status": "fitted",
        "primfit.fit_kind": "cylinder",
        "primfit.n_points": 300,
        "primfit.attempts": 1,
    }
    assert list(steps) == ["receive", "queue", "read", "fit", "encode"]
    times = [(step.start_time_unix_nano, step.end_time_unix_nano) for step in steps.values()]
    assert span.start_time_unix_nano <= times[0][0] and times[-1][1] <= span.end_time_unix_nano
    assert all(start <= end for start, end in times)
    assert all(end == start for (_, end), (start, _) in pairwise(times))
    assert _line(service, "fit-1")["trace_id"] == TRACE


def test_the_resource_is_named_and_what_the_environment_says_of_it_counts(traced: Traced) -> None:
    service, collector = traced
    _ask(service, "resource-1")
    collector.request("resource-1")
    told = attributes(collector.requests[-1].resource_spans[0].resource)
    assert told["service.name"] == "primfit" and told["service.version"]
    assert told["deployment.environment.name"] == "test"


def test_without_a_caller_a_request_begins_a_trace_which_the_log_names(traced: Traced) -> None:
    service, collector = traced
    _ask(service, "root-1", headers={"traceparent": f"00-{'0' * 32}-{PARENT}-01"})
    span, _ = collector.request("root-1")
    assert span.parent_span_id == b"" and span.trace_id.hex() != "0" * 32
    assert _line(service, "root-1")["trace_id"] == span.trace_id.hex()


def test_what_a_caller_does_not_sample_is_not_sent_but_logged(traced: Traced) -> None:
    service, collector = traced
    _ask(service, "unsampled-1", headers={"traceparent": f"00-{TRACE}-{PARENT}-00"})
    _ask(service, "sampled-1")
    collector.request("sampled-1")
    assert "unsampled-1" not in [attributes(span).get("primfit.request_id") for span in collector.spans()]
    assert _line(service, "unsampled-1")["trace_id"] == TRACE


def test_a_refusal_names_its_problem_wherever_it_was_made(traced: Traced) -> None:
    service, collector = traced
    asked = {
        "reader-1": ("/fit", {"content": b"one,1\n"}),
        "door-1": ("/fit", {"headers": {"X-API-Key": "wrong"}}),
        "router-1": ("/nowhere/4711", {}),
        "batch-1": ("/fit/batch?kinds=cube", {}),
    }
    for name, (path, more) in asked.items():
        _ask(service, name, path, **more)
    found = {name: collector.request(name) for name in asked}
    told = {name: attributes(span) for name, (span, _) in found.items()}
    problems = {name: (one["http.response.status_code"], one["error.type"]) for name, one in told.items()}
    assert problems == {
        "reader-1": (422, "unreadable-input"),
        "door-1": (401, "unauthorized"),
        "router-1": (404, "not-found"),
        "batch-1": (422, "invalid-options"),
    }
    names = {name: span.name for name, (span, _) in found.items()}
    assert names == {
        "reader-1": "POST /fit",
        "door-1": "POST /fit",
        "router-1": "POST",
        "batch-1": "POST /fit/batch",
    }
    assert all(span.status.code == 0 for span, _ in found.values())
    assert list(found["reader-1"][1]) == ["receive", "queue", "work"]
    assert not found["door-1"][1]


def test_a_batch_tells_what_came_of_its_items(traced: Traced) -> None:
    service, collector = traced
    files = [("file", ("a.csv", CSV)), ("file", ("b.csv", b"one,1\n"))]
    headers = {"X-API-Key": ALICE, "X-Request-Id": "batch-2"}
    service.client.post("/fit/batch", files=files, headers=headers)
    span, steps = collector.request("batch-2")
    counts = {name: attributes(span)[f"primfit.{name}"] for name in ("items", "fitted", "problems")}
    assert counts == {"items": 2, "fitted": 1, "problems": 1}
    assert list(steps) == ["receive"]


def test_nothing_of_the_cloud_the_query_or_the_key_is_told(traced: Traced) -> None:
    service, collector = traced
    cloud = b"".join(b"4242.5%d,%d,0\n" % (i, i * i) for i in range(30))
    _ask(service, "silent-1", "/fit?seed=31337421&kinds=plane", content=cloud)
    _ask(service, "silent-2", "/fit?s3cret=s3cret", content=b"s3cret,1\n")
    _ask(service, "silent-3", headers={"X-API-Key": "wrong-s3cret-s3cret"})
    for name in ("silent-1", "silent-2", "silent-3"):
        collector.request(name)
    told = b"".join(collector.bodies)
    assert b"silent-3" in told
    assert not any(secret in told for secret in (b"4242.5", b"31337421", b"s3cret", ALICE.encode()))


def test_probes_make_no_spans(traced: Traced) -> None:
    service, collector = traced
    service.client.get("/livez", headers={"X-Request-Id": "probe-1"})
    _ask(service, "after-the-probe")
    collector.request("after-the-probe")
    assert "probe-1" not in [attributes(span).get("primfit.request_id") for span in collector.spans()]


def test_a_failure_is_an_error_and_the_last_spans_are_sent_before_the_service_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with collecting() as collector:
        monkeypatch.setenv("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", f"{collector.url}/v1/traces")
        monkeypatch.setenv("OTEL_BSP_SCHEDULE_DELAY", "3600000")
        # Nobody reads and fits in so short a time.
        with running(tmp_path / "bodies", workers=1, fit_time_limit=1e-6) as service:
            assert _ask(service, "late-1").status_code == 504
            assert not collector.spans()
        span, _ = collector.request("late-1")
    assert span.status.code == ERROR
    assert attributes(span)["error.type"] == "time-limit"


def test_nothing_is_imported_for_traces_that_nobody_wants() -> None:
    script = """
import sys
from primfit.app.service.api import create_app
create_app().build_middleware_stack()
print([name for name in sys.modules if name.startswith(("opentelemetry.sdk", "opentelemetry.exporter"))])
"""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("OTEL_")}
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (done.stdout, done.stderr) == ("[]\n", "")


@pytest.mark.parametrize(
    "settings",
    [
        {"OTEL_EXPORTER_OTLP_ENDPOINT": ""},
        {"OTEL_EXPORTER_OTLP_ENDPOINT": "http://127.0.0.1:9", "OTEL_SDK_DISABLED": "True"},
        {"OTEL_EXPORTER_OTLP_ENDPOINT": "http://127.0.0.1:9", "OTEL_TRACES_EXPORTER": "none"},
    ],
    ids=["empty", "disabled", "no traces"],
)
def test_the_environment_can_say_no(settings: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in settings.items():
        monkeypatch.setenv(name, value)
    assert provider() is None


def test_where_the_extra_is_missing_a_warning_says_so(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("OTEL_EXPORTER_OTLP_ENDPOINT", "http://127.0.0.1:9")
    monkeypatch.setitem(sys.modules, "opentelemetry.sdk.trace", None)
    assert provider() is None
    told = "OTEL_EXPORTER_OTLP_ENDPOINT is set, but no traces are sent: install primfit[otel]"
    assert caplog.messages == [told]
