"""A real `primfit serve`, asked over bare connections: what a client library adds is its own affair."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PATIENCE = 60.0
"""Seconds that an answer is waited for."""
_REPLY = re.compile(rb"HTTP/1.1 (?P<status>\d+)(?s:.*?)\r\ncontent-length: (?P<length>\d+)(?s:.*?)\r\n\r\n")


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
def serving(log: Path, workers: int = 1) -> Iterator[int]:
    """A service with so many workers; yields its port. Raises `ServiceError` where it does not start."""
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
            stdout=output,
            stderr=output,
        )
    try:
        _wait(process, port, log)
        yield port
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
