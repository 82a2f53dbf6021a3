"""A connection that nobody can hold for long, nor fill: uvicorn's, with limits on what a client may do."""

import asyncio
import socket
import sys
import uuid
from contextlib import suppress
from functools import partial
from typing import Any

import httptools
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from uvicorn.protocols.http.flow_control import HIGH_WATER_LIMIT, FlowControl
from uvicorn.protocols.http.httptools_impl import STATUS_LINE, HttpToolsProtocol, RequestResponseCycle

from ..wire.problems import (
    MEDIA_TYPE,
    BodyTimeoutError,
    HeadTimeoutError,
    HeadTooLargeError,
    MalformedRequestError,
    Problem,
    ServiceError,
    TooManyConnectionsError,
    problem,
)
from .door import AT_THE_DOOR, Door
from .pace import Pace

if sys.platform == "linux":
    from fcntl import ioctl
    from termios import TIOCOUTQ

MAX_HEAD_BYTES = 32 * 1024
"""Of the request line with the headers, and of what else may stand between two pieces of a body."""
MAX_HEADERS = 100
FREE_FRAMING = 64 * 1024
"""Bytes of a body that may be sizes of its chunks; beyond, half as many as its content."""
MAX_PIPELINED = 32
"""Requests that may wait for the answer to another on their connection; each is some kilobytes of objects."""
_LINGER_SECONDS, _LINGER_BYTES = 1.0, 2**20
"""So long, and so much, is read after an answer of a client that sends still: else it might not see it."""
_NOT_HTTP = "what came is not a request of HTTP/1.1, or its length is not certain"
_ACKED = slice(120, 128)
"""`tcpi_bytes_acked` in the `tcp_info` of Linux (linux/tcp.h)."""
_NOTHING, _HEAD, _BODY = range(3)
"""What of a request has begun to arrive."""


class Connection(HttpToolsProtocol):
    """Serves the requests of one client, as uvicorn does, and ends in time whatever the client does.

    It feeds the parser no more than a head may hold between two events of it, so that the parser never holds
    more. `check`, called a few times a second, ends the connection of a client that is late with the first
    byte, a head, a body or the next request, or that does not take its answer.
    """

    def __init__(self, door: Door, **uvicorns: Any) -> None:
        super().__init__(**uvicorns)
        settings = door.settings
        self._door = door
        self._arriving, self._unsettled = _NOTHING, 0
        self._framing = self._content = 0
        self._since = self.loop.time()
        self._patience = settings.first_byte_timeout
        self._incoming = Pace(settings.receive_timeout, settings.min_rate, settings.transfer_time_limit)
        self._outgoing = Pace(settings.send_timeout, settings.min_rate, settings.transfer_time_limit)
        self._n_taken = 0
        self._answering: RequestResponseCycle | None = None
        self._is_awaited = self._is_kept = False
        self._parting: Any = _Parting(self)
        self._last_words: bytes | None = None
        self._left: float | None = None
        self._dropped = 0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self.flow = self._flow = _Flow(transport)
        self._socket = transport.get_extra_info("socket")
        if not self._door.admit(self):
            limit = self._door.settings.max_connections
            self._refuse(TooManyConnectionsError(f"{limit} connections have a request under way; ask again"))
            if len(self.connections) > limit + AT_THE_DOOR:
                transport.close()

    def connection_lost(self, exc: Exception | None) -> None:
        self._door.leaves(self)
        super().connection_lost(exc)

    # What arrives.

    def data_received(self, data: bytes) -> None:
        if self._left is not None or self._last_words is not None:
            self._drop(len(data))
            return
        if self._arriving == _NOTHING:
            self._arriving, self._since = _HEAD, self.loop.time()
        if len(data) < MAX_HEAD_BYTES - self._unsettled:
            if not self._feed(data):
                return
        else:
            rest = memoryview(data)
            while rest:
                room = MAX_HEAD_BYTES - self._unsettled
                if not self._feed(rest[:room]):
                    return
                rest = rest[room:]
        if self._arriving == _BODY and not self._is_awaited:
            self._await_body()

    def _feed(self, data: bytes | memoryview) -> bool:
        """Have these bytes parsed; false where no more are to be."""
        self._unsettled += len(data)
        self._framing += len(data)
        try:
            self.parser.feed_data(data)
        except httptools.HttpParserUpgrade as upgrade:
            if self._is_upgrade():
                return self._feed(self._without_upgrade()) and self._feed(data[upgrade.args[0] :])
            # What would follow CONNECT is not HTTP: it is answered, and is the last one.
            self.cycle.keep_alive, self._last_words = False, b""
            return False
        except httptools.HttpParserError as error:
            reason = error.__context__
            self._refuse(reason if isinstance(reason, ServiceError) else MalformedRequestError(_NOT_HTTP))
            return False
        if self._unsettled >= MAX_HEAD_BYTES:
            self._refuse(HeadTooLargeError(f"the head of the request is over {MAX_HEAD_BYTES} bytes"))
            return False
        if self._arriving == _BODY and self._framing > FREE_FRAMING + self._content / 2:
            # Each chunk costs as much time as many bytes: others would wait.
            few = f"{self._content} bytes came with {self._framing} that say how long the chunks are"
            self._refuse(MalformedRequestError(f"{few}; send larger chunks"))
            return False
        return True

    def _is_upgrade(self) -> bool:
        """Whether the request asks for another protocol, as Java's client does with each that it sends.

        The parser then skips its body, although a server that goes on with HTTP/1.1 has to read it.
        """
        return self.parser.should_upgrade() and self.parser.get_method() != b"CONNECT"

    def _without_upgrade(self) -> bytes:
        """The head of such a request for a new parser, which reads the body: without the header `Upgrade`."""
        method, version = self.parser.get_method(), self.parser.get_http_version().encode()
        lines = [b"%s: %s" % line for line in self.headers if line[0] != b"upgrade"]
        self.parser, self._unsettled = httptools.HttpRequestParser(self), 0
        # As uvicorn sets the first one: requests after `Connection: close` are answered.
        self.parser.set_dangerous_leniencies(lenient_data_after_close=True)
        return b"\r\n".join([b"%s %s HTTP/%s" % (method, self.url, version), *lines, b"", b""])

    def on_headers_complete(self) -> None:
        if len(self.headers) > MAX_HEADERS:
            raise HeadTooLargeError(f"there are {len(self.headers)} headers; the limit is {MAX_HEADERS}")
        if len(self.pipeline) >= MAX_PIPELINED:
            raise MalformedRequestError(f"over {MAX_PIPELINED} requests wait on this connection already")
        if self._is_upgrade():
            return
        super().on_headers_complete()
        self._arriving, self._unsettled = _BODY, 0
        self._framing = self._content = 0
        # Fields after a body, which uvicorn would add to the headers of a request that is under way.
        self.headers = []
        if self.pipeline:
            self._flow.hold()

    def on_body(self, body: bytes) -> None:
        self._unsettled = 0
        self._content += len(body)
        self._framing -= len(body)
        self._incoming.moved(len(body))
        super().on_body(body)

    def on_message_complete(self) -> None:
        if self._is_upgrade():
            return
        super().on_message_complete()
        self._arriving, self._unsettled = _NOTHING, 0
        if self._is_awaited:
            self._is_awaited = False
            if not self.cycle.response_started:
                self.cycle.keep_alive, self.cycle.transport = self._is_kept, self.transport
        self._rest()

    def _await_body(self) -> None:
        """Have an answer that comes before the end of the body end the connection, unless that is near."""
        self._is_awaited, self._is_kept = True, self.cycle.keep_alive
        self.cycle.keep_alive = self._is_kept and self._is_short(self.cycle)
        self.cycle.transport = self._parting
        self._incoming.restart()

    def _is_short(self, cycle: RequestResponseCycle) -> bool:
        """Whether a body is certain to come, and so short that the connection can wait for its end."""
        length = dict(cycle.scope["headers"]).get(b"content-length", b"")
        short = length.isdigit() and int(length[:20]) <= HIGH_WATER_LIMIT
        return short and not cycle.waiting_for_100_continue

    # What is answered.

    def _start_asgi_task(self, cycle: RequestResponseCycle, app: Any) -> None:
        self._answering = cycle
        self._door.works(self)
        if not self._n_sent():  # else the answers before it are not taken yet
            self._outgoing.restart()
        super()._start_asgi_task(cycle, partial(self._answered_by, app))

    async def _answered_by(self, app: ASGIApp, scope: Scope, receive: Receive, send: Send) -> None:
        """The application; a stream of events gives way to others: its client asks on where it ended."""

        async def sent(message: Message) -> None:
            if message["type"] == "http.response.start" and _is_event_stream(message):
                self._door.waits(self)
            await send(message)

        await app(scope, receive, sent)

    def on_response_complete(self) -> None:
        self._answering = None
        self._flow.held = len(self.pipeline) > 1
        super().on_response_complete()
        # The door watches it.
        self._unset_keepalive_if_required()
        if self._answering is not None or self._left is not None or self.transport.is_closing():
            return
        if self._last_words is not None:
            self.part(self._last_words)
        elif self._arriving != _BODY:
            self._rest()

    def pause_writing(self) -> None:
        super().pause_writing()
        self._note_taken()

    def resume_writing(self) -> None:
        self._note_taken()
        super().resume_writing()

    def _rest(self) -> None:
        """Wait for the next request, if none is under way."""
        if self._answering is None:
            self._door.waits(self)
            self._patience = self._door.settings.keep_alive_timeout
            if self._arriving == _NOTHING:
                self._since = self.loop.time()

    # How it ends.

    def shutdown(self) -> None:
        self._is_kept = False
        super().shutdown()

    def check(self, now: float, seconds: float) -> None:
        """End what takes too long; `seconds` have gone by since the last call."""
        if self._is_not_taken(seconds):
            self._door.given_up(self.client)
            self.transport.abort()
        elif self.transport.is_closing():
            pass
        elif self._left is not None:
            if now - self._left > _LINGER_SECONDS:
                self.transport.close()
        elif self._last_words is not None:
            pass
        elif self._arriving == _BODY:
            self._check_body(seconds)
        elif self._arriving == _HEAD:
            limit = self._door.settings.head_timeout
            if now - self._since > limit:
                self._refuse(HeadTimeoutError(f"the head of the request did not arrive within {limit:g} s"))
        elif self._answering is None and now - self._since > self._patience:
            self.transport.close()

    def _check_body(self, seconds: float) -> None:
        if self.flow.read_paused or self.cycle.waiting_for_100_continue:
            return
        complaint = self._incoming.complaint(seconds)
        if complaint is not None:
            self._refuse(BodyTimeoutError(f"the body did not arrive: {complaint}"))

    def _is_not_taken(self, seconds: float) -> bool:
        """Whether the client takes too long to take its answers.

        What is on its way does not wait, but what lies in the system's buffer, maybe megabytes, and does not
        move.
        """
        moves = self._note_taken()
        if self.transport.get_write_buffer_size() or (not moves and self._n_sent()):
            return self._outgoing.complaint(seconds) is not None
        self._outgoing.caught_up()
        return False

    def _note_taken(self) -> bool:
        """Note what the client has taken since the last time; whether that is something."""
        before, self._n_taken = self._n_taken, self._taken()
        self._outgoing.moved(max(0, self._n_taken - before))
        return self._n_taken > before

    def _taken(self) -> int:
        """Bytes that the client has taken of all; where the system does not tell, what waits, below zero."""
        if sys.platform == "linux":
            with suppress(OSError):
                info = self._socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, _ACKED.stop)
                return int.from_bytes(info[_ACKED], sys.byteorder)
        return -self.transport.get_write_buffer_size()

    def _n_sent(self) -> int:
        """Bytes that the system has taken and the client has not; 0 where it does not tell (not Linux)."""
        if sys.platform == "linux":
            with suppress(OSError):
                return int.from_bytes(ioctl(self._socket.fileno(), TIOCOUTQ, bytes(4)), sys.byteorder)
        return 0

    def _refuse(self, error: ServiceError) -> None:
        """Read no further, and tell why, after the answers to the requests that came before."""
        spoilt = self.cycle if self._arriving == _BODY else None
        if spoilt is not None and spoilt is self._answering:
            self._cut_off(spoilt, error)
            return
        if spoilt is not None and spoilt.response_complete:
            self.part()
            return
        if spoilt is not None:
            self.pipeline.popleft()
        request_id = str(uuid.uuid4())
        refused = problem(error, f"/requests/{request_id}")
        self._door.refused(self.client, refused, request_id)
        words = self._rendered(refused, request_id)
        if self._answering is None:
            self.part(words)
        else:
            self._last_words = words

    def _cut_off(self, request: RequestResponseCycle, error: ServiceError) -> None:
        """Answer a request in place of the application, which hears that its client is gone."""
        if request.response_started:
            self.transport.abort()
            return
        state: dict[str, Any] = request.scope["state"]
        request_id = state.get("request_id", "unknown")
        refused = problem(error, f"/requests/{request_id}")
        state.setdefault("facts", {}).update(problem=refused.slug, status=refused.status)
        request.disconnected = True
        request.message_event.set()
        self.part(self._rendered(refused, request_id))

    def _rendered(self, refused: Problem, request_id: str) -> bytes:
        """A problem as the bytes of a response."""
        headers = {
            "Content-Type": MEDIA_TYPE,
            "Content-Length": str(len(refused.content)),
            "X-Request-Id": request_id,
            **refused.headers,
        }
        lines = [b"%s: %s\r\n" % line for line in self.server_state.default_headers]
        lines += [f"{name}: {value}\r\n".encode() for name, value in headers.items()]
        return b"".join([STATUS_LINE[refused.status], *lines, b"\r\n", refused.content])

    def part(self, words: bytes = b"") -> None:
        """Say this and nothing more; what the client still sends is read for a moment, and dropped."""
        if words:
            self.transport.write(words)
        with suppress(OSError):  # the client has gone already
            self.transport.write_eof()
        self._left = self.loop.time()
        self._flow.held = False
        self._flow.resume_reading()

    def _drop(self, n_bytes: int) -> None:
        self._dropped += n_bytes
        if self._dropped > _LINGER_BYTES:
            self.transport.close()


def _is_event_stream(start: Message) -> bool:
    media_type: bytes = dict(start["headers"]).get(b"content-type", b"")
    return media_type.partition(b";")[0] == b"text/event-stream"


class _Parting:
    """Takes an answer to a request that is still arriving, for uvicorn: its end is that of the connection.

    Closed at once, what the client is sending would be thrown away, and by its system then the answer.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection

    def write(self, data: bytes) -> None:
        self._connection.transport.write(data)

    def is_closing(self) -> bool:
        return self._connection.transport.is_closing()

    def close(self) -> None:
        self._connection.part()


class _Flow(FlowControl):
    """uvicorn's, which reads on whenever the application asks for more, but not while this is held."""

    held = False

    def hold(self) -> None:
        """Read nothing until the requests that have arrived are answered, whoever asks for more."""
        self.held = True
        self.pause_reading()

    def resume_reading(self) -> None:
        if not self.held:
            super().resume_reading()
