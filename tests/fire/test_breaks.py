"""Killed processes, signals under load and a full disk: what was taken is answered, and nothing stays."""

import asyncio
import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest

from primfit.benchmark.service import csv, npy
from tests.app.disks import disk_of
from tests.app.processes import needs_proc, ticks
from tests.app.serving import PATIENCE, Service, running, wait_for, workers
from tests.fire.load import Answer, Client, request, statuses, together, with_status, without
from tests.fire.report import reported
from tests.fire.traffic import CSV, NPY, fits, points
from tests.fire.watching import Watch

pytestmark = [pytest.mark.fire, needs_proc]

WORKERS, N_CLIENTS = 2, 8
SOON = 10.0
"""Seconds: what is to end or to come back at once does so well within them on a busy machine, too."""


def test_workers_are_killed_under_load(tmp_path: Path) -> None:
    with reported("killed-workers") as figures, running(tmp_path / "bodies", workers=WORKERS) as service:
        load, replaced_after = asyncio.run(_killing(service))
        figures.note("statuses", statuses(load))
        figures.at_most(
            "answers that a killed worker was at", len(with_status(load, 503)), len(replaced_after)
        )
        figures.none("others that are no answers", without(load, 200, 503))
        figures.at_most("replaced after", max(replaced_after), SOON, "s", clock=True)
        figures.none("files left", list(service.temporary_directory.iterdir()))


async def _killing(service: Service) -> tuple[list[Answer], list[float]]:
    """The answers, and the seconds that it took until as many workers were there as before."""
    load = asyncio.ensure_future(together(service.port, fits(3000), N_CLIENTS, 8.0))
    replaced_after = []
    for _ in range(2):
        await asyncio.sleep(1.0)
        killed, *_ = workers(service.pid)
        os.kill(killed, signal.SIGKILL)
        started = perf_counter()
        async with asyncio.timeout(PATIENCE):
            while len(left := workers(service.pid)) < WORKERS or killed in left:
                await asyncio.sleep(0.02)
        replaced_after.append(perf_counter() - started)
    return await load, replaced_after


def test_sigterm_under_load(tmp_path: Path) -> None:
    with reported("sigterm") as figures, running(tmp_path / "bodies", workers=WORKERS) as service:
        load, stopped_at, stopped_after = asyncio.run(_stopping(service))
        taken = [answer for answer in load if answer.sent < stopped_at]
        figures.note("statuses of what was sent before", statuses(taken))
        figures.none("of these lost", without(taken, 200))
        later = [answer for answer in load if answer.sent >= stopped_at]
        figures.note("statuses of what was sent later", statuses(later))
        figures.none("of these neither answered nor refused", without(later, 0, 200, 503))
        figures.equals("status of the service", service.process.wait(PATIENCE), 0)
        figures.at_most("stopped after", stopped_after, SOON, "s", clock=True)
        figures.none("processes left", Watch(service.pid).processes())
        figures.none("files left", list(service.temporary_directory.iterdir()))


async def _stopping(service: Service) -> tuple[list[Answer], float, float]:
    """The answers, the moment of the signal, and the seconds that the service then took to stop."""
    load = asyncio.ensure_future(together(service.port, fits(3000), N_CLIENTS, 5.0))
    await asyncio.sleep(2.0)
    service.process.terminate()
    stopped_at = perf_counter()
    async with asyncio.timeout(PATIENCE):
        while service.process.poll() is None:
            await asyncio.sleep(0.02)
    stopped_after = perf_counter() - stopped_at
    return await load, stopped_at, stopped_after


LARGE = 2_000_000
"""Points, 48 MB: kept in a file, and fitted for seconds."""


def test_the_service_is_killed(tmp_path: Path) -> None:
    with reported("killed-service") as figures, running(tmp_path / "bodies", workers=WORKERS) as service:
        watch = Watch(service.pid)
        gone_after = asyncio.run(_killed(service, watch))
        figures.at_most("processes gone after", gone_after, 1.0, "s", clock=True)
        figures.none("files left", list(service.temporary_directory.iterdir()))


async def _killed(service: Service, watch: Watch) -> float:
    """Seconds until all processes have ended, when the service is killed while both workers are at work."""
    idle = {pid: ticks(pid) for pid in workers(service.pid)}
    content = request("/fit", npy(points("cylinder", LARGE)), NPY)
    load = asyncio.ensure_future(together(service.port, [content], WORKERS, 0.0))
    await asyncio.to_thread(wait_for, lambda: all(ticks(pid) > before + 20 for pid, before in idle.items()))
    service.process.kill()
    killed_at = perf_counter()
    async with asyncio.timeout(PATIENCE):
        while watch.processes():
            await asyncio.sleep(0.01)
    gone_after = perf_counter() - killed_at
    load.cancel()
    with suppress(asyncio.CancelledError):
        await load
    return gone_after


DISK = 8
"""MiB of the disk for bodies."""


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    with disk_of(f"{DISK}m", tmp_path / "bodies") as folder:
        yield folder


def test_a_full_disk(small_disk: Path) -> None:
    """Bodies that do not fit are told so, those that need no disk are answered meanwhile, and it passes."""
    large = csv(np.tile(points("cylinder", 3000), (100, 1)))
    assert len(large) > 2 * DISK * 2**20
    fitting = request("/fit", npy(points("cylinder", 30_000)), NPY)
    asked = {
        "a fit": request("/fit", large, CSV),
        "an export": request("/fit/export?artifacts=csv", large, CSV),
        "a batch": request("/fit/batch?labels=1", large, CSV),
    }
    with reported("full-disk") as figures, running(small_disk, workers=WORKERS) as service:
        for what, content in asked.items():
            refused, meanwhile = asyncio.run(_beside(service.port, content))
            figures.equals(f"{what}: status", refused.status, 507)
            figures.at_least(f"{what}: Retry-After", int(refused.headers.get(b"retry-after", 0)), 1, "s")
            figures.none("small requests that fail meanwhile", without(meanwhile, 200))
            figures.none("files left", list(small_disk.iterdir()))
        fits_again = asyncio.run(_alone(service.port, fitting))
        figures.equals("a body that fits: status", fits_again.status, 200)


async def _beside(port: int, content: bytes) -> tuple[Answer, list[Answer]]:
    small = asyncio.ensure_future(together(port, fits(300, csv, CSV), 2, 2.0))
    answer = await _alone(port, content)
    return answer, await small


async def _alone(port: int, content: bytes) -> Answer:
    """The answer on a connection of its own."""
    client = Client(port)
    try:
        return await client.ask(content)
    finally:
        client.close()


OLD, NEW = "old-old-old-old-old-old", "new-new-new-new-new-new"


def test_sighup_under_load(tmp_path: Path) -> None:
    """Keys are read again; no request notices."""
    file = tmp_path / "keys"
    file.write_text(f"{OLD}\n")
    with (
        reported("sighup") as figures,
        running(tmp_path / "bodies", workers=WORKERS, api_keys_file=file) as service,
    ):
        load, known_after, unknown_after = asyncio.run(_reloading(service, file))
        figures.note("statuses", statuses(load))
        figures.none("answers that are none", without(load, 200))
        figures.at_most("a new key is known after", known_after, SOON, "s", clock=True)
        figures.at_most("an old key is refused after", unknown_after, SOON, "s", clock=True)
        figures.equals("services that run on", int(service.process.poll() is None), 1)


async def _reloading(service: Service, file: Path) -> tuple[list[Answer], float, float]:
    """The answers under the old key while both are known, and the seconds until either change is in force."""
    load = asyncio.ensure_future(together(service.port, fits(3000, X_API_Key=OLD), N_CLIENTS, 4.0))
    await asyncio.sleep(1.0)
    file.write_text(f"{OLD}\n{NEW}\n")
    os.kill(service.pid, signal.SIGHUP)
    known_after = await _until(service.port, NEW, 200)
    answers = await load
    file.write_text(f"{NEW}\n")
    os.kill(service.pid, signal.SIGHUP)
    return answers, known_after, await _until(service.port, OLD, 401)


async def _until(port: int, key: str, status: int) -> float:
    """Seconds until a request with this key has this status."""
    client, started = Client(port), perf_counter()
    content = request("/capabilities", method="GET", X_API_Key=key)
    async with asyncio.timeout(PATIENCE):
        while (await client.ask(content)).status != status:
            await asyncio.sleep(0.02)
    client.close()
    return perf_counter() - started
