"""Work that ends with its client, its deadline, its memory, its service; and room for bodies."""

import gzip
import http.client
import io
import os
import signal
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from tests.app.processes import needs_proc, ticks
from tests.app.serving import ALICE, PATIENCE, Background, Service, running, wait_for, workers
from tests.paths import EXAMPLES

CSV = (EXAMPLES / "cylinder.csv").read_bytes()
SOON = 10.0
"""Seconds for what takes one on an idle machine."""

pytestmark = needs_proc


@pytest.fixture(scope="module")
def narrow(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with one worker of little memory, one place in its queue, and little room for bodies."""
    limits = {"worker_memory": 64 * 2**20, "max_spooled_bytes": 40_000_000}
    with running(tmp_path_factory.mktemp("bodies"), workers=1, queue_size=1, **limits) as started:
        yield started


def _npy(n_points: int) -> bytes:
    rng = np.random.default_rng(1)
    angle, height = rng.uniform(0, 5, (2, n_points))
    radius = rng.normal(1.0, 0.01, n_points)
    stream = io.BytesIO()
    np.save(stream, np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height]))
    return stream.getvalue()


def _head(path: str, length: int, *lines: str) -> bytes:
    head = [f"POST {path} HTTP/1.1", "Host: localhost", f"Content-Length: {length}", *lines, "", ""]
    return "\r\n".join(head).encode()


def _connected(service: Service) -> socket.socket:
    return socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE)


def _metric(service: Service, name: str) -> float:
    lines = service.client.get("/metrics").text.splitlines()
    return float(next(line for line in lines if line.startswith(name + " ")).split()[1])


def _busy(service: Service) -> bool:
    return _metric(service, "primfit_workers_busy") == 1.0


def _is_clean(service: Service) -> bool:
    return not list(service.temporary_directory.iterdir())


@pytest.mark.parametrize("path", ["/fit", "/fit/batch"])
def test_a_client_that_leaves_ends_its_work(narrow: Service, path: str) -> None:
    """The worker is stopped: it would work for ever, and nothing but its end sets the service free."""
    (worker,) = workers(narrow.pid)
    os.kill(worker, signal.SIGSTOP)
    with _connected(narrow) as client:
        client.sendall(_head(path, len(CSV)) + CSV)
        wait_for(lambda: _busy(narrow))
    wait_for(lambda: not _busy(narrow), SOON)
    assert narrow.post(CSV, "text/csv").status_code == 200
    assert workers(narrow.pid) != [worker]


def test_a_client_that_leaves_the_queue_makes_room(narrow: Service) -> None:
    (worker,) = workers(narrow.pid)
    os.kill(worker, signal.SIGSTOP)
    held = Background(narrow, CSV, "text/csv")
    held.start()
    wait_for(lambda: _busy(narrow))
    body = _npy(10_000)
    with _connected(narrow) as client:
        client.sendall(_head("/fit", len(body)) + body)
        wait_for(lambda: _metric(narrow, 'primfit_queue_length{lane="small"}') == 1.0)
        assert narrow.post(CSV, "text/csv").status_code == 503
    wait_for(lambda: _metric(narrow, 'primfit_queue_length{lane="small"}') == 0.0, SOON)
    os.kill(worker, signal.SIGCONT)
    held.join()
    assert held.response.status_code == 200
    assert workers(narrow.pid) == [worker]
    wait_for(lambda: _is_clean(narrow))


def test_a_full_queue_refuses_before_the_body_comes(narrow: Service) -> None:
    (worker,) = workers(narrow.pid)
    os.kill(worker, signal.SIGSTOP)
    try:
        held = [Background(narrow, CSV, "text/csv") for _ in range(2)]
        for request in held:
            request.start()
        wait_for(lambda: _metric(narrow, 'primfit_queue_length{lane="small"}') == 1.0)
        with _connected(narrow) as client:
            client.sendall(_head("/fit", 60_000, "Expect: 100-continue"))
            answer = client.recv(65536)
        assert answer.startswith(b"HTTP/1.1 503 ")
        assert b"retry-after: " in answer.lower()
    finally:
        os.kill(worker, signal.SIGCONT)
    for request in held:
        request.join()
        assert request.response.status_code == 200


def test_a_client_says_how_long_it_waits(narrow: Service) -> None:
    (worker,) = workers(narrow.pid)
    os.kill(worker, signal.SIGSTOP)
    headers = {"Content-Type": "text/csv", "Prefer": "respond-async; x=1, Wait=1"}
    slow = narrow.client.post("/fit", content=CSV, headers=headers)
    assert slow.status_code == 504
    assert "not done within 1 s" in slow.json()["detail"]
    headers["Prefer"] = "wait=100"
    answer = narrow.client.post("/fit", content=CSV, headers=headers)
    assert answer.status_code == 200
    assert answer.headers["preference-applied"] == "wait=60"
    assert "preference-applied" not in narrow.post(CSV, "text/csv").headers


@pytest.mark.skipif(os.uname().sysname != "Linux", reason="other systems do not limit address space")
def test_a_cloud_that_needs_too_much_memory_is_told_so(narrow: Service) -> None:
    (worker,) = workers(narrow.pid)
    response = narrow.post(_npy(1_500_000), "application/octet-stream")
    assert response.status_code == 413, response.text
    assert "more memory than 64 MiB, the limit of a worker" in response.json()["detail"]
    assert narrow.post(CSV, "text/csv").status_code == 200
    assert workers(narrow.pid) != [worker]
    assert "Traceback" not in narrow.log.read_text()


def test_bodies_have_so_much_room_together(narrow: Service) -> None:
    body = _npy(1_000_000)
    with _connected(narrow) as first, _connected(narrow) as second:
        first.sendall(_head("/fit", len(body)) + body[:1_000_000])
        wait_for(lambda: not _is_clean(narrow))
        second.sendall(_head("/fit", len(body), "Expect: 100-continue"))
        answer = second.recv(65536)
        assert answer.startswith(b"HTTP/1.1 507 ") and b"retry-after: " in answer.lower()
        assert b"urn:primfit:problem:no-space" in answer + second.recv(65536)
        assert narrow.post(CSV, "text/csv").status_code == 200
    wait_for(lambda: _is_clean(narrow))
    connection = http.client.HTTPConnection("127.0.0.1", narrow.port, timeout=PATIENCE)
    connection.putrequest("POST", "/fit")
    connection.putheader("Content-Length", str(len(body)))
    connection.putheader("Expect", "100-continue")
    connection.endheaders()
    assert connection.sock.recv(25).startswith(b"HTTP/1.1 100 ")
    connection.close()


def test_what_a_batch_unpacks_to_counts(narrow: Service) -> None:
    rows = np.random.default_rng(1).integers(0, 10**6, (20_000, 3))
    block = "".join(f"{x},{y},{z}\n" for x, y, z in rows.tolist()).encode()
    body = gzip.compress(block * (41_000_000 // len(block)), 1)
    assert len(body) < 30_000_000
    headers = {"Content-Encoding": "gzip", "Content-Type": "text/csv"}
    response = narrow.client.post("/fit/batch", content=body, headers=headers)
    assert response.status_code == 507, response.text
    wait_for(lambda: _is_clean(narrow))


def test_workers_and_files_end_with_a_service_that_is_killed(tmp_path: Path) -> None:
    with running(tmp_path / "bodies", workers=2) as service:
        before = workers(service.pid)
        idle = {pid: ticks(pid) for pid in before}
        body = _npy(2_000_000)
        with _connected(service) as client:
            client.sendall(_head("/fit?criterion=minimum_zone", len(body)) + body)
            wait_for(lambda: any(ticks(pid) > idle[pid] + 20 for pid in before))
            assert not _is_clean(service)
            service.process.kill()
            service.process.wait()
        wait_for(lambda: not any(Path(f"/proc/{pid}").exists() for pid in before), SOON)
        assert _is_clean(service)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="no SIGHUP here")
def test_keys_and_settings_are_read_again(tmp_path: Path) -> None:
    keys, config = tmp_path / "keys", tmp_path / "primfit.toml"
    keys.write_text(f"alice:{ALICE}\n")
    config.write_text(f"api_keys_file = {str(keys)!r}\nworkers = 1\n")
    with running(tmp_path / "bodies", config=config) as service:

        def ask(key: str, body: bytes = CSV) -> httpx.Response:
            headers = {"Content-Type": "text/csv", "X-API-Key": key}
            return service.client.post("/fit", content=body, headers=headers)

        def read_again(word: str) -> None:
            seen = service.log.read_text().count(word)
            os.kill(service.pid, signal.SIGHUP)
            wait_for(lambda: service.log.read_text().count(word) > seen)

        assert ask(ALICE).status_code == 200
        other = "another-key-0123456789"
        keys.write_text(f"bob:{other}\n")
        config.write_text(f"api_keys_file = {str(keys)!r}\nworkers = 2\nmax_body_bytes = 100\n")
        (worker,) = workers(service.pid)
        os.kill(worker, signal.SIGSTOP)
        held: list[Any] = []
        with _connected(service) as client:
            client.sendall(_head("/fit", len(CSV), f"X-API-Key: {ALICE}", "Content-Type: text/csv") + CSV)
            time.sleep(0.5)
            read_again("SIGHUP: settings and keys are read again")
            os.kill(worker, signal.SIGCONT)
            held.append(client.recv(65536))
        assert held[0].startswith(b"HTTP/1.1 200 ")
        assert ask(ALICE).status_code == 401
        assert ask(other).status_code == 413
        assert ask(other, b"1,2\n").status_code == 422
        assert "SIGHUP: workers will change when the service is started anew" in service.log.read_text()
        keys.write_text("short\n")
        read_again("SIGHUP: nothing is changed: ")
        assert ask(other, b"1,2\n").status_code == 422
        keys.write_bytes(b"\xff\xfe")
        read_again(f"SIGHUP: nothing is changed: {keys}: ")
        config.write_text("workers = 2\n")
        read_again("SIGHUP: nothing is changed: no key would be left")
        assert ask("", b"1,2\n").status_code == 401
        assert service.process.poll() is None
