"""The door: how many connections there may be, which give way, and who watches how long they take."""

import asyncio
import logging
from typing import Any, Protocol

from ..wire.problems import Problem
from ..workers import logs
from .metrics import Metrics
from .settings import Settings

TICK = 0.25
"""Seconds between two looks at the connections: times are kept to about a quarter of a second."""
AT_THE_DOOR = 32
"""Connections over the limit that may linger to read why they are refused; others are closed at once."""
Address = tuple[str, int] | None
_log = logging.getLogger(logs.DOOR)


class Guest(Protocol):
    """A connection, as the door sees it."""

    transport: Any

    def check(self, now: float, seconds: float) -> None: ...


class Door:
    """The connections of a service, of which so many have a place.

    Where all are taken, the one that has waited longest gives way to a new one: for a request, or for events
    that it sends on. Any other request that is answered is never cut off for another: where all places have
    one, who comes is refused.
    """

    def __init__(self, settings: Settings, metrics: Metrics) -> None:
        self.settings, self._metrics = settings, metrics
        self._inside: set[Guest] = set()
        self._idle: dict[Guest, None] = {}

    def admit(self, guest: Guest) -> bool:
        """Whether there is a place for this connection."""
        if len(self._inside) >= self.settings.max_connections and not self._make_room():
            return False
        self._inside.add(guest)
        self.waits(guest)
        return True

    def waits(self, guest: Guest) -> None:
        """This connection has no request under way, or one that waits for events, and can go on elsewhere."""
        if guest in self._inside:
            self._idle[guest] = None

    def works(self, guest: Guest) -> None:
        """A request of this connection begins to be answered."""
        self._idle.pop(guest, None)

    def leaves(self, guest: Guest) -> None:
        """This connection is closed, or about to be."""
        self._inside.discard(guest)
        self._idle.pop(guest, None)

    def refused(self, client: Address, problem: Problem, request_id: str) -> None:
        """Count and tell what the application never hears of."""
        self._metrics.answered({"problem": problem.slug})
        facts = {"request_id": request_id, "status": problem.status, "address": _host(client)}
        logs.event(_log, logging.WARNING, f"refused at the door: {problem.slug}", facts)

    def given_up(self, client: Address) -> None:
        """Tell of an answer that its client does not take."""
        logs.event(_log, logging.WARNING, "a client does not take its answer", {"address": _host(client)})

    async def watch(self, connections: set[Any]) -> None:
        """Look after all connections, of which the refused have no place, until this task is cancelled."""
        clock = asyncio.get_running_loop().time
        before = clock()
        while True:
            await asyncio.sleep(TICK)
            now = clock()
            # A service that was held up itself must not take it out on its clients.
            seconds = min(now - before, 2 * TICK)
            for guest in list(connections):
                self._look_at(guest, now, seconds)
            before = now

    def _look_at(self, guest: Guest, now: float, seconds: float) -> None:
        try:
            guest.check(now, seconds)
        except Exception:  # the others must be watched still
            _log.exception("a connection cannot be watched: it is closed")
            guest.transport.abort()

    def _make_room(self) -> bool:
        oldest = next(iter(self._idle), None)
        if oldest is None:
            return False
        _log.warning(
            "All %d places are taken (max_connections): those that wait for requests or events give way",
            self.settings.max_connections,
        )
        self.leaves(oldest)
        oldest.transport.close()
        return True


def _host(client: Address) -> str | None:
    return None if client is None else client[0]
