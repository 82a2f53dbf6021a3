"""Many connections that do nothing, or little: others are served as before, and all are closed in time."""

import asyncio
import contextlib
import resource
import statistics
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.app.service.connections import GET, POST, answer, statuses
from tests.app.serving import Service, running, wait_for
from tests.fire.report import reported

pytestmark = pytest.mark.fire
N_IDLE, N_SLOW = 2000, 100
# Times by default, but for those of which a minute is as good as ten.
TIMES = {"transfer_time_limit": 60.0}
DEFAULT = {"first_byte": 30.0, "head": 10.0, "body": 30.0, "answer": 90.0}
"""Seconds after which each sort is closed at the latest; the answers of 100 clients have to be made first."""
MARGIN = 10.0
N_ASKED = 100


@pytest.fixture(scope="module", autouse=True)
def descriptors() -> Iterator[None]:
    """As many as this process needs for its side of the connections; the service inherits them."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, max(soft, 2 * N_IDLE)), hard))
    yield
    resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


@pytest.fixture(scope="module")
def attacked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service with its default times and number of places."""
    with running(tmp_path_factory.mktemp("bodies"), workers=1, log_format="json", **TIMES) as started:
        yield started


def _asked(service: Service) -> list[float]:
    """Seconds that requests take, each on a connection of its own; none may fail."""
    times = []
    for _ in range(N_ASKED):
        start = time.perf_counter()
        assert statuses(answer(service.port, GET[:-2] + b"Connection: close\r\n\r\n")) == [200]
        times.append(time.perf_counter() - start)
    return times


def _n_descriptors(service: Service) -> int:
    return len(list(Path(f"/proc/{service.pid}/fd").iterdir()))


async def _held(port: int, n: int, first: bytes, more: bytes, pause: float, reads: bool) -> list[float]:
    """Seconds until the service closes each of so many connections, on which `more` is sent now and then."""

    async def one() -> float:
        reader, writer = await asyncio.open_connection("127.0.0.1", port, limit=4096)
        start = time.monotonic()
        if not reads:
            writer.transport.pause_reading()  # type: ignore[attr-defined]
        with contextlib.suppress(ConnectionError, BrokenPipeError):
            writer.write(first)
            while not (reads and reader.at_eof()):
                if reads:
                    with contextlib.suppress(TimeoutError):
                        async with asyncio.timeout(pause):
                            await reader.read(4096)
                else:
                    await asyncio.sleep(pause)
                writer.write(more)
                await writer.drain()
        writer.close()
        return time.monotonic() - start

    return await asyncio.gather(*(one() for _ in range(n)))


PAGES = GET.replace(b"/livez", b"/openapi.json") * 12
"""Four megabytes of answers, more than the buffers of a connection hold."""
ATTACKS = {
    "idle": (N_IDLE, b"", b"", "first_byte", True),
    "slow heads": (N_SLOW, GET[:-2], b"a", "head", True),
    "slow bodies": (N_SLOW, POST + b"Content-Length: 100000\r\n\r\n", b"1", "body", True),
    "clients that read nothing": (N_SLOW, PAGES, GET, "answer", False),
}


@pytest.mark.parametrize("attack", ATTACKS)
def test_others_are_served_and_all_are_closed(attacked: Service, attack: str) -> None:
    n, first, more, limit, reads = ATTACKS[attack]
    wait_for(lambda: attacked.client.get("/livez").status_code == 200)
    before, n_before = _asked(attacked), _n_descriptors(attacked)

    async def attacked_and_asked() -> tuple[list[float], list[float]]:
        held = asyncio.create_task(_held(attacked.port, n, first, more, 1.0, reads))
        # To make the answers that nobody takes is work like other work: others are asked after it.
        await asyncio.sleep(30.0 if limit == "answer" else 3.0)
        return await asyncio.to_thread(_asked, attacked), await held

    meanwhile, held = asyncio.run(attacked_and_asked())
    with reported(f"connections-{attack.replace(' ', '-')}") as figures:
        figures.note("connections", n)
        figures.at_most("closed after, the last one", max(held), DEFAULT[limit] + MARGIN, "s", clock=True)
        figures.note("a request before, median", 1e3 * statistics.median(before), "ms")
        figures.note("meanwhile, median", 1e3 * statistics.median(meanwhile), "ms")
        figures.at_most("meanwhile, the slowest", max(meanwhile), 2.0, "s", clock=True)
    wait_for(lambda: _n_descriptors(attacked) <= n_before + 5, MARGIN)
    assert attacked.client.get("/livez").status_code == 200
