"""Upload tickets: one file each, within the limit, and nothing is left of them in the end."""

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from starlette.requests import ClientDisconnect, Request

from primfit.app.agents import tickets
from primfit.app.agents.tickets import SECONDS, Tickets
from primfit.app.readers.errors import TooLargeError
from primfit.app.service.spool import Spool
from primfit.app.wire.problems import BusyError, NoSuchTicketError, TicketUsedError

LIMIT = 400_000
LARGE = bytes(300_000)
"""More than is kept in memory."""


@pytest.fixture
def desk(tmp_path: Path) -> Tickets:
    return Tickets(Spool(tmp_path, 10 * LIMIT, 1), LIMIT)


def _request(*pieces: bytes, ends: bool = True) -> Request:
    """A request whose body comes in pieces, or whose client leaves after them."""
    messages: list[dict[str, Any]] = [
        {"type": "http.request", "body": each, "more_body": True} for each in pieces
    ]
    messages.append({"type": "http.request"} if ends else {"type": "http.disconnect"})

    async def receive() -> dict[str, Any]:
        return messages.pop(0)

    return Request({"type": "http", "headers": []}, receive)


def _run(work: Callable[[], Any]) -> Any:
    return asyncio.run(work())


@pytest.mark.parametrize("body", [b"1,2,3", LARGE], ids=["in memory", "in a file"])
def test_a_ticket_stands_for_the_file_until_it_ends(desk: Tickets, tmp_path: Path, body: bytes) -> None:
    async def work() -> None:
        async with desk.kept():
            name = desk.new()
            assert await desk.receive(name, _request(body)) == len(body)
            assert desk.find(name).read(LIMIT) == body
            with pytest.raises(TicketUsedError):
                await desk.receive(name, _request(body))
        assert list(tmp_path.iterdir()) == [] and desk.spool.used == 0
        with pytest.raises(NoSuchTicketError):
            desk.find(name)

    _run(work)


def test_its_time_begins_again_with_each_use(desk: Tickets, monkeypatch: pytest.MonkeyPatch) -> None:
    now = 1000.0
    monkeypatch.setattr(tickets.time, "monotonic", lambda: now)

    async def work() -> None:
        nonlocal now
        name = desk.new()
        now += SECONDS - 1
        await desk.receive(name, _request(LARGE))
        now += SECONDS - 1
        desk.find(name)
        await desk.sweep()
        now += SECONDS
        with pytest.raises(NoSuchTicketError, match="unknown, or was not used for 600 s"):
            desk.find(name)
        await desk.sweep()
        assert desk.spool.used == 0

    _run(work)


def test_what_is_too_large_is_refused_and_the_ticket_can_be_used_again(desk: Tickets, tmp_path: Path) -> None:
    async def work() -> None:
        name = desk.new()
        with pytest.raises(TooLargeError, match=f"over {LIMIT} bytes"):
            await desk.receive(name, _request(LARGE, LARGE))
        with pytest.raises(ClientDisconnect):
            await desk.receive(name, _request(LARGE, ends=False))
        assert list(tmp_path.iterdir()) == [] and desk.spool.used == 0
        with pytest.raises(NoSuchTicketError, match="nothing was uploaded"):
            desk.find(name)
        assert await desk.receive(name, _request(b"1")) == 1

    _run(work)


def test_tickets_are_unguessable_and_not_endless(desk: Tickets) -> None:
    names = {desk.new() for _ in range(tickets.MOST)}
    assert len(names) == tickets.MOST and min(map(len, names)) >= 32
    with pytest.raises(BusyError, match="limit of this server"):
        desk.new()
