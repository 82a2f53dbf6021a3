"""Requests at a rate, whatever becomes of them, from one thread that does as little as it can for each.

The service and its clients share a machine: a client of asyncio takes 0.7 ms of the processor for a request,
about half of what the service takes to refuse it. On another machine it would take nothing.
"""

import select
import socket
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from itertools import cycle
from time import perf_counter

from tests.fire.load import PATIENCE, Answer

_LENGTH = b"content-length: "
_AT_ONCE = 256 * 1024


class _Line:
    """A connection with one request under way, or none."""

    def __init__(self, port: int, poll: select.epoll) -> None:
        self._port, self._poll = port, poll
        self._socket: socket.socket | None = None
        self.waits = False
        self._received, self._rest, self._sent = b"", memoryview(b""), 0.0

    def ask(self, content: bytes) -> int:
        """Send it, as far as the system takes it; returns the descriptor, by which events come."""
        if self._socket is None:
            self._socket = socket.create_connection(("127.0.0.1", self._port), PATIENCE)
            self._socket.setblocking(False)
            self._poll.register(self._socket, select.EPOLLIN)
        self.waits = True
        self._sent, self._received, self._rest = perf_counter(), b"", memoryview(content)
        self.send()
        return self._socket.fileno()

    def send(self) -> None:
        """Send more of it; what is cut off is told by what is received."""
        assert self._socket is not None
        with suppress(OSError):
            self._rest = self._rest[self._socket.send(self._rest) :]
        wanted = select.EPOLLIN | (select.EPOLLOUT if self._rest else 0)
        self._poll.modify(self._socket, wanted)

    def receive(self) -> Answer | None:
        """The answer, once it is whole; status 0 where the connection ended before."""
        assert self._socket is not None
        try:
            piece = self._socket.recv(_AT_ONCE)
        except OSError:
            piece = b""
        self._received += piece
        whole = self._is_whole()
        if piece and not whole:
            return None
        self.waits, status = False, int(self._received[9:12]) if whole else 0
        if not piece or b"\r\nconnection: close\r\n" in self._received:
            self.close()
        return Answer(status, self._sent, perf_counter() - self._sent)

    def _is_whole(self) -> bool:
        head = self._received.find(b"\r\n\r\n")
        if head < 0:
            return False
        at = self._received.lower().find(_LENGTH, 0, head) + len(_LENGTH)
        return len(self._received) >= head + 4 + int(self._received[at : self._received.find(b"\r", at)])

    def close(self) -> None:
        """Close it; the next request opens it again."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None


def at_rate(
    port: int, requests: Sequence[bytes], rate: float, n_clients: int, seconds: float
) -> list[Answer]:
    """So many requests a second, each on a connection that has none under way; late only where all have."""
    with select.epoll() as poll:
        return _Flood(port, poll, n_clients).run(requests, rate, seconds)


class _Flood:
    """Connections that are idle, and all that were opened, by their descriptors."""

    def __init__(self, port: int, poll: select.epoll, n_clients: int) -> None:
        self._poll = poll
        self._idle = deque(_Line(port, poll) for _ in range(n_clients))
        self._opened: dict[int, _Line] = {}
        self._answers: list[Answer] = []
        self._n_sent = 0

    def run(self, requests: Sequence[bytes], rate: float, seconds: float) -> list[Answer]:
        start = perf_counter()
        for content in cycle(requests):
            while (left := start + self._n_sent / rate - perf_counter()) > 0 or not self._idle:
                self._look(max(left, 0.0) if self._idle else 1.0)
            if perf_counter() >= start + seconds:
                break
            line = self._idle.popleft()
            self._opened[line.ask(content)] = line
            self._n_sent += 1
        end = perf_counter() + PATIENCE
        while self._n_sent > len(self._answers) and perf_counter() < end:
            self._look(1.0)
        for line in self._opened.values():
            line.close()
        n_lost = self._n_sent - len(self._answers)
        return self._answers + [Answer(-1, start, PATIENCE)] * n_lost

    def _look(self, patience: float) -> None:
        """Note the answers that come within so many seconds, of which the first ends the waiting."""
        for descriptor, event in self._poll.poll(patience):
            line = self._opened[descriptor]
            if not line.waits:  # the service closes it
                line.close()
                continue
            if event & select.EPOLLOUT:
                line.send()
            if event & ~select.EPOLLOUT and (answer := line.receive()) is not None:
                self._answers.append(answer)
                self._idle.append(line)
