"""A real service in a process of its own, once a session; and one with small limits."""

import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import httpx
import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[2] / "app" / "examples"
PATIENCE = 60.0


@dataclass(frozen=True)
class Service:
    """Where a service listens, its process, and where it keeps large bodies."""

    client: httpx.Client
    port: int
    pid: int
    temporary_directory: Path

    def post(self, content: bytes | Iterator[bytes], media_type: str, **params: object) -> httpx.Response:
        """POST /fit with a raw body."""
        headers = {"Content-Type": media_type}
        return self.client.post("/fit", content=content, headers=headers, params=params)  # type: ignore[arg-type]


@contextmanager
def running(directory: Path, **settings: object) -> Iterator[Service]:
    """Start `app.api` under uvicorn with these settings, and stop it in the end."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    names = {f"PRIMFIT_{name.upper()}": str(value) for name, value in settings.items()}
    environment = {**os.environ, **names, "PRIMFIT_TEMPORARY_DIRECTORY": str(directory)}
    command = [sys.executable, "-m", "uvicorn", "--factory", "app.api:create_app", "--port", str(port)]
    process = subprocess.Popen(command, env=environment, cwd=EXAMPLES.parents[1])
    try:
        with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=PATIENCE) as client:
            wait_for(lambda: _ready(client))
            yield Service(client, port, process.pid, directory)
    finally:
        process.terminate()
        process.wait(PATIENCE)


def _ready(client: httpx.Client) -> bool:
    try:
        return client.get("/readyz").status_code == 200
    except httpx.TransportError:
        return False


def workers_of(pid: int) -> list[int]:
    """The worker processes of a service: what was forked by its fork server."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    forkers = {child for child, parent in parents.items() if parent == pid}
    return [child for child, parent in parents.items() if parent in forkers]


def wait_for(condition: Callable[[], bool], patience: float = PATIENCE) -> None:
    """Poll until the condition holds."""
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.05)


@pytest.fixture(scope="session")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with the default limits."""
    with running(tmp_path_factory.mktemp("bodies"), workers=2) as started:
        yield started


@pytest.fixture(scope="session")
def strict_service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with one worker, 1 MiB, 20,000 points, 1,000 in JSON, and a second for everything."""
    limits = {"max_body_bytes": 2**20, "max_points": 20_000, "max_json_points": 1000}
    times = {"fit_time_limit": 1.0, "receive_timeout": 1.0, "queue_size": 1}
    with running(tmp_path_factory.mktemp("bodies"), workers=1, **limits, **times) as started:
        yield started


@pytest.fixture(scope="session")
def cylinder() -> np.ndarray:
    """The points of the bundled example."""
    return np.loadtxt(EXAMPLES / "cylinder.csv", delimiter=",", skiprows=2)
