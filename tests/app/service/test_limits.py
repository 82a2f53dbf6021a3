"""Limits, time limits, lost workers and lost clients, against a real service."""

import contextlib
import io
import json
import os
import signal
import socket
import time
from collections.abc import Iterator
from typing import Any

import httpx
import numpy as np
import pytest

from tests.app.processes import needs_proc, ticks
from tests.app.serving import PATIENCE, Background, wait_for, workers
from tests.paths import EXAMPLES

SMALL = json.loads((EXAMPLES / "request.json").read_bytes())
MIB = 2**20


def _cylinder(n_points: int) -> np.ndarray:
    rng = np.random.default_rng(n_points)
    angle, height = rng.uniform(0, 5, n_points), rng.uniform(-2, 2, n_points)
    noise = rng.normal(scale=1e-3, size=(n_points, 3))
    return np.column_stack([np.cos(angle), np.sin(angle), height]) + noise


def _npy(points: np.ndarray) -> bytes:
    stream = io.BytesIO()
    np.save(stream, points)
    return stream.getvalue()


def _csv(n_bytes: int) -> bytes:
    rows = "".join(f"{x:.16g},{y:.16g},{z:.16g}\n" for x, y, z in _cylinder(20_000)).encode()
    return (rows * (n_bytes // len(rows) + 1))[:n_bytes].rpartition(b"\n")[0]


def _is_problem(response: httpx.Response, status: int, slug: str) -> None:
    assert response.status_code == status, response.text
    assert response.json()["type"] == f"urn:primfit:problem:{slug}"


def _works(service: Any) -> None:
    assert service.client.post("/fit", json=SMALL).status_code == 200


def _is_clean(service: Any) -> bool:
    return not list(service.temporary_directory.iterdir())


def _pieces(body: bytes) -> Iterator[bytes]:
    for start in range(0, len(body), 65536):
        yield body[start : start + 65536]


@pytest.mark.parametrize("chunked", [False, True], ids=["with length", "chunked"])
@pytest.mark.parametrize("media_type", ["text/csv", "application/json", "multipart/form-data; boundary=x"])
def test_a_body_over_the_limit_is_refused(strict_service: Any, media_type: str, chunked: bool) -> None:
    body = b"1,2,3\n" * (2 * MIB // 6)
    response = strict_service.post(_pieces(body) if chunked else body, media_type)
    _is_problem(response, 413, "too-large")
    assert str(MIB) in response.json()["detail"]
    assert _is_clean(strict_service)
    _works(strict_service)


def test_the_default_limit_is_64_mib(service: Any) -> None:
    _is_problem(service.post(b"1" * (64 * MIB + 1), "text/csv"), 413, "too-large")
    assert _is_clean(service)


def _raw(service: Any, request: bytes, hang_up: bool = False) -> bytes:
    """What comes back for bytes sent as they are, until the service closes the connection."""
    with socket.create_connection(("127.0.0.1", service.port), timeout=PATIENCE) as connection:
        connection.sendall(request)
        if hang_up:
            return b""
        answer = b""
        with contextlib.suppress(ConnectionResetError):
            while piece := connection.recv(65536):
                answer += piece
        return answer


def _head(length: object, media_type: str = "text/csv") -> bytes:
    lines = [
        "POST /fit HTTP/1.1",
        "Host: localhost",
        f"Content-Type: {media_type}",
        f"Content-Length: {length}",
        "",
        "",
    ]
    return "\r\n".join(lines).encode()


def test_a_length_that_is_too_large_is_refused_before_the_body_comes(strict_service: Any) -> None:
    assert b" 413 " in _raw(strict_service, _head(10**15))


def test_a_body_shorter_than_its_length_times_out(strict_service: Any) -> None:
    answer = _raw(strict_service, _head(300_000) + b"1,2,3\n" * 30_000)
    assert b" 408 " in answer
    assert b"urn:primfit:problem:body-timeout" in answer
    wait_for(lambda: _is_clean(strict_service))
    _works(strict_service)


def test_a_body_longer_than_its_length_is_cut_there(strict_service: Any) -> None:
    following = b"GET /livez HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n"
    answer = _raw(strict_service, _head(12) + b"1,2,3\n4,5,6\n" + following)
    assert b"2 points given" in answer
    assert b'{"status":"alive"}' in answer
    assert b" 400 " in _raw(strict_service, _head(12) + b"1,2,3\n4,5,6\n7,8,9\n")


@pytest.mark.parametrize("length", ["-1", "abc", "1e3", "9" * 400])
def test_a_length_that_is_none_is_refused(strict_service: Any, length: str) -> None:
    assert _raw(strict_service, _head(length) + b"1,2,3\n").split(b" ")[1].startswith(b"4")
    _works(strict_service)


def test_clients_that_hang_up_leave_nothing(strict_service: Any) -> None:
    for _ in range(10):
        _raw(strict_service, _head(900_000) + b"1,2,3\n" * 50_000, hang_up=True)
    wait_for(lambda: _is_clean(strict_service))
    _works(strict_service)


@pytest.mark.parametrize("n_points", [1000, 1001])
def test_points_in_json_are_limited(strict_service: Any, n_points: int) -> None:
    response = strict_service.client.post("/fit", json={"points": _cylinder(n_points).tolist()})
    if n_points == 1000:
        assert response.status_code == 200
    else:
        _is_problem(response, 413, "too-large")
        assert "1001 points; the limit is 1000" in response.json()["detail"]


@pytest.mark.parametrize("upload", [False, True], ids=["raw", "upload"])
def test_points_in_files_are_limited(strict_service: Any, upload: bool) -> None:
    body = _npy(_cylinder(20_001))
    if upload:
        response = strict_service.client.post("/fit", files={"file": ("a.npy", body)})
    else:
        response = strict_service.post(body, "application/x-npy")
    _is_problem(response, 413, "too-large")
    assert "20001 points; the limit is 20000" in response.json()["detail"]


def test_five_million_points_are_the_default_limit(service: Any) -> None:
    claim = b"ply\nformat binary_little_endian 1.0\nelement vertex 5000001\nproperty char x\n"
    body = claim + b"property char y\nproperty char z\nend_header\n" + bytes(15_000_003)
    _is_problem(service.post(body, "model/ply"), 413, "too-large")


def test_a_cloud_over_the_limit_of_its_criterion_is_not_fitted(service: Any) -> None:
    """More points than a minimum zone is sure to be done with in a minute, but not more than may be read."""
    limits = service.client.get("/capabilities").json()["limits"]
    most = limits["points_by_criterion"]["minimum_zone"]
    body = _npy(_cylinder(most + 1).astype(np.float32))
    assert most < limits["max_points"] == limits["points_by_criterion"]["robust"]
    response = service.post(body, "application/octet-stream", criterion="minimum_zone")
    _is_problem(response, 413, "too-large")
    (error,) = response.json()["errors"]
    assert error["field"] == "criterion" and error["value"] == f"{most + 1} points"
    assert f"{most + 1} points; the limit of the criterion minimum_zone is {most}" in error["message"]
    files = {"file": ("large.npy", body), "options": (None, '{"criterion": "minimum_zone"}')}
    (line, *_) = service.client.post("/fit/batch", files=files).text.splitlines()
    assert json.loads(line)["problem"]["errors"] == [error]
    _works(service)


@needs_proc
def test_a_worker_that_dies_is_a_problem_and_is_replaced(service: Any) -> None:
    before = workers(service.pid)
    assert len(before) == 2
    idle = {pid: ticks(pid) for pid in before}
    request = Background(service, _npy(_cylinder(2_000_000)), criterion="minimum_zone")
    request.start()
    wait_for(lambda: any(ticks(pid) > idle[pid] + 20 for pid in before))
    for pid in before:
        os.kill(pid, signal.SIGKILL)
    request.join()
    _is_problem(request.response, 503, "worker-died")
    for _ in range(3):
        _works(service)
    assert _is_clean(service)
    assert set(workers(service.pid)).isdisjoint(before)


@needs_proc
def test_a_worker_that_died_while_idle_is_replaced_unnoticed(strict_service: Any) -> None:
    for _ in range(5):
        (worker,) = workers(strict_service.pid)
        os.kill(worker, signal.SIGKILL)
        assert strict_service.client.get("/readyz").status_code == 200
        _works(strict_service)


@needs_proc
def test_work_over_the_time_limit_is_stopped(strict_service: Any) -> None:
    (before,) = workers(strict_service.pid)
    os.kill(before, signal.SIGSTOP)
    response = strict_service.client.post("/fit", json=SMALL)
    _is_problem(response, 504, "time-limit")
    _works(strict_service)
    assert workers(strict_service.pid) != [before]


@needs_proc
def test_more_requests_than_may_wait_are_refused_at_once(strict_service: Any) -> None:
    (worker,) = workers(strict_service.pid)
    os.kill(worker, signal.SIGSTOP)
    requests = [Background(strict_service, _npy(_cylinder(100))) for _ in range(4)]
    for request in requests:
        request.start()
    for request in requests:
        request.join()
    statuses = sorted(request.response.status_code for request in requests)
    assert statuses == [503, 503, 503, 504]
    for busy in (request.response for request in requests if request.response.status_code == 503):
        _is_problem(busy, 503, "busy")
        assert int(busy.headers["retry-after"]) >= 1
    details = " ".join(request.response.json()["detail"] for request in requests)
    assert details.count("1 requests with small clouds are waiting") == 2
    assert details.count("no worker was free within 3 s; it was not begun") == 1


BIG = {
    "60 MB of text": lambda: (_csv(60 * 10**6), "text/csv"),
    "60 MB of JSON": lambda: (
        b'{"points": [' + b",".join([b"[1.5,%s2.5,3]" % (b" " * 290)] * 200_000) + b"]}",
        "application/json",
    ),
    "a fit of a million points": lambda: (_npy(_cylinder(1_000_000)), "application/octet-stream"),
}


@pytest.mark.clock
@pytest.mark.parametrize("make", BIG.values(), ids=BIG)
def test_livez_answers_while_the_service_is_at_work(service: Any, make: Any) -> None:
    """In one of three tries: other programs may slow one of them down, a blocked event loop all of them."""
    body, media_type = make()
    assert any(_slowest_livez(service, body, media_type) < 0.25 for _ in range(3))


def _slowest_livez(service: Any, body: bytes, media_type: str) -> float:
    """The slowest `GET /livez` while a body is received, read and fitted, over the time of it all."""
    request = Background(service, body, media_type)
    began = time.perf_counter()
    request.start()
    times = []
    while request.is_alive():
        start = time.perf_counter()
        assert service.client.get("/livez").status_code == 200
        times.append(time.perf_counter() - start)
        time.sleep(0.005)
    request.join()
    assert request.response.status_code in (200, 422)
    assert len(times) > 10
    return max(times) / (time.perf_counter() - began)
