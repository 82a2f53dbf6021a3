"""A request body received within limits: in memory if small, else in a file that ends with the request."""

import asyncio
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

from starlette.requests import ClientDisconnect, Request

from ..wire.problems import BodyTooLargeError, room_needed
from .spool import Share, Spool

_IN_MEMORY = 128 * 1024
_LARGE = 4 * 1024 * 1024
"""Bytes: some 80,000 points as text, which take about half a second."""


def announced(request: Request) -> int:
    """The length of the body as its head says it; 0 where it does not."""
    length = request.headers.get("content-length", "")
    return int(length[:20]) if length.isdecimal() else 0


def size(body: bytes | Path) -> int:
    """Of a body that was received."""
    return len(body) if isinstance(body, bytes) else body.stat().st_size


def is_large(n_bytes: int) -> bool:
    """Whether a cloud of this size takes so long that it should not hold up others."""
    return n_bytes > _LARGE


@asynccontextmanager
async def received(request: Request, limit: int, spool: Spool) -> AsyncIterator[bytes | Path]:
    """The body of at most `limit` bytes, as bytes or as a file that is removed afterwards, whatever happens.

    Raises
    ------
    BodyTooLargeError
        The body is over the limit, counted while reading whatever its Content-Length says.
    InsufficientStorageError
        There is no room for it: so many others are being read.
    ClientDisconnect
        The connection ended before the body was complete.
    """
    async with AsyncExitStack() as resources:
        share = resources.enter_context(spool.share())
        pieces = _pieces(request, limit, share)
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
        file = resources.enter_context(spool.file())
        with room_needed():
            await asyncio.to_thread(file.writelines, first)
            async for piece in pieces:
                await asyncio.to_thread(file.write, piece)
            await asyncio.to_thread(file.flush)
        yield Path(file.name)


async def _pieces(request: Request, limit: int, share: Share) -> AsyncIterator[bytes]:
    """The pieces of the body as they arrive, as long as their sum is within the limit and has room."""
    size, more = 0, True
    _check(announced(request), limit, share)
    while more:
        message = await request.receive()
        if message["type"] == "http.disconnect":
            raise ClientDisconnect
        piece, more = message.get("body", b""), message.get("more_body", False)
        size += len(piece)
        _check(size, limit, share)
        yield piece


def _check(size: int, limit: int, share: Share) -> None:
    if size > limit:
        raise BodyTooLargeError("body", f"the body is over {limit} bytes, the limit of this service")
    if size > _IN_MEMORY:
        share.reach(size)
