"""Hostile requests, one after the other: none is a fault of the service, none takes much."""

import asyncio
from collections import Counter
from collections.abc import Iterator
from itertools import chain, count, islice
from pathlib import Path
from typing import NamedTuple

import pytest

from tests.app.hostile.corpus import CORPUS
from tests.app.processes import needs_proc
from tests.app.serving import Service, running, wait_for, workers
from tests.fire import watching
from tests.fire.fuzz import Hostile, hostile
from tests.fire.load import Client
from tests.fire.report import Report, reported
from tests.fire.scale import scaled
from tests.fire.watching import MIB, faults

pytestmark = [pytest.mark.fire, needs_proc]

N_REQUESTS = 10_000
CPU_SECONDS, MEMORY = 1.0, 200.0
"""Seconds and MiB that no request may exceed."""
PATIENCE, HEAD_PATIENCE = 30.0, 0.5
"""Seconds. A head that never ends is left soon; how long the service waits for it is asserted elsewhere."""
WORST = 5


class Cost(NamedTuple):
    """What came of a request, and what it took: of the processor in one process, and of a worker's memory."""

    case: Hostile
    status: int
    cpu_seconds: float
    n_bytes: int
    replaced: bool

    @property
    def meant(self) -> bool:
        if self.case.expected is not None:
            return self.status in self.case.expected
        return 200 <= self.status < 500 or (self.case.head and self.status <= 0)

    @property
    def told(self) -> str:
        return f"{self.case.name} ({self.status})"


def test_hostile_requests(tmp_path: Path) -> None:
    cases = islice(chain(named(), map(hostile, count())), int(scaled(N_REQUESTS)))
    with (
        reported("hostile") as figures,
        running(tmp_path / "bodies", workers=1, log_format="json") as service,
    ):
        costs = asyncio.run(_asked(service, cases))
        _report(figures, costs)
        figures.none("files left", list(service.temporary_directory.iterdir()))
        figures.none("5xx in the log", faults(service.log))


def named() -> Iterator[Hostile]:
    """The corpus: what was once a fault of this service or of another, and what the limits are for."""
    for case in CORPUS:
        yield Hostile(case.name, case.request(), expected=case.statuses)


async def _asked(service: Service, cases: Iterator[Hostile]) -> list[Cost]:
    client, costs = Client(service.port), []
    processes = _processes(service.pid)
    idle = watching.resident(processes[-1])
    for case in cases:
        before = list(map(watching.cpu_seconds, processes))
        watching.forget_peak(processes[-1])
        if case.head or case.expected:  # some of these take so long to make that the service has hung up
            client.close()
        answer = await client.ask(case.content, HEAD_PATIENCE if case.head else PATIENCE)
        cpu = max(watching.cpu_seconds(pid) - spent for pid, spent in zip(processes, before, strict=True))
        memory = watching.peak(processes[-1]) - idle
        replaced = not Path(f"/proc/{processes[-1]}").exists()
        costs.append(Cost(case._replace(content=b""), answer.status, cpu, memory, replaced))
        if replaced:
            processes = _processes(service.pid)
    client.close()
    return costs


def _processes(pid: int) -> list[int]:
    """The service and its worker, which may just be replaced."""
    wait_for(lambda: len(workers(pid)) == 1)
    return [pid, *workers(pid)]


def _report(figures: Report, costs: list[Cost]) -> None:
    figures.note("requests", len(costs))
    figures.note("statuses", dict(sorted(Counter(cost.status for cost in costs).items())))
    figures.none("unplanned statuses", [cost.told for cost in costs if not cost.meant])
    figures.none("workers replaced", [cost.told for cost in costs if cost.replaced])
    for what, key, bar, unit in (
        ("of the processor", lambda cost: cost.cpu_seconds, CPU_SECONDS, "s"),
        ("above an idle worker", lambda cost: cost.n_bytes / MIB, MEMORY, "MiB"),
    ):
        costs.sort(key=key, reverse=True)
        figures.note(f"most {what}", [f"{cost.told}: {key(cost):.3g} {unit}" for cost in costs[:WORST]])
        figures.at_most(f"most {what}", key(costs[0]), bar, unit)
