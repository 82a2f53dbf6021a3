"""Connections as bytes, for tests of what a client may do to a service."""

import contextlib
import socket
import time

from tests.app.serving import PATIENCE

GET = b"GET /livez HTTP/1.1\r\nHost: localhost\r\n\r\n"
POST = b"POST /fit HTTP/1.1\r\nHost: localhost\r\nContent-Type: text/csv\r\n"


def connected(port: int, request: bytes = b"", receive_buffer: int | None = None) -> socket.socket:
    """A connection on which this was sent."""
    connection = socket.socket()
    if receive_buffer is not None:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
    connection.settimeout(PATIENCE)
    connection.connect(("127.0.0.1", port))
    connection.sendall(request)
    return connection


def rest(connection: socket.socket) -> bytes:
    """What comes until the service closes the connection."""
    pieces = []
    with contextlib.suppress(ConnectionResetError):
        while piece := connection.recv(1 << 16):
            pieces.append(piece)
    return b"".join(pieces)


def one_answer(connection: socket.socket) -> bytes:
    """The next answer of a known length, however many pieces it comes in."""
    received = b""
    while (head := received.partition(b"\r\n\r\n"))[1] == b"" or len(head[2]) < _length(head[0]):
        piece = connection.recv(1 << 16)
        assert piece, f"closed after {received!r}"
        received += piece
    return received


def _length(head: bytes) -> int:
    lines = dict(line.lower().split(b": ", 1) for line in head.split(b"\r\n")[1:])
    return int(lines[b"content-length"])


def answer(port: int, request: bytes) -> bytes:
    """What comes back for these bytes, until the service closes the connection."""
    with connected(port) as connection:
        with contextlib.suppress(ConnectionResetError, BrokenPipeError):
            connection.sendall(request)
        return rest(connection)


def statuses(answered: bytes) -> list[int]:
    """Of answers that follow one another, none of which has a status line in its body."""
    return [int(piece[:3]) for piece in answered.split(b"HTTP/1.1 ")[1:]]


def sent_until_closed(connection: socket.socket, piece: bytes, limit: float, pause: float = 0.0) -> int:
    """How many bytes go out, this piece again and again, until the service has closed the connection."""
    n_bytes, end = 0, time.monotonic() + limit
    with contextlib.suppress(ConnectionResetError, BrokenPipeError):
        while True:
            assert time.monotonic() < end, f"the service still takes bytes after {n_bytes}"
            n_bytes += connection.send(piece)
            time.sleep(pause)
    return n_bytes
