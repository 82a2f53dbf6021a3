"""Spans of requests for OpenTelemetry, if its usual variables say where to; else nothing is imported.

FastAPI and Starlette have such spans of their own. They tell the values of queries, and know nothing of the
steps of a fit.
"""

import asyncio
import logging
import os
import threading
from collections.abc import Iterator
from importlib.metadata import version
from itertools import pairwise
from time import time_ns
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ..wire.problems import plain
from ..workers.trace_context import TRACE_ID, Caller
from .observe import QUIET
from .routes import RouteNames

if TYPE_CHECKING:
    from opentelemetry.context import Context
    from opentelemetry.sdk.trace import TracerProvider
    from opentelemetry.trace import Span

_ENDPOINTS = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")
_METHODS = ("CONNECT", "DELETE", "GET", "HEAD", "OPTIONS", "PATCH", "POST", "PUT", "TRACE")
_LENGTH = 200
_STOP_PATIENCE = 5.0
"""Seconds that the last spans may take: half of what requests under way get, and less than managers wait."""
_log = logging.getLogger("primfit")


def provider() -> "TracerProvider | None":
    """What sends spans, as the variables OTEL_* say; None where they ask for none, or it is not installed."""
    where = next((name for name in _ENDPOINTS if os.environ.get(name)), None)
    if where is None or _said("OTEL_SDK_DISABLED") == "true" or _said("OTEL_TRACES_EXPORTER") == "none":
        return None
    try:
        from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
        from opentelemetry.sdk.resources import OTELResourceDetector, Resource
        from opentelemetry.sdk.trace import TracerProvider
        from opentelemetry.sdk.trace.export import BatchSpanProcessor
    except ImportError:
        _log.warning("%s is set, but no traces are sent: install primfit[otel]", where)
        return None
    named = Resource.create({"service.name": "primfit", "service.version": version("primfit")})
    made = TracerProvider(resource=named.merge(OTELResourceDetector().detect()), shutdown_on_exit=False)
    made.add_span_processor(BatchSpanProcessor(OTLPSpanExporter()))
    return made


def _said(name: str) -> str:
    return os.environ.get(name, "").strip().lower()


class Tracing:
    """Makes a span of each request that the log tells of, with one below it for each of its steps.

    To be added outside of the observer, whose `state.facts` become attributes, and inside of the ids. The
    steps in a worker, `state.worked`, are the seconds of each and when the last one ended, in nanoseconds.
    """

    def __init__(self, app: ASGIApp, provider: "TracerProvider", routes: RouteNames) -> None:
        self.app, self._provider, self._routes = app, provider, routes
        self._tracer = provider.get_tracer("primfit", version("primfit"))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self._to_the_last(scope, receive, send)
        elif scope["type"] != "http" or scope["path"] in QUIET:
            await self.app(scope, receive, send)
        else:
            await self._traced(scope, receive, send)

    async def _to_the_last(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def after_the_spans(message: Message) -> None:
            if message["type"].startswith("lifespan.shutdown."):
                sending = threading.Thread(target=self._provider.shutdown, daemon=True)
                sending.start()
                await asyncio.to_thread(sending.join, _STOP_PATIENCE)
            await send(message)

        await self.app(scope, receive, after_the_spans)

    async def _traced(self, scope: Scope, receive: Receive, send: Send) -> None:
        from opentelemetry.trace import SpanKind

        request = Request(scope)
        state = request.state
        body: list[int] = []
        span = self._tracer.start_span(
            _name(request), _context(state.caller), SpanKind.SERVER, _known(request)
        )
        TRACE_ID.set(f"{span.get_span_context().trace_id:032x}")

        async def timed() -> Message:
            if not body:
                body.append(time_ns())
            message = await receive()
            if len(body) == 1 and not message.get("more_body", False):
                body.append(time_ns())
            return message

        try:
            await self.app(scope, timed, send)
        finally:
            if span.is_recording():
                self._end(span, request, body)

    def _end(self, span: "Span", request: Request, body: list[int]) -> None:
        from opentelemetry.context import Context
        from opentelemetry.trace import Status, StatusCode, set_span_in_context

        ended, below = time_ns(), set_span_in_context(span, Context())
        facts, route = dict(request.state.facts), self._routes.name(request.scope)
        facts.pop("status", None)
        status: int = request.state.status  # which the observer, further in, has noted
        attributes = {f"primfit.{name}": value for name, value in facts.items() if name != "problem"}
        attributes |= {"http.route": route, "http.response.status_code": status or None}
        attributes["error.type"] = facts.get("problem")
        span.set_attributes({name: value for name, value in attributes.items() if value is not None})
        if route is not None:
            span.update_name(f"{_name(request)} {route}")
        if status >= 500:
            span.set_status(Status(StatusCode.ERROR))
        for name, start, end in _steps(body, getattr(request.state, "worked", None), ended):
            self._tracer.start_span(name, below, start_time=start).end(end)
        span.end(ended)


def _steps(
    body: list[int], worked: tuple[dict[str, float], int] | None, ended: int
) -> Iterator[tuple[str, int, int]]:
    """The steps of a request with their start and end in nanoseconds; the queue lies before a worker's."""
    if not body:
        return
    began, received = body if len(body) == 2 else (*body, ended)
    yield "receive", began, received
    if worked is None:
        return
    seconds, end = worked
    ends = [end]
    for value in reversed(seconds.values()):
        ends.insert(0, ends[0] - round(1e9 * value))
    ends = [max(received, one) for one in ends]
    for name, (start, stop) in zip(("queue", *seconds), pairwise([received, *ends]), strict=True):
        yield name, start, stop


def _name(request: Request) -> str:
    """The name of a span before its route is known, of few values whatever comes."""
    return request.method if request.method in _METHODS else "HTTP"


def _known(request: Request) -> dict[str, Any]:
    """What is known of a request when it comes, by the conventions for HTTP; its query is left out."""
    method, scope = request.method, request.scope
    known = {
        "http.request.method": method if method in _METHODS else "_OTHER",
        "url.scheme": scope["scheme"],
        "url.path": plain(scope.get("raw_path", b"").decode("latin-1"), _LENGTH),
        "network.protocol.version": scope["http_version"],
        "user_agent.original": plain(request.headers.get("user-agent", ""), _LENGTH),
        "primfit.request_id": request.state.request_id,
    }
    return known | ({"client.address": plain(request.client.host, _LENGTH)} if request.client else {})


def _context(caller: Caller | None) -> "Context":
    """What the span of a request is part of: the span of its caller, or nothing."""
    from opentelemetry.context import Context
    from opentelemetry.trace import NonRecordingSpan, SpanContext, TraceFlags, TraceState, set_span_in_context

    if caller is None:
        return Context()
    asks = SpanContext(
        int(caller.trace_id, 16),
        int(caller.span_id, 16),
        is_remote=True,
        trace_flags=TraceFlags(int(caller.flags, 16)),
        trace_state=TraceState.from_header([caller.state]),
    )
    return set_span_in_context(NonRecordingSpan(asks), Context())
