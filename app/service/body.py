"""A request body received within a limit: in memory if small, else in a file that ends with the request."""

import asyncio
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

from starlette.requests import ClientDisconnect, Request

from ..wire.problems import BodyTimeoutError, BodyTooLargeError
from .settings import Settings

_IN_MEMORY = 128 * 1024
_DRAIN_SECONDS, _DRAIN_IDLE_SECONDS = 5.0, 0.5


@asynccontextmanager
async def received(request: Request, settings: Settings) -> AsyncIterator[bytes | Path]:
    """The body, as bytes or as a file that is removed afterwards, whatever happens.

    Raises
    ------
    BodyTooLargeError
        The body is over the limit, counted while reading whatever its Content-Length says.
    BodyTimeoutError
        The client stopped sending.
    """
    pieces = _pieces(request, settings)
    first: list[bytes] = []
    size = 0
    async for piece in pieces:
        first.append(piece)
        size += len(piece)
        if size > _IN_MEMORY:
            break
    else:
        yield b"".join(first)
        return
    with tempfile.NamedTemporaryFile(prefix="primfit-", dir=settings.temporary_directory) as file:
        await asyncio.to_thread(file.writelines, first)
        async for piece in pieces:
            await asyncio.to_thread(file.write, piece)
        file.flush()
        yield Path(file.name)


async def _pieces(request: Request, settings: Settings) -> AsyncIterator[bytes]:
    """The pieces of the body as they arrive, as long as their sum is within the limit."""
    limit, size = settings.max_body_bytes, 0
    announced = request.headers.get("content-length", "")
    if announced.isdecimal() and int(announced[:20]) > limit:
        raise await _too_large(request, limit)
    more = True
    while more:
        try:
            async with asyncio.timeout(settings.receive_timeout):
                message = await request.receive()
        except TimeoutError:
            raise BodyTimeoutError(
                f"nothing came for {settings.receive_timeout:g} s before the body was complete ({size} bytes)"
            ) from None
        if message["type"] == "http.disconnect":
            raise ClientDisconnect
        piece, more = message.get("body", b""), message.get("more_body", False)
        size += len(piece)
        if size > limit:
            raise await _too_large(request, limit, more)
        yield piece


async def _too_large(request: Request, limit: int, more: bool = True) -> BodyTooLargeError:
    """Read on for a moment without keeping anything: a client still sending would not see the answer.

    `more` says whether something may come still.
    """
    if more and "expect" not in request.headers:
        with suppress(TimeoutError, StopAsyncIteration, RuntimeError):
            async with asyncio.timeout(_DRAIN_SECONDS):
                stream = aiter(request.stream())
                while True:
                    async with asyncio.timeout(_DRAIN_IDLE_SECONDS):
                        await anext(stream)
    return BodyTooLargeError("body", f"the body is over {limit} bytes, the limit of this service")
