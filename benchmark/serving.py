"""A real `primfit serve`, asked over bare connections, or by the plain client of the standard library."""

import http.client
import math
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

PATIENCE = 60.0
"""Seconds that an answer is waited for."""
_REPLY = re.compile(rb"HTTP/1.1 (?P<status>\d+)(?s:.*?)\r\ncontent-length: (?P<length>\d+)(?s:.*?)\r\n\r\n")


Ask = Callable[[str, bytes], bytes]
"""Sends a body of this media type to `POST /fit`, and returns the answer."""


class ServiceError(RuntimeError):
    """The service did not start, refused a request, or answered otherwise than the fit alone."""


def post(connection: socket.socket, media_type: str, body: bytes) -> bytes:
    """The answer of `POST /fit`; raises `ServiceError` where it is none."""
    status, content = _ask(connection, f"POST /fit HTTP/1.1\r\nContent-Type: {media_type}", body)
    if status != 200:
        raise ServiceError(f"the service answered {status}: {content.decode()[:200]}")
    return content


def get(connection: socket.socket, path: str) -> bytes:
    """The answer of `GET` with this path; raises `ServiceError` where it is none."""
    status, content = _ask(connection, f"GET {path} HTTP/1.1")
    if status != 200:
        raise ServiceError(f"the service answered {status} to GET {path}")
    return content


def _ask(connection: socket.socket, head: str, body: bytes = b"") -> tuple[int, bytes]:
    """Status and body of an answer."""
    connection.sendall(f"{head}\r\nHost: localhost\r\nContent-Length: {len(body)}\r\n\r\n".encode() + body)
    reply = b""
    while not (found := _REPLY.match(reply)) or len(reply) < found.end() + int(found["length"]):
        piece = connection.recv(2**16)
        if not piece:
            raise ConnectionError("the service closed the connection")
        reply += piece
    return int(found["status"]), reply[found.end() :]


def connect(port: int) -> socket.socket:
    connection = socket.create_connection(("127.0.0.1", port), PATIENCE)
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    return connection


@contextmanager
def bare(port: int) -> Iterator[Ask]:
    """Over a socket: a client library takes no time."""
    with connect(port) as connection:
        yield lambda media_type, body: post(connection, media_type, body)


@contextmanager
def plain(port: int) -> Iterator[Ask]:
    """By `http.client` on one connection that is kept open."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=PATIENCE)

    def ask(media_type: str, body: bytes) -> bytes:
        connection.request("POST", "/fit", body, {"Content-Type": media_type})
        reply = connection.getresponse()
        content = reply.read()
        if reply.status != 200:
            raise ServiceError(f"the service answered {reply.status}: {content.decode()[:200]}")
        return content

    try:
        yield ask
    finally:
        connection.close()


CLIENTS: dict[str, Callable[[int], AbstractContextManager[Ask]]] = {"bare": bare, "http.client": plain}
"""Ways to ask; the first is what bars are held against."""


@dataclass(frozen=True)
class Service:
    """A service that runs: its port, and the session of all its processes."""

    port: int
    session: int

    def cpu_seconds(self) -> float:
        """What its processes, those that live, have taken of processors so far; NaN where nobody tells."""
        stats = [stat for stat in Path("/proc").glob("[0-9]*/stat") if self._owns(stat)]
        return sum(map(_cpu_nanoseconds, stats)) / 1e9 or math.nan

    def _owns(self, stat: Path) -> bool:
        try:
            return os.getsid(int(stat.parent.name)) == self.session
        except OSError:  # it has ended
            return False


def _cpu_nanoseconds(stat: Path) -> int:
    """Of all threads of a process."""
    try:
        return sum(int(task.read_text().split()[0]) for task in stat.parent.glob("task/*/schedstat"))
    except OSError:
        return 0


@contextmanager
def serving(
    log: Path, workers: int = 1, settings: Mapping[str, str] = MappingProxyType({})
) -> Iterator[Service]:
    """A service with so many workers, and with settings as environment variables.

    Raises `ServiceError` where it does not start.
    """
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with log.open("ab") as output:
        process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "primfit",
                "serve",
                "--port",
                str(port),
                "--workers",
                str(workers),
            ],
            env=os.environ | settings,
            stdout=output,
            stderr=output,
            start_new_session=True,
        )
    try:
        _wait(process, port, log)
        yield Service(port, process.pid)
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait(PATIENCE)


@contextmanager
def on_one_processor() -> Iterator[None]:
    """What is started within stays on the processor that `benchmark.child` takes."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    mine = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(mine)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, mine)


def _wait(process: subprocess.Popen[bytes], port: int, log: Path) -> None:
    deadline = time.monotonic() + PATIENCE
    while process.poll() is None and time.monotonic() < deadline:
        try:
            with connect(port) as connection:
                if _ask(connection, "GET /readyz HTTP/1.1")[0] == 200:
                    return
        except OSError:
            pass
        time.sleep(0.1)
    raise ServiceError(f"the service did not become ready; see {log}")
