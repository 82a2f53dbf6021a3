"""Mixed load, a tenth of it hostile: does a service grow with the minutes?

`python -m tests.fire.mixed --minutes 20 --runs 3` runs it three times, each on a new service.
"""

import argparse
import asyncio
import statistics
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from itertools import count, cycle
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

from tests.app.serving import Service, running, wait_for
from tests.fire.fuzz import hostile
from tests.fire.load import Answer, Client, statuses
from tests.fire.report import Report, reported
from tests.fire.traffic import mixed
from tests.fire.watching import MIB, Watch, faults

N_CLIENTS, WORKERS = 6, 2
"""Clients that ask as soon as they are answered: some requests always wait."""
EARLY = 8 / 20
"""Of the time: by then everything was used, and memory that is kept for the next request is there."""
WINDOW = 1 / 20
"""Of the time before that, and before the end, over which medians are taken: single clouds come and go."""
GROWTH = 1.03
LEAVES = 0.01
"""Seconds after which some clients leave: most of what they asked for is under way then."""
HEAD_PATIENCE, PATIENCE = 0.5, 60.0
REPLACED = 2
"""Descriptors of a worker that was replaced, which multiprocessing closes when it starts the next one."""


class Sample(NamedTuple):
    seconds: float
    pss: int
    descriptors: int
    files: int


def mixed_load(figures: Report, folder: Path, minutes: float) -> bool:
    """Whether the service stayed as it was; what is no matter of memory is held against its bar at once."""
    with running(folder / "bodies", workers=WORKERS, log_format="json") as service:
        watch = Watch(service.pid)
        asyncio.run(_load(service.port, 2.0))
        time.sleep(2.0)
        idle = watch.descriptors()
        answers, samples = asyncio.run(_watched(service, watch, 60 * minutes))
        with suppress(AssertionError):  # what is left then is told below
            wait_for(lambda: watch.descriptors() <= idle, patience=10.0)
        early, late = (_median(samples, share, minutes) for share in (EARLY, 1.0))
        figures.note("requests", len(answers))
        figures.note("statuses", statuses(answers))
        figures.note(f"memory at minute {EARLY * minutes:g}", early.pss / MIB, "MiB")
        figures.note(f"memory at minute {minutes:g}", late.pss / MIB, "MiB")
        figures.note("growth", 100 * (late.pss / early.pss - 1), "%")
        figures.note("descriptors then", early.descriptors)
        figures.at_most("descriptors in the end", late.descriptors, early.descriptors + REPLACED)
        figures.note("descriptors afterwards", [watch.descriptors(), idle])
        figures.note("temporary files then and in the end", [early.files, late.files])
        figures.none("temporary files afterwards", list(service.temporary_directory.iterdir()))
        figures.none("faults in the log", faults(service.log))
    return late.pss <= GROWTH * early.pss


async def _watched(service: Service, watch: Watch, seconds: float) -> tuple[list[Answer], list[Sample]]:
    started, samples = perf_counter(), []
    load = asyncio.ensure_future(_load(service.port, seconds))
    while not load.done():
        pss, descriptors = await asyncio.to_thread(lambda: (watch.pss(), watch.descriptors()))
        n_files = len(list(service.temporary_directory.iterdir()))
        samples.append(Sample(perf_counter() - started, pss, descriptors, n_files))
        await asyncio.sleep(1.0)
    return await load, samples


async def _load(port: int, seconds: float) -> list[Answer]:
    numbers, end = count(), perf_counter() + seconds
    found = await asyncio.gather(*(_client(port, numbers, end) for _ in range(N_CLIENTS)))
    return [answer for answers in found for answer in answers]


async def _client(port: int, numbers: Iterator[int], end: float) -> list[Answer]:
    """Of ten requests one is hostile; of fifty one is left before its answer."""
    client, answers, ordinary = Client(port), [], cycle(mixed())
    while perf_counter() < end:
        number = next(numbers)
        if number % 10 == 0:
            case = hostile(number // 10)
            answer = await client.ask(case.content, HEAD_PATIENCE if case.head else PATIENCE)
        else:
            answer = await client.ask(next(ordinary), LEAVES if number % 50 == 1 else PATIENCE)
        answers.append(answer._replace(content=b""))
    client.close()
    return answers


def _median(samples: list[Sample], share: float, minutes: float) -> Sample:
    """The middle of what was seen in the window that ends at this share of the time."""
    end, length = 60 * minutes * share, 60 * minutes * WINDOW
    seen = [sample for sample in samples if end - length <= sample.seconds <= end]
    return Sample(end, *(int(statistics.median(column)) for column in list(zip(*seen, strict=True))[1:]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--runs", type=int, default=3)
    given = parser.parse_args()
    held = []
    for run in range(given.runs):
        with (
            TemporaryDirectory(prefix="primfit-fire-") as folder,
            reported(f"mixed-{given.minutes:g}-minutes-{run + 1}") as figures,
        ):
            held.append(mixed_load(figures, Path(folder), given.minutes))
    print(f"it stayed within {100 * (GROWTH - 1):.0f}% in {sum(held)} of {len(held)} runs")
    sys.exit(0 if sum(held) >= 2 / 3 * len(held) else 1)


if __name__ == "__main__":
    main()
