"""Clients of a service in one process: requests are prepared bytes, and a parser in C reads the answers.

The service and its clients share a machine: what a client does for each request is what a service under test
cannot use.
"""

import asyncio
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from itertools import cycle
from time import perf_counter
from types import MappingProxyType
from typing import NamedTuple

import httptools
import numpy as np

PATIENCE = 120.0
"""Seconds that an answer is waited for: twice what a service may take by its own limits."""


class Answer(NamedTuple):
    """`status` is 0 where the connection ended before an answer, -1 where none came in time.

    `sent` is a time of `perf_counter`, `seconds` how long the answer then took.
    """

    status: int
    sent: float
    seconds: float
    content: bytes = b""
    headers: Mapping[bytes, bytes] = MappingProxyType({})


def request(
    path: str, body: bytes = b"", media_type: str = "", method: str = "POST", **headers: str
) -> bytes:
    """A request as it travels; `headers` are written with _ for -."""
    lines = [f"{method} {path} HTTP/1.1", "Host: 127.0.0.1"]
    lines += [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
    if media_type:
        lines.append(f"Content-Type: {media_type}")
    if body or method == "POST":
        lines.append(f"Content-Length: {len(body)}")
    return "\r\n".join([*lines, "", ""]).encode("latin-1") + body


class _Wire(asyncio.Protocol):
    """One connection, and the answer that is awaited on it."""

    def __init__(self) -> None:
        self.closed = False
        self._transport: asyncio.Transport
        self._answer: asyncio.Future[Answer] | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport

    def ask(self, content: bytes) -> asyncio.Future[Answer]:
        self._answer = asyncio.get_running_loop().create_future()
        self._parser = httptools.HttpResponseParser(self)
        self._headers: dict[bytes, bytes] = {}
        self._pieces: list[bytes] = []
        self._sent = perf_counter()
        self._transport.write(content)
        return self._answer

    def data_received(self, data: bytes) -> None:
        if self._answer is None:  # nobody asked
            self.abort()
            return
        try:
            self._parser.feed_data(data)
        except httptools.HttpParserError:
            self.abort()

    def on_header(self, name: bytes, value: bytes) -> None:
        self._headers[name.lower()] = value

    def on_body(self, piece: bytes) -> None:
        self._pieces.append(piece)

    def on_message_complete(self) -> None:
        status = self._parser.get_status_code()
        if status < 200:  # 100 Continue: the answer follows
            return
        if not self._parser.should_keep_alive():
            self.abort()
        self._end(status)

    def connection_lost(self, _: Exception | None) -> None:
        self.closed = True
        self._end(0)

    def abort(self) -> None:
        self.closed = True
        self._transport.abort()

    def _end(self, status: int) -> None:
        if self._answer is not None and not self._answer.done():
            seconds = perf_counter() - self._sent
            self._answer.set_result(
                Answer(status, self._sent, seconds, b"".join(self._pieces), self._headers)
            )
        self._answer = None


class Client:
    """Asks one thing at a time on a connection that is kept open, and opened again where it was closed."""

    def __init__(self, port: int) -> None:
        self._port = port
        self._wire: _Wire | None = None

    async def ask(self, content: bytes, patience: float = PATIENCE) -> Answer:
        started = perf_counter()
        try:
            async with asyncio.timeout(patience):
                if self._wire is None or self._wire.closed:
                    loop = asyncio.get_running_loop()
                    _, self._wire = await loop.create_connection(_Wire, "127.0.0.1", self._port)
                answer = await self._wire.ask(content)
        except TimeoutError:
            self.close()
            return Answer(-1, started, perf_counter() - started)
        except OSError:
            return Answer(0, started, perf_counter() - started)
        return answer if answer.status != 200 else answer._replace(content=b"", headers=MappingProxyType({}))

    def close(self) -> None:
        if self._wire is not None:
            self._wire.abort()
        self._wire = None


async def in_turn(port: int, requests: Sequence[bytes], seconds: float) -> list[Answer]:
    """One client that asks anew as soon as it is answered, until the time is over."""
    client, answers, end = Client(port), [], perf_counter() + seconds
    for content in cycle(requests):
        answers.append(await client.ask(content))
        if perf_counter() >= end:
            break
        if answers[-1].status == 0:  # refused or cut off: do not spin
            await asyncio.sleep(0.01)
    client.close()
    return answers


async def together(port: int, requests: Sequence[bytes], n_clients: int, seconds: float) -> list[Answer]:
    """So many such clients, each of which begins with another request."""
    turns = [[*requests[i % len(requests) :], *requests[: i % len(requests)]] for i in range(n_clients)]
    found = await asyncio.gather(*(in_turn(port, turn, seconds) for turn in turns))
    return [answer for answers in found for answer in answers]


async def probed(port: int, path: str, every: float, under_way: asyncio.Future[object]) -> list[Answer]:
    """`GET` of this path, every so many seconds, until something else is done."""
    client, content, answers = Client(port), request(path, method="GET"), []
    while not under_way.done():
        answers.append(await client.ask(content))
        with suppress(TimeoutError):
            await asyncio.wait_for(asyncio.shield(under_way), every)
    client.close()
    return answers


def quantile(answers: Sequence[Answer], share: float) -> float:
    """Seconds within which this share of the answers came; NaN where there are none."""
    return float(np.quantile([answer.seconds for answer in answers], share)) if answers else float("nan")


def with_status(answers: Sequence[Answer], *statuses: int) -> list[Answer]:
    return [answer for answer in answers if answer.status in statuses]


def without(answers: Sequence[Answer], *statuses: int) -> list[int]:
    """The statuses that are none of these."""
    return [answer.status for answer in answers if answer.status not in statuses]


def statuses(answers: Sequence[Answer]) -> dict[int, int]:
    """How often each status came."""
    return dict(sorted(Counter(answer.status for answer in answers).items()))
