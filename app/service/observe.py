"""Every request leaves one line in the log and its mark in the metrics, however it ends."""

import asyncio
import logging
from time import perf_counter

from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ..wire.problems import INTERNAL, StoppingError, plain, respond
from ..workers import logs
from .metrics import Metrics
from .routes import RouteNames

QUIET = ("/livez", "/readyz", "/metrics")
"""Paths that are asked every few seconds, and stay out of the log."""
_PATH_LENGTH, _ADDRESS_LENGTH = 200, 60
_log = logging.getLogger("primfit")


class Observer:
    """Notes what is known of a request, `state.facts`, when it ends; holds neither bodies nor keys."""

    def __init__(self, app: ASGIApp, metrics: Metrics, routes: RouteNames) -> None:
        self.app, self._metrics, self._routes = app, metrics, routes

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        request, started = Request(scope), perf_counter()
        request.state.facts = {}
        status, n_bytes = 0, 0

        async def counted() -> Message:
            nonlocal n_bytes
            message = await receive()
            n_bytes += len(message.get("body", b""))
            return message

        async def noted(message: Message) -> None:
            nonlocal status
            status = message.get("status", status)
            await send(message)

        try:
            await self.app(scope, counted, noted)
        except asyncio.CancelledError:
            if not status:
                error = StoppingError("the service stopped before the answer was ready; ask again")
                await respond(request, error)(scope, receive, noted)
        except Exception:
            status = INTERNAL.status
            request.state.facts["problem"] = INTERNAL.slug
            raise
        finally:
            self._report(request, status, perf_counter() - started, n_bytes)

    def _report(self, request: Request, status: int, seconds: float, n_bytes: int) -> None:
        facts = {"received_bytes": n_bytes, **request.state.facts}
        # Where the connection has answered in place of the application.
        status = request.state.status = facts.pop("status", status)
        self._metrics.requested(self._routes.name(request.scope) or "other", status, seconds, facts)
        if request.scope["path"] in QUIET:
            return
        head = {
            "method": request.method,
            "path": plain(request.scope.get("raw_path", b"").decode("latin-1"), _PATH_LENGTH),
            "status": status,
            "seconds": round(seconds, 4),
            "address": plain(request.client.host, _ADDRESS_LENGTH) if request.client else None,
        }
        level = logging.WARNING if status >= 500 else logging.INFO
        logs.event(_log, level, "request", head | facts)
