"""Which names the service answers to, and which pages of elsewhere may ask, see and send what (CORS)."""

import ipaddress
import re
from collections.abc import Collection
from functools import lru_cache

from fastapi import FastAPI
from starlette.middleware.cors import CORSMiddleware
from starlette.requests import Request
from starlette.types import ASGIApp, Receive, Scope, Send

from ..wire.problems import ForeignOriginError, MalformedRequestError, ServiceError, WrongHostError, respond

ANY = "*"
PROBES = ("/livez", "/readyz")
"""Asked by the address of a container, or any name, and telling nothing."""
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[^:\[\]]*)(:\d*)?")
"""A name or an address, and a port."""
_DEFAULT_PORT = re.compile(r":(80|443)\Z")
"""Of either scheme: a browser leaves it out where a proxy may put it in."""
_KNOWN_NAMES = 256
"""Hosts whose admission is remembered: usually there are one or two."""
_SENT = (
    "Authorization",
    "Content-Encoding",
    "Content-Type",
    "Idempotency-Key",
    "If-None-Match",
    "Last-Event-ID",
    "Prefer",
    "traceparent",
    "tracestate",
    "X-API-Key",
    "X-Request-Id",
)
_SEEN = (
    "Content-Disposition",
    "ETag",
    "Link",
    "Location",
    "Preference-Applied",
    "RateLimit",
    "RateLimit-Policy",
    "Retry-After",
    "Server-Timing",
    "X-Request-Id",
)


def share_with(app: FastAPI, origins: Collection[str]) -> None:
    """Let the scripts of these origins ask, if there are any.

    To be added outside of the guard: a browser asks for permission without a key.
    """
    if origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=list(origins),
            allow_methods=["DELETE", "GET", "HEAD", "POST"],
            allow_headers=_SENT,
            expose_headers=_SEEN,
        )


class Addressee:
    """Refuses requests to hosts that are not this service, and those of pages whose origin may not ask.

    A page can have its own name lead to this machine, and then ask a service that listens here for its user
    only (DNS rebinding): its name still stands in `Host`. A page that asks another origin has its own in
    `Origin`; that both are one, browsers say in `Sec-Fetch-Site`, also where a proxy has changed `Host`.

    Parameters
    ----------
    hosts
        Names, or patterns such as `*.example.com`; without any, all.
    local
        Without hosts: whether only names of the loopback addresses are allowed.
    origins
        Origins that may ask although they differ from the host, as CORS has them.
    """

    def __init__(self, app: ASGIApp, hosts: Collection[str], local: bool, origins: Collection[str]) -> None:
        self.app, self._origins = app, frozenset(origins)
        self._may_be_asked = lru_cache(_KNOWN_NAMES)(lambda host: _is_allowed(host, hosts, local))

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        error = self._refusal(scope) if scope["type"] == "http" else None
        if error is None:
            await self.app(scope, receive, send)
        else:
            await respond(Request(scope), error)(scope, receive, send)

    def _refusal(self, scope: Scope) -> ServiceError | None:
        hosts, origin, site = [], None, b""
        for name, value in scope["headers"]:
            if name == b"host":
                hosts.append(value)
            elif name == b"origin":
                origin = value
            elif name == b"sec-fetch-site":
                site = value
        if len(hosts) > 1 or (not hosts and scope["http_version"] == "1.1"):
            return MalformedRequestError(f"the header Host is needed once; there are {len(hosts)}")
        host = hosts[0] if hosts else b""
        if not self._may_be_asked(host) and scope["path"] not in PROBES:
            return WrongHostError(
                "the header Host names another service; the setting allowed_hosts says what is allowed"
            )
        if origin is not None and site != b"same-origin" and not self._may_ask(origin, host):
            return ForeignOriginError(
                "the origin of the page differs from the host; the setting cors_origins says which may ask"
            )
        return None

    def _may_ask(self, origin: bytes, host: bytes) -> bool:
        """Whether both are one, but for the scheme, which may end at a proxy, or the origin is allowed."""
        told = origin.decode("latin-1").lower()
        page = _DEFAULT_PORT.sub("", told.partition("://")[2])
        same = page != "" and page == _DEFAULT_PORT.sub("", host.decode("latin-1").lower())
        return same or ANY in self._origins or told in self._origins


def _is_allowed(host: bytes, hosts: Collection[str], local: bool) -> bool:
    found = _HOST.fullmatch(host.decode("latin-1").lower())
    name = found[1].removesuffix(".") if found else ""
    if hosts:
        return ANY in hosts or name in hosts or any(f"*.{rest}" in hosts for rest in _parents(name))
    return not local or _is_loopback_name(name)


def _parents(name: str) -> list[str]:
    """`b.c` and `c` of `a.b.c`."""
    parts = name.split(".")
    return [".".join(parts[i:]) for i in range(1, len(parts))]


def _is_loopback_name(name: str) -> bool:
    if name == "localhost" or name.endswith(".localhost"):
        return True
    try:
        address = ipaddress.ip_address(name.strip("[]"))
        return (getattr(address, "ipv4_mapped", None) or address).is_loopback
    except ValueError:
        return False
