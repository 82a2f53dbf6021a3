"""`primfit serve` in a process of its own."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import httpx

from tests.paths import EXAMPLES as EXAMPLES
from tests.paths import ROOT

PATIENCE = 60.0
LISTENING = re.compile(r"Listening on 127\.0\.0\.1 port (\d+)")
ALICE, NAMELESS = "c0ffee-c0ffee-c0ffee", "0123456789abcdef0123456789abcdef"
"""The keys of `guarded_service`."""


@dataclass(frozen=True)
class Service:
    """Where a service listens, its process, where it keeps large bodies, and the file of its log."""

    client: httpx.Client
    port: int
    process: subprocess.Popen[bytes]
    temporary_directory: Path
    log: Path

    @property
    def pid(self) -> int:
        return self.process.pid

    def post(self, content: bytes | Iterator[bytes], media_type: str, **params: object) -> httpx.Response:
        """POST /fit with a raw body."""
        headers = {"Content-Type": media_type}
        return self.client.post("/fit", content=content, headers=headers, params=params)  # type: ignore[arg-type]


@contextmanager
def running(directory: Path, ready: bool = True, code: Path = ROOT, **settings: object) -> Iterator[Service]:
    """Start `primfit serve` of this code with these settings, wait until it is ready, stop it in the end."""
    directory.mkdir(exist_ok=True)
    names = {f"PRIMFIT_{name.upper()}": str(value) for name, value in settings.items()}
    environment = {**os.environ, **names, "PRIMFIT_TEMPORARY_DIRECTORY": str(directory)}
    command = [sys.executable, "-m", "primfit", "serve", "--port", "0"]
    log = directory.with_suffix(".log")
    with log.open("wb") as stderr:
        process = subprocess.Popen(command, env=environment, cwd=code, stderr=stderr, start_new_session=True)
    try:
        wait_for(lambda: LISTENING.search(log.read_text()) is not None)
        port = int(LISTENING.findall(log.read_text())[0])
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client:
            wait_for(lambda: _status(client) == 200 if ready else _status(client) is not None)
            yield Service(client, port, process, directory, log)
    finally:
        process.terminate()
        process.wait(PATIENCE)


def _status(client: httpx.Client) -> int | None:
    try:
        return client.get("/readyz").status_code
    except httpx.TransportError:
        return None


def wait_for(condition: Callable[[], bool], patience: float = PATIENCE) -> None:
    """Poll until the condition holds."""
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.05)


def workers(pid: int) -> list[int]:
    """The worker processes of a service: what was forked by its fork server."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    forkers = {child for child, parent in parents.items() if parent == pid}
    return [child for child, parent in parents.items() if parent in forkers]


@contextmanager
def stopped(service: Service) -> Iterator[None]:
    """The workers of the service do nothing."""
    held = workers(service.pid)
    for worker in held:
        os.kill(worker, signal.SIGSTOP)
    try:
        yield
    finally:
        for worker in held:
            with contextlib.suppress(ProcessLookupError):  # it was ended, since its client has left
                os.kill(worker, signal.SIGCONT)


class Background(threading.Thread):
    """A request in the background; `response` is there after `join`."""

    def __init__(
        self, service: Service, body: bytes, media_type: str = "application/octet-stream", **options: str
    ) -> None:
        super().__init__()
        self.service, self.body, self.media_type, self.options = service, body, media_type, options
        self.response: httpx.Response

    def run(self) -> None:
        headers = {"Content-Type": self.media_type}
        url = f"http://127.0.0.1:{self.service.port}/fit"
        self.response = httpx.post(url, content=self.body, headers=headers, params=self.options, timeout=60)
