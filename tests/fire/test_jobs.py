"""Jobs of a thousand segments while all that may break is broken: each line is there once, as in a batch."""

import os
import signal
import sqlite3
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.app.disks import disk_of
from tests.app.postgresql import Postgres, needs_postgres, started
from tests.app.processes import needs_proc
from tests.app.service.asking import is_problem
from tests.app.service.scans import many
from tests.app.service.test_jobs import CSV, batch, ended, hand_in, results, status
from tests.app.serving import Service, running, wait_for, workers
from tests.fire.report import reported

pytestmark = [pytest.mark.fire, needs_proc]

N = 1000
BODY = many(N, 30)
QUERY = "?kinds=cylinder&classifier=none"
RESUMED_WITHIN = 10.0
LONG = 600.0


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The lines of a batch that nothing disturbs."""
    with running(tmp_path_factory.mktemp("calm"), workers=2) as service:
        response = service.client.post(f"/fit/batch{QUERY}", content=BODY, headers=CSV, timeout=LONG)
    assert len(response.content.splitlines()) == N + 1
    return response.content


@pytest.fixture
def postgres() -> Iterator[Postgres]:
    with started() as server:
        yield server


def _hand_in(service: Service) -> str:
    response = service.client.post(f"/jobs{QUERY}", content=BODY, headers=CSV)
    assert response.status_code == 202, response.text
    return str(response.headers["location"])


def _lines(service: Service, path: str) -> int:
    """How many lines are there; where the service does not answer, none."""
    try:
        response = service.client.get(path)
    except httpx.TransportError:
        return 0
    return int(response.json()["lines"]) if response.status_code == 200 else 0


def _some_more(service: Service, path: str, n_lines: int = 50) -> int:
    """Wait until there are so many lines more, and say how many there are."""
    before = _lines(service, path)
    wait_for(lambda: _lines(service, path) >= before + n_lines, LONG)
    return _lines(service, path)


def _resumed(service: Service, path: str, n_before: int, what: str) -> None:
    """It gets on again; how soon is told."""
    since = time.monotonic()
    wait_for(lambda: _lines(service, path) > n_before, LONG)
    with reported(f"job-{what.replace(' ', '-')}") as figures:
        figures.at_most("resumed after", time.monotonic() - since, RESUMED_WITHIN, "s", clock=True)


def _kill(service: Service) -> None:
    os.kill(service.pid, signal.SIGKILL)
    service.process.wait()


def _settings(tmp_path: Path, **more: Any) -> dict[str, Any]:
    return {"workers": 2, "jobs_path": tmp_path / "jobs", **more}


def test_the_service_is_killed_and_started_again(tmp_path: Path, expected: bytes) -> None:
    with running(tmp_path / "first", **_settings(tmp_path)) as service:
        path = _hand_in(service)
        _some_more(service, path)
        _kill(service)
    for n in range(3):
        with running(tmp_path / f"again{n}", **_settings(tmp_path)) as service:
            _resumed(service, path, _lines(service, path), f"service killed and started again ({n + 1})")
            if n < 2:
                _some_more(service, path)
                _kill(service)
                continue
            assert ended(service, path, LONG)["status"] == "successful"
            assert results(service, path) == expected


def test_workers_are_killed_again_and_again(tmp_path: Path, expected: bytes) -> None:
    with running(tmp_path / "one", **_settings(tmp_path)) as service:
        path = _hand_in(service)
        n_killed = 0
        while status(service, path)["status"] != "successful":
            for pid in workers(service.pid)[:1]:
                os.kill(pid, signal.SIGKILL)
                n_killed += 1
            time.sleep(1.0)
        assert n_killed > 2
        assert results(service, path) == expected


def test_a_service_that_is_told_to_stop_leaves_its_job_to_another(tmp_path: Path, expected: bytes) -> None:
    settings = _settings(tmp_path)
    with running(tmp_path / "one", **settings) as one, running(tmp_path / "two", **settings) as other:
        path = _hand_in(one)
        _some_more(one, path)
        one.process.terminate()
        one.process.wait()
        _resumed(other, path, _lines(other, path), "SIGTERM, another service")
        assert ended(other, path, LONG)["status"] == "successful"
        assert results(other, path) == expected


def test_a_service_that_is_stopped_and_goes_on_has_lost_its_job(tmp_path: Path, expected: bytes) -> None:
    settings = _settings(tmp_path)
    with running(tmp_path / "one", **settings) as one, running(tmp_path / "two", **settings) as other:
        path = _hand_in(one)
        first = one if _works(one, path) else other
        second = other if first is one else one
        n_before = _some_more(second, path)
        os.kill(first.pid, signal.SIGSTOP)
        try:
            _resumed(second, path, max(n_before, _lines(second, path)), "SIGSTOP, another service")
        finally:
            os.kill(first.pid, signal.SIGCONT)
        assert ended(second, path, LONG)["status"] == "successful"
        assert results(second, path) == results(first, path) == expected


def _works(service: Service, path: str) -> bool:
    """Whether it is this service that works on the job."""
    wait_for(lambda: _lines(service, path) > 0, LONG)
    return f"a job is begun job={path.rpartition('/')[2]}" in _told(service)


def _told(service: Service) -> str:
    """Its log, without the ids of requests."""
    return " ".join(word for word in service.log.read_text().split() if not word.startswith("request_id="))


@needs_postgres
def test_postgresql_is_killed_and_started_again(tmp_path: Path, postgres: Postgres, expected: bytes) -> None:
    with running(tmp_path / "one", **_settings(tmp_path, jobs_database=postgres.url())) as service:
        path = _hand_in(service)
        for n in range(2):
            n_before = _some_more(service, path)
            postgres.kill()
            refused = service.client.post(f"/jobs{QUERY}", content=BODY, headers=CSV)
            is_problem(refused, 503, "jobs-unavailable")
            assert refused.headers["retry-after"]
            assert service.client.post(
                "/fit", content=BODY[:2000].rpartition(b"\n")[0], headers=CSV
            ).is_success
            postgres.start()
            _resumed(service, path, n_before, f"PostgreSQL killed and started again ({n + 1})")
        assert ended(service, path, LONG)["status"] == "successful"
        assert results(service, path) == expected


@needs_postgres
def test_services_share_a_postgresql_and_one_is_killed(
    tmp_path: Path, postgres: Postgres, expected: bytes
) -> None:
    settings = _settings(tmp_path, jobs_database=postgres.url(), workers=1)
    with running(tmp_path / "one", **settings) as one, running(tmp_path / "two", **settings) as other:
        paths = [_hand_in(one) for _ in range(2)]
        _some_more(other, paths[0])
        _kill(one)
        for n, path in enumerate(paths):
            _resumed(other, path, _lines(other, path), f"service killed, another service ({n + 1})")
        for path in paths:
            assert ended(other, path, LONG)["status"] == "successful"
            assert results(other, path) == expected


def test_a_locked_database_is_waited_for(tmp_path: Path, expected: bytes) -> None:
    with running(tmp_path / "one", **_settings(tmp_path)) as service:
        path = _hand_in(service)
        n_before = _some_more(service, path)
        locker = sqlite3.connect(tmp_path / "jobs" / "jobs.sqlite", isolation_level=None)
        locker.execute("BEGIN EXCLUSIVE")
        refused = service.client.post(f"/jobs{QUERY}", content=BODY, headers=CSV)
        is_problem(refused, 503, "jobs-unavailable")
        assert refused.headers["retry-after"]
        time.sleep(8.0)
        n_locked = _lines(service, path)
        locker.execute("COMMIT")
        locker.close()
        _resumed(service, path, max(n_before, n_locked), "database locked for 8 s")
        assert ended(service, path, LONG)["status"] == "successful"
        assert results(service, path) == expected


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with disk_of("24m", tmp_path / "small") as place:
        yield place


def test_a_full_disk_is_waited_for(tmp_path: Path, small_disk: Path, expected: bytes) -> None:
    with running(tmp_path / "one", **_settings(small_disk)) as service:
        path = _hand_in(service)
        _some_more(service, path)
        filler = small_disk / "filler"
        with pytest.raises(OSError), filler.open("wb", buffering=0) as file:
            while True:
                file.write(b"x" * 4096)
        refused = service.client.post(f"/jobs{QUERY}", content=BODY, headers=CSV)
        is_problem(refused, 507, "no-space")
        assert refused.headers["retry-after"]
        time.sleep(8.0)
        n_full = _lines(service, path)
        assert status(service, path)["status"] in ("accepted", "running")
        filler.unlink()
        _resumed(service, path, n_full, "disk full for 8 s")
        assert ended(service, path, LONG)["status"] == "successful"
        assert results(service, path) == expected


def test_nothing_that_was_accepted_is_lost_to_a_kill_at_any_moment(tmp_path: Path) -> None:
    """Hand in jobs all the time, and kill the service as often: each that was answered 202 is done."""
    accepted: dict[str, bytes] = {}
    bodies = {f"k{n}": many(n + 1, 30) for n in range(30)}
    directory, settings = tmp_path / "s", _settings(tmp_path)
    waiting = list(bodies)
    for n in range(4):
        with running(directory.with_name(f"s{n}"), **settings) as service:
            killer = threading.Timer(0.6 + 0.2 * n, lambda pid=service.pid: os.kill(pid, signal.SIGKILL))
            killer.start()
            while waiting:
                key = waiting[0]
                try:
                    path = hand_in(service, bodies[key], **{"Idempotency-Key": key})
                except httpx.TransportError:
                    break
                accepted[path] = bodies[waiting.pop(0)]
            killer.cancel()
            if waiting:
                service.process.wait()
    with running(tmp_path / "last", **settings) as service:
        for key in waiting:
            accepted[hand_in(service, bodies[key], **{"Idempotency-Key": key})] = bodies[key]
        assert len(service.client.get("/jobs").json()["jobs"]) == len(accepted) == len(bodies)
        for path, body in accepted.items():
            assert ended(service, path, LONG)["status"] == "successful"
            assert results(service, path) == batch(service, body)
