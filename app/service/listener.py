"""A listening socket that does not keep the service from its other work, nor fill its log."""

import socket

_IN_A_ROW = 64
"""Connections taken before others have their turn. asyncio would take as many as wait, 2,048 at most."""


class Listener(socket.socket):
    """Hands out connections in small lots; where descriptors have run out, asyncio hears of it once a second.

    asyncio then waits a second, but before it does it tries on as often as connections may wait, complains
    each time, and after the second does so as many times again.
    """

    _taken = 0

    def accept(self) -> tuple[socket.socket, object]:
        """The next connection; `BlockingIOError`, upon which asyncio stops for now, also after each lot."""
        if self._taken >= _IN_A_ROW:
            self._taken = 0
            raise BlockingIOError
        self._taken += 1
        try:
            return super().accept()
        except BlockingIOError:
            self._taken = 0
            raise
        except OSError:
            self._taken = _IN_A_ROW
            raise
