"""The MCP server over streamable HTTP: its door, and the route that files are uploaded by."""

import asyncio
import logging
import signal
import socket
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import Any

from mcp.server.mcpserver import MCPServer
from mcp.server.transport_security import TransportSecuritySettings
from starlette.applications import Starlette
from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Mount, Route
from starlette.types import ASGIApp, Receive, Scope, Send

from ..readers.errors import TooLargeError
from ..service.browsers import Addressee
from ..service.guard import Access, Guard
from ..service.metrics import Metrics
from ..service.server import WatchedServer, is_loopback, listen, renewed
from ..service.settings import Settings, SettingsError
from ..wire.problems import ServiceError, respond
from ..workers import logs
from ..workers.request_id import RequestId
from .places import Places
from .server import running
from .tools import Tools

PATH = "/mcp"
RENEWABLE = ("api_keys", "api_keys_file", "rate_limit")
"""Settings that SIGHUP has read again."""
_LOCAL = ("127.0.0.1", "localhost", "[::1]")
_log = logging.getLogger("primfit")


def serve_http(settings: Settings, places: Places, flags: Mapping[str, Any]) -> None:
    """Serve until a signal stops it; at SIGHUP keys and the rate of requests are read again.

    `flags` are the settings of the command line.

    Raises
    ------
    ListenError
        It cannot listen there.
    SettingsError
        Others than this machine would reach it, and it has no API keys.
    """
    with listen(settings.host, settings.port) as listener:
        address, port = listener.getsockname()[:2]
        local = is_loopback(address)
        if not local and not settings.keys():
            raise SettingsError(
                f"--host: others reach {address}, so that API keys are needed: set PRIMFIT_API_KEYS"
            )
        logs.configure(settings.log_format)
        _log.info("Listening on %s port %d", address, port)
        signal.signal(signal.SIGTERM, lambda *_: sys.exit())
        access = Access(settings.keys(), settings.rate_limit)
        if hasattr(signal, "SIGHUP"):
            signal.signal(signal.SIGHUP, lambda *_: renewed(settings, flags, access, RENEWABLE))
        try:
            asyncio.run(_serve(settings, places, listener, local, access))
        except KeyboardInterrupt:
            pass


async def _serve(
    settings: Settings, places: Places, listener: socket.socket, local: bool, access: Access
) -> None:
    async with running(settings, places, uploads=True) as (server, tools):
        app = application(settings, server, tools, local, access)
        await WatchedServer(app, settings, Metrics()).serve([listener])


def application(
    settings: Settings, server: MCPServer[Any], tools: Tools, local: bool, access: Access
) -> ASGIApp:
    """The ASGI application: tools behind a key where there are keys, uploads behind their tickets.

    Neither answers to a foreign name, nor to pages of elsewhere.
    """
    protocol = server.streamable_http_app(
        streamable_http_path=PATH, transport_security=_security(settings, local)
    )

    async def upload(request: Request) -> Response:
        return await _uploaded(tools, request)

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        async with server.session_manager.run():
            yield

    guarded = Guard(protocol, access)
    routes = [Route("/uploads/{ticket}", upload, methods=["PUT"]), Mount("/", guarded)]
    app = Addressee(
        Starlette(routes=routes, lifespan=lifespan),
        hosts=settings.allowed_hosts,
        local=local,
        origins=settings.cors_origins,
    )
    return RequestId(_WithFacts(app))


class _WithFacts:
    """Gives each request the facts that the door of the service writes down."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            scope["state"] = {**scope.get("state", {}), "facts": {}}
        await self.app(scope, receive, send)


def _security(settings: Settings, local: bool) -> TransportSecuritySettings:
    """The checks of the package beside those of `Addressee`: it knows no patterns of names."""
    names = settings.allowed_hosts or (_LOCAL if local else ())
    plain = [name for name in names if "*" not in name]
    hosts = [host for name in plain for host in (name, f"{name}:*")]
    origins = [f"{scheme}://{host}" for host in hosts for scheme in ("http", "https")]
    return TransportSecuritySettings(
        enable_dns_rebinding_protection=bool(plain) and len(plain) == len(names),
        allowed_hosts=hosts,
        allowed_origins=[*origins, *settings.cors_origins],
    )


async def _uploaded(tools: Tools, request: Request) -> Response:
    """Keep the body of a request under its ticket; problems are told as the service tells them."""
    assert tools.tickets is not None
    ticket = request.path_params["ticket"]
    try:
        n_bytes = await tools.tickets.receive(ticket, request)
    except ClientDisconnect:
        return Response(status_code=400)
    except (ServiceError, TooLargeError) as error:
        return respond(request, error)
    return JSONResponse({"ticket": ticket, "n_bytes": n_bytes}, 201)
