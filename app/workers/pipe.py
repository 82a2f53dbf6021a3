"""The pipe between the service and a worker process: messages are their length, then their pickle."""

import asyncio
import pickle
import socket
import struct
from typing import Any

TAKEN = b"\1"
"""What a worker sends as soon as it has a job."""

_LENGTH = struct.Struct("<Q")
_HEAD = len(TAKEN) + _LENGTH.size


def packed(message: Any) -> bytes:
    """A message as it goes through the pipe."""
    content = pickle.dumps(message, pickle.HIGHEST_PROTOCOL)
    return _LENGTH.pack(len(content)) + content


def read(pipe: socket.socket) -> bytearray:
    """The pickle of the next message, which a worker waits for; nothing at the end."""
    head = _read(pipe, _LENGTH.size)
    return _read(pipe, *_LENGTH.unpack(head)) if head else head


def _read(pipe: socket.socket, length: int) -> bytearray:
    """So many bytes, or none at the end."""
    content, size = bytearray(length), 0
    while size < length:
        received = pipe.recv_into(memoryview(content)[size:])
        if not received:
            return bytearray()
        size += received
    return content


class Pipe(asyncio.Protocol):
    """The service's end: sends a job, and waits for `TAKEN` and the message that answers it.

    Nothing lies between the socket and the one who waits: every turn of the event loop counts in an answer.
    """

    def __init__(self) -> None:
        self._transport: asyncio.Transport
        self._received = bytearray()
        self._needed = _HEAD
        self._waiter: asyncio.Future[None] | None = None
        self.closed = False

    @property
    def taken(self) -> bool:
        """Whether the worker has the job: it sent something."""
        return bool(self._received)

    def send(self, job: Any) -> None:
        """Hand over a job."""
        self._transport.write(packed(job))

    async def message(self) -> Any:
        """What comes behind `TAKEN`; raises `ConnectionError` where the pipe ends before."""
        if len(self._received) < self._needed:
            if self.closed:
                raise ConnectionResetError
            self._waiter = asyncio.get_running_loop().create_future()
            await self._waiter
        content, self._received, self._needed = self._received, bytearray(), _HEAD
        return pickle.loads(memoryview(content)[_HEAD:])

    def abort(self) -> None:
        """Close it at once."""
        self.closed = True
        self._transport.abort()

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Keep the transport."""
        self._transport = transport  # type: ignore[assignment]

    def data_received(self, data: bytes) -> None:
        """Collect a message, and tell who waits for it when it is whole."""
        self._received += data
        if self._needed == _HEAD <= len(self._received):
            self._needed += _LENGTH.unpack_from(self._received, len(TAKEN))[0]
        if len(self._received) >= self._needed > _HEAD and self._waiter and not self._waiter.done():
            self._waiter.set_result(None)

    def eof_received(self) -> None:
        """The process has ended, or is about to."""
        self.closed = True

    def connection_lost(self, error: Exception | None) -> None:
        """Tell who waits that nothing comes any more."""
        self.closed = True
        if self._waiter and not self._waiter.done():
            self._waiter.set_exception(ConnectionResetError())
