"""Many clients at once, and more than the service can do: nobody waits long, and what is taken is done."""

import asyncio
from pathlib import Path
from time import perf_counter

import pytest

from tests.app.processes import needs_proc
from tests.app.serving import running
from tests.fire.flood import at_rate
from tests.fire.load import (
    Answer,
    Client,
    in_turn,
    probed,
    quantile,
    statuses,
    together,
    with_status,
    without,
)
from tests.fire.report import Report, reported
from tests.fire.scale import scaled
from tests.fire.traffic import fits

pytestmark = [pytest.mark.fire, needs_proc]

WORKERS = 2
N_POINTS = 3000


def test_32_clients_wait_alike(tmp_path: Path) -> None:
    with reported("clients") as figures, running(tmp_path / "bodies", workers=WORKERS) as service:
        asyncio.run(together(service.port, fits(N_POINTS), WORKERS, 1.0))
        answers = asyncio.run(together(service.port, fits(N_POINTS), 32, scaled(60)))
        half, late = quantile(answers, 0.5), quantile(answers, 0.99)
        figures.note("requests", len(answers))
        figures.note("answers a second", len(answers) / scaled(60))
        figures.none("errors", without(answers, 200))
        figures.note("p50", 1e3 * half, "ms")
        figures.note("p99", 1e3 * late, "ms")
        figures.at_most("p99 over p50", late / half, 3, clock=True)


N_CLIENTS, TIMES = 128, 4.0
LATE = 0.1
"""Seconds that a refusal or a sign of life may take."""
WAIT = 2.0
"""Seconds that the clients of an overloaded service ask it to take at most."""


def test_four_times_what_it_can_do(tmp_path: Path) -> None:
    """Requests come four times as fast as they can be answered, from clients that ignore Retry-After."""
    with reported("overload") as figures, running(tmp_path / "bodies", workers=WORKERS) as service:
        asyncio.run(_overload(figures, service.port))


async def _overload(figures: Report, port: int) -> None:
    ordinary, hurried = fits(N_POINTS), fits(N_POINTS, Prefer=f"wait={WAIT:g}")
    await together(port, ordinary, WORKERS, 1.0)
    idle = quantile(await in_turn(port, ordinary, scaled(5)), 0.95)
    before = await _capacity(port, ordinary)
    started = perf_counter()
    flood = asyncio.to_thread(at_rate, port, hurried, TIMES * before, N_CLIENTS, scaled(30))
    load = asyncio.ensure_future(flood)
    alive = await probed(port, "/livez", 0.02, load)
    answers, stopped = await load, perf_counter()
    recovered = await _recovered(port, ordinary, 2 * idle)
    capacity = (before + await _capacity(port, ordinary)) / 2

    accepted, refused = with_status(answers, 200), with_status(answers, 503)
    figures.note("capacity", capacity, "answers a second")
    figures.note("requests a second", len(answers) / scaled(30))
    figures.note("statuses", statuses(answers))
    figures.none("answers that are neither", without(answers, 200, 503))
    figures.at_most("refused within, p99", 1e3 * quantile(refused, 0.99), 1e3 * LATE, "ms", clock=True)
    n_late = sum(answer.seconds > LATE for answer in refused)
    figures.note("refused later than that", n_late)
    figures.note("refused within, at most", 1e3 * quantile(refused, 1.0), "ms")
    figures.note("idle service, p95", 1e3 * idle, "ms")
    figures.at_most(
        "accepted, p95", 1e3 * quantile(accepted, 0.95), 1e3 * (2 * idle + WAIT), "ms", clock=True
    )
    figures.none("/livez, errors", without(alive, 200))
    figures.at_most("/livez, p99", 1e3 * quantile(alive, 0.99), 1e3 * LATE, "ms", clock=True)
    goodput = len(accepted) / (stopped - started)
    figures.at_least("goodput over capacity", goodput / capacity, 0.8, clock=True)
    figures.at_most("recovered after", recovered, 10, "s", clock=True)


async def _capacity(port: int, requests: list[bytes]) -> float:
    """Answers a second where each worker always has one client."""
    seconds = scaled(10)
    return len(await together(port, requests, WORKERS, seconds)) / seconds


async def _recovered(port: int, requests: list[bytes], soon: float) -> float:
    """Seconds until one of each request in a row was answered as soon as by an idle service."""
    client, started, in_a_row = Client(port), perf_counter(), 0
    while in_a_row < len(requests):
        answer: Answer = await client.ask(requests[in_a_row])
        in_a_row = in_a_row + 1 if answer.status == 200 and answer.seconds <= soon else 0
        if perf_counter() - started > 60:
            break
    client.close()
    return perf_counter() - started
