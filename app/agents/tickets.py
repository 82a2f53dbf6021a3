"""Upload tickets: each stands for one file that a client sends, and ends after a while."""

import secrets
import time
from collections.abc import AsyncIterator
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

from starlette.requests import Request

from ..service.body import received
from ..service.spool import Spool
from ..wire.problems import BusyError, NoSuchTicketError, TicketUsedError

SECONDS = 600.0
"""Between the last use of a ticket and its end."""

MOST = 100
"""Tickets at a time."""


@dataclass(frozen=True)
class Uploaded:
    """A file that was uploaded; it has no name."""

    content: bytes | Path
    name: None = None

    def read(self, limit: int) -> bytes:
        """All bytes; `FileNotFoundError` where the ticket ended meanwhile."""
        return self.content if isinstance(self.content, bytes) else self.content.read_bytes()


@dataclass
class _Ticket:
    """What is known of one: when it ends, whether its file is on the way, the file, and what ends with it."""

    ends: float
    is_used: bool = False
    content: bytes | Path | None = None
    resources: AsyncExitStack = field(default_factory=AsyncExitStack)


class Tickets:
    """All that are open. A file takes one ticket, and is removed when that ends.

    Parameters
    ----------
    spool : where files are kept, and how many bytes of them
    limit : most bytes of a file
    """

    def __init__(self, spool: Spool, limit: int) -> None:
        self.spool, self.limit = spool, limit
        self._open: dict[str, _Ticket] = {}

    def new(self) -> str:
        """A ticket for one upload; raises `BusyError` where too many are open."""
        if len(self._open) >= MOST:
            raise BusyError(
                f"{MOST} upload tickets are open, the limit of this server; each ends after a while"
            )
        name = secrets.token_urlsafe(24)
        self._open[name] = _Ticket(time.monotonic() + SECONDS)
        return name

    async def receive(self, name: str, request: Request) -> int:
        """Keep the body of a request as the file of a ticket; its size in bytes.

        Raises
        ------
        NoSuchTicketError
            It is unknown.
        TicketUsedError
            It has a file, or will have.
        BodyTooLargeError, InsufficientStorageError, ClientDisconnect
            As `received`; the ticket may be used again.
        """
        ticket = self._ticket(name)
        if ticket.is_used:
            raise TicketUsedError("this ticket was used; ask the tool upload for another")
        ticket.is_used = True
        try:
            content = await ticket.resources.enter_async_context(received(request, self.limit, self.spool))
        except BaseException:
            ticket.is_used = False
            raise
        if self._open.get(name) is not ticket:
            await ticket.resources.aclose()
            raise _unknown()
        ticket.content, ticket.ends = content, time.monotonic() + SECONDS
        return len(content) if isinstance(content, bytes) else content.stat().st_size

    def find(self, name: str) -> Uploaded:
        """The file of a ticket; raises `NoSuchTicketError` where there is none yet, or no more."""
        ticket = self._ticket(name)
        if ticket.content is None:
            raise NoSuchTicketError("nothing was uploaded with this ticket yet: PUT the file to its URL")
        ticket.ends = time.monotonic() + SECONDS
        return Uploaded(ticket.content)

    async def sweep(self, now: float | None = None) -> None:
        """End those whose time is over; their files go."""
        now = time.monotonic() if now is None else now
        for name, ticket in list(self._open.items()):
            if ticket.ends <= now:
                del self._open[name]
                await ticket.resources.aclose()

    @asynccontextmanager
    async def kept(self) -> AsyncIterator[None]:
        """For the life of a server: at its end all tickets end."""
        try:
            yield
        finally:
            await self.sweep(float("inf"))

    def _ticket(self, name: str) -> _Ticket:
        ticket = self._open.get(name)
        if ticket is None or ticket.ends <= time.monotonic():
            raise _unknown()
        return ticket


def _unknown() -> NoSuchTicketError:
    return NoSuchTicketError(f"this ticket is unknown, or was not used for {SECONDS:g} s; upload again")
