"""An id for every request, in the log, in problem documents and in the header X-Request-Id; and its trace."""

import re
import uuid
from contextvars import ContextVar

from starlette.datastructures import MutableHeaders
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from .trace_context import TRACE_ID, caller

REQUEST_ID: ContextVar[str | None] = ContextVar("request_id", default=None)
"""The request that is worked on, for every line of the log that is written meanwhile."""

_USABLE = re.compile(r"[A-Za-z0-9._-]{1,64}")


class RequestId:
    """Gives each request an id, the client's own where it sent a usable one, and notes its trace."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        given = dict(scope["headers"]).get(b"x-request-id", b"").decode("latin-1")
        request_id = given if _USABLE.fullmatch(given) else str(uuid.uuid4())
        state, asks = scope.setdefault("state", {}), caller(scope["headers"])
        state["request_id"], state["caller"] = request_id, asks
        REQUEST_ID.set(request_id)
        TRACE_ID.set(None if asks is None else asks.trace_id)

        async def send_with_id(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message)["X-Request-Id"] = request_id
            await send(message)

        await self.app(scope, receive, send_with_id)
