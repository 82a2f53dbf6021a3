"""The door: who asks, how often, and whether a key is needed, before a byte of the body is read."""

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ..wire.problems import RateLimitedError, UnauthorizedError, respond
from . import viewer
from .keys import Keys
from .rate_limit import RateLimit

OPEN = (viewer.ROOT, *viewer.PATHS, "/livez", "/readyz", "/docs", "/openapi.json")
"""Paths that need no key: probes, pages, and what describes the API, in which nothing is secret."""
UNLIMITED = ("/livez", "/readyz", "/metrics")


class Guard:
    """Lets a request through if its client has a key, where there are keys, and has not asked too often."""

    def __init__(self, app: ASGIApp, access: "Access") -> None:
        self.app, self._access = app, access

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        request = Request(scope)
        try:
            told = self._access.check(request)
        except (RateLimitedError, UnauthorizedError) as error:
            await respond(request, error)(scope, receive, send)
            return

        async def send_with_limits(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(told)
            await send(message)

        await self.app(scope, receive, send_with_limits if told else send)


class Access:
    """Whose keys are known, and how often one client may ask; both may change while the service runs."""

    def __init__(self, keys: Keys, rate_limit: str | None) -> None:
        self._rate: str | None = None
        self._limit: RateLimit | None = None
        self.renew(keys, rate_limit)

    def renew(self, keys: Keys, rate_limit: str | None) -> None:
        """Go by these from now on; what was counted stays where the rate does."""
        self._keys = keys
        if rate_limit != self._rate:
            self._rate, self._limit = rate_limit, None if rate_limit is None else RateLimit(rate_limit)

    @property
    def asks_for_keys(self) -> bool:
        """Whether only those may ask who have one."""
        return bool(self._keys)

    def check(self, request: Request) -> dict[str, str]:
        """Headers that tell the client how often it may ask; raises the reason to refuse it."""
        # What the router goes by: `request.url` is put together with the header Host.
        path, key = request.scope["path"], _key(request.headers)
        name = self._keys.owner(key) if key else None
        request.state.facts["client"] = name
        told = {}
        if self._limit is not None and path not in UNLIMITED:
            told = self._limit.hit(name, request.client.host if request.client else "")
        # OPTIONS tells of a path what /openapi.json does.
        if self._keys and name is None and path not in OPEN and request.method != "OPTIONS":
            raise UnauthorizedError(
                "the API key is not known"
                if key
                else "send an API key in the header Authorization, after the word Bearer, or in X-API-Key"
            )
        return told


def _key(headers: Headers) -> str:
    """The key that came with a request, empty if none did."""
    scheme, _, key = headers.get("authorization", "").partition(" ")
    return key.strip() if scheme.lower() == "bearer" else headers.get("x-api-key", "").strip()
