"""Where the service listens, and SIGTERM: requests under way get their answer, and the status is 0."""

import io
import json
import os
import signal
import socket
import time
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from primfit.app.service.server import ListenError, is_loopback, listen
from tests.app.processes import needs_proc
from tests.app.serving import PATIENCE, Background, running, wait_for, workers
from tests.paths import EXAMPLES

SMALL = json.loads((EXAMPLES / "request.json").read_bytes())


def _npy(n_points: int) -> bytes:
    """A noisy torus; of 100,000 points it is too large to be kept in memory."""
    rng = np.random.default_rng(4)
    ring, tube = rng.uniform(0, 5, (2, n_points))
    distance = 3.0 + np.cos(tube)
    points = np.column_stack([distance * np.cos(ring), distance * np.sin(ring), np.sin(tube)])
    stream = io.BytesIO()
    np.save(stream, points + rng.normal(scale=1e-3, size=points.shape))
    return stream.getvalue()


def _held(service: Any) -> tuple[int, Background]:
    """The only worker, which is held up, and the request that it has."""
    (worker,) = workers(service.pid)
    os.kill(worker, signal.SIGSTOP)
    request = Background(service, _npy(100_000))
    request.start()
    wait_for(lambda: "\nprimfit_workers_busy 1.0\n" in service.client.get("/metrics").text)
    return worker, request


@pytest.mark.parametrize(
    ("address", "alone"), [("127.0.0.1", True), ("::1", True), ("0.0.0.0", False), ("fe80::1%eth0", False)]
)
def test_which_addresses_others_reach(address: str, alone: bool) -> None:
    assert is_loopback(address) == alone


def test_answers_leave_at_once() -> None:
    """A connection that holds small packets back answers every request on it 40 ms late."""
    with (
        listen("127.0.0.1", 0) as listener,
        socket.create_connection(listener.getsockname()),
        listener.accept()[0] as connection,
    ):
        assert connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_a_foreign_address_is_refused() -> None:
    with pytest.raises((ListenError, socket.gaierror), match="cannot listen"):
        listen("192.0.2.1", 0)


@needs_proc
@pytest.mark.parametrize("whole_group", [False, True], ids=["the service", "all its processes"])
def test_a_request_under_way_is_answered_in_full(tmp_path: Path, whole_group: bool) -> None:
    with running(tmp_path / "bodies", workers=1, stop_patience=60) as service:
        worker, request = _held(service)
        if whole_group:
            os.killpg(service.pid, signal.SIGTERM)
        else:
            os.kill(service.pid, signal.SIGTERM)
        wait_for(lambda: "Shutting down" in service.log.read_text())
        assert request.is_alive()
        with pytest.raises(httpx.ConnectError):
            httpx.get(f"http://127.0.0.1:{service.port}/livez")
        os.kill(worker, signal.SIGCONT)
        request.join()
        assert request.response.status_code == 200
        assert request.response.json()["primitive"]["kind"] == "torus"
        assert request.response.json()["receipt"]["n_points"] == 100_000
        assert service.process.wait(PATIENCE) == 0
        assert not list(service.temporary_directory.iterdir())


@needs_proc
def test_a_request_that_takes_longer_is_told_so(tmp_path: Path) -> None:
    with running(tmp_path / "bodies", workers=1, stop_patience=0) as service:
        _, request = _held(service)
        os.kill(service.pid, signal.SIGTERM)
        request.join()
        assert request.response.status_code == 503
        assert request.response.json()["type"] == "urn:primfit:problem:stopping"
        assert request.response.headers["retry-after"] == "1"
        assert service.process.wait(PATIENCE) == 0
        assert "Traceback" not in service.log.read_text()


@pytest.mark.skipif(os.name != "posix", reason="signals are those of POSIX")
def test_for_a_while_it_works_on_and_says_that_it_will_stop(tmp_path: Path) -> None:
    with running(tmp_path / "bodies", workers=1, stop_delay=5) as service:
        start = time.monotonic()
        os.kill(service.pid, signal.SIGTERM)
        wait_for(lambda: service.client.get("/readyz").status_code == 503)
        assert service.client.get("/readyz").json()["detail"] == "the service is about to stop"
        assert service.client.get("/livez").status_code == 200
        assert service.client.post("/fit", json=SMALL).status_code == 200
        assert service.process.wait(PATIENCE) == 0
        assert time.monotonic() - start >= 5.0
