"""What processes gain `primfit batch`, and what sharing the work costs: `primfit bench batch`.

The same scans are answered by one process and by several, in turns, and so are a few of them, which shows
what a start takes. Of each the least time counts: other programs only add to it.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from primfit.synthetic import cloud
from primfit.synthetic.recipes import Range

from .service import SCAN

FEW, LEAST = 8, 100
"""Clouds of a run that is mostly the start, and the fewest of one that is mostly work."""

BAR = 1.85
"""Times the throughput of one process that two are to reach."""

SHARE = (5.0, 5.0)
"""A fit of so many milliseconds is to cost the parent so many percent of that at most."""


@dataclass(frozen=True)
class Use:
    """Seconds by the clock, and of processor time in the process that was started, without its children."""

    wall: float
    cpu: float

    def __sub__(self, other: "Use") -> "Use":
        return Use(self.wall - other.wall, self.cpu - other.cpu)

    def least(self, other: "Use") -> "Use":
        return Use(min(self.wall, other.wall), min(self.cpu, other.cpu))


def draw(folder: Path, n: int, points: int, seed: int) -> list[Path]:
    """Scans of all kinds, as files of NumPy."""
    recipe = replace(SCAN, seed=seed, points=Range(points, points))
    files = [folder / f"{index:05}.npy" for index in range(n)]
    for index, file in enumerate(files):
        np.save(file, cloud(recipe, index).points)
    return files


def used(files: Sequence[Path], workers: int) -> Use:
    """What `primfit batch` takes for the files; raises `RuntimeError` where it fails."""
    with TemporaryDirectory() as out:
        command = [sys.executable, "-m", "primfit", "batch", *map(str, files), "--out", out]
        started = time.perf_counter()
        process = subprocess.Popen([*command, "--workers", str(workers)], stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        wall = time.perf_counter() - started
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"primfit batch ended with status {process.returncode}")
    return Use(wall, usage.ru_utime + usage.ru_stime)


def measure(files: Sequence[Path], workers: int, turns: int) -> dict[tuple[int, int], Use]:
    """The least use for few and for all of the files, by one and by so many processes."""
    runs = [(n, size) for n in (FEW, len(files)) for size in (1, workers)]
    found: dict[tuple[int, int], Use] = {}
    for _ in range(turns):
        for n, size in runs:
            use = used(files[:n], size)
            found[n, size] = use.least(found.get((n, size), use))
    return found


def table(found: dict[tuple[int, int], Use], n: int, workers: int) -> str:
    """The figures for people, those of a cloud without what the start takes."""
    alone, shared = ((found[n, size] - found[FEW, size]) for size in (1, workers))
    clouds, gain = n - FEW, alone.wall / shared.wall
    parent, walls = 1e3 * shared.cpu / clouds, [1e3 * use.wall / clouds for use in (alone, shared)]
    milliseconds, percent = SHARE
    lines = [
        f"| | 1 process | {workers} processes |",
        "|---|---|---|",
        f"| start, with {FEW} clouds | {found[FEW, 1].wall:.2f} s | {found[FEW, workers].wall:.2f} s |",
        f"| a cloud, by the clock | {walls[0]:.2f} ms | {walls[1]:.2f} ms |",
        f"| a cloud, CPU of the first process | {1e3 * alone.cpu / clouds:.2f} ms | {parent:.3f} ms |",
        "",
        f"{workers} processes do {gain:.2f} times as much as one; bar for two: {BAR}.",
        f"The first process spends {100 * parent / milliseconds:.1f}% of a fit of {milliseconds:g} ms; "
        f"bar: {percent:g} %.",
    ]
    return "\n".join(lines)


def batch_action(options: argparse.Namespace) -> int:
    with TemporaryDirectory() as folder:
        files = draw(Path(folder), options.n, options.points, options.seed)
        print(table(measure(files, options.workers, options.turns), options.n, options.workers))
    return 0
