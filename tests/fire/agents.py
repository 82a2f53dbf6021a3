"""What a call of a tool takes beside the fit: `python -m tests.fire.agents`, with the extra `mcp`.

The official client asks real servers, over standard input and output and over HTTP, about a file of 100,000
points; in turns with it the same points are fitted in this process, which has read them already.
"""

import argparse
import asyncio
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

import primfit
from primfit.benchmark.service import csv, npy
from tests.app.agents.clients import Client, http_server, stdio
from tests.fire.report import Report, reported
from tests.fire.traffic import points

N_POINTS, TURNS = 100_000, 5
MOST = 1.0
"""Seconds: the bar for what a call may take beyond the fit."""


async def beyond(client: Client, file: Path, tool: str, cloud: np.ndarray, n_turns: int) -> np.ndarray:
    """Seconds (n_turns, 2) of a call, and of the fit alone; the first calls are not counted."""
    seconds = []
    for _ in range(n_turns + 1):
        started = perf_counter()
        result = await client.call_tool(tool, {"path": str(file)}, read_timeout_seconds=60)
        called = perf_counter()
        assert not result.is_error, result
        primfit.fit(cloud)
        seconds.append((called - started, perf_counter() - called))
    return np.array(seconds[1:])


async def note(figures: Report, client: Client, way: str, folder: Path, n_turns: int) -> None:
    """Measure each tool with each file."""
    cloud = points("cylinder", N_POINTS)
    for name, write in (("npy", npy), ("csv", csv)):
        file = folder / f"cloud.{name}"
        file.write_bytes(write(cloud))
        for tool in ("fit", "explain"):
            seconds = await beyond(client, file, tool, cloud, n_turns)
            what = f"{tool} of {name} over {way}"
            for which, of in (("median", np.median), ("least", np.min)):
                call, alone = of(seconds, axis=0).tolist()
                figures.note(f"{what}, and the fit alone, {which}", [round(call, 3), round(alone, 3)], "s")
            added = float(np.median(seconds[:, 0] - seconds[:, 1]))
            figures.at_most(f"{what}, beyond the fit", added, MOST, "s", clock=True)


def measure(figures: Report, n_turns: int = TURNS) -> None:
    """Both ways to a server, one after the other."""
    with TemporaryDirectory(prefix="primfit-fire-") as name:
        folder = Path(name)

        async def over_stdio() -> None:
            async with stdio(folder) as client:
                await note(figures, client, "stdio", folder, n_turns)

        asyncio.run(over_stdio())
        with http_server(folder / "log", "--root", name) as server:

            async def over_http() -> None:
                async with Client(server.url) as client:
                    await note(figures, client, "HTTP", folder, n_turns)

            asyncio.run(over_http())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--turns", type=int, default=TURNS)
    given = parser.parse_args()
    with reported("agents") as figures:
        figures.note("points", N_POINTS)
        measure(figures, given.turns)
    sys.exit(1 if figures.missed else 0)


if __name__ == "__main__":
    main()
