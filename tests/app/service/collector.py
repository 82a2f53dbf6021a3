"""A receiver of spans, as OpenTelemetry's collector is one: it decodes what comes by OTLP over HTTP."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest
from opentelemetry.proto.trace.v1.trace_pb2 import Span

from tests.app.serving import wait_for


class Collector:
    """What came: the bodies as they were, and the spans in them."""

    def __init__(self, url: str) -> None:
        self.url = url
        self.bodies: list[bytes] = []
        self.requests: list[ExportTraceServiceRequest] = []

    def spans(self) -> list[Span]:
        """All spans so far."""
        scopes = [scope for one in self.requests for of in one.resource_spans for scope in of.scope_spans]
        return [span for scope in scopes for span in scope.spans]

    def request(self, request_id: str) -> tuple[Span, dict[str, Span]]:
        """The span of a request, once it has come, and those below it by their names."""

        def found() -> list[Span]:
            return [span for span in self.spans() if attributes(span).get("primfit.request_id") == request_id]

        wait_for(lambda: bool(found()))
        (span,) = found()
        below = [other for other in self.spans() if other.parent_span_id == span.span_id]
        assert all(other.trace_id == span.trace_id for other in below)
        return span, {other.name: other for other in below}


def attributes(span: Any) -> dict[str, Any]:
    """The attributes of a span or a resource by their names."""
    kinds = ((one.key, one.value, one.value.WhichOneof("value")) for one in span.attributes)
    return {key: getattr(value, kind) for key, value, kind in kinds}


@contextmanager
def collecting() -> Iterator[Collector]:
    """A collector on a port of its own."""

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["Content-Length"]))
            assert self.path == "/v1/traces" and self.headers["Content-Type"] == "application/x-protobuf"
            collector.bodies.append(body)
            collector.requests.append(ExportTraceServiceRequest.FromString(body))
            self.send_response(200)
            self.send_header("Content-Length", "0")
            self.end_headers()

        def log_message(self, format: str, *args: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        collector = Collector(f"http://127.0.0.1:{server.server_port}")
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            yield collector
        finally:
            server.shutdown()
