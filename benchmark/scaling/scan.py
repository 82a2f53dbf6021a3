"""One large scan with labels in random order: what it takes beside reading it and fitting its segments.

The same segments are written as Parquet, in the order that their points have in the scan: so the answers can
be held against each other as well as the times.
"""

import shutil
import subprocess
import sys
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from primfit.synthetic import clouds
from primfit.synthetic.recipes import Range

from .asked import answers
from .records import RunError, machine, now, written
from .sets import PER_FILE, RECIPE, write_rows
from .watch import watching

STEP = 1e-5
"""Meters, of the coordinates in the scan."""
PIECE = 1_000_000
"""Points that are written or read at once."""
WORKERS = 2
LABEL = "segment"


@dataclass(frozen=True)
class Scan:
    """A scan of segments with so many points each, and the same segments as Parquet."""

    folder: Path
    segments: int
    points: int
    seed: int

    @property
    def file(self) -> Path:
        return self.folder / "scan.laz"

    @property
    def rows(self) -> list[Path]:
        """Files of segments, in the order of their labels."""
        count = -(-self.segments // PER_FILE)
        return [self.folder / "segments" / f"{number:05}.parquet" for number in range(count)]

    @property
    def total(self) -> int:
        """Points of the scan."""
        return self.segments * self.points

    def draw(self) -> None:
        """Write it unless it is there; the scan is the last of it, there whole or not at all."""
        if self.file.exists():
            return
        steps = self._steps()
        for number, file in enumerate(self.rows):
            own = steps[number * PER_FILE : (number + 1) * PER_FILE]
            file.parent.mkdir(parents=True, exist_ok=True)
            write_rows(file, number * PER_FILE, list(own * STEP))
        self._write(steps.reshape(-1, 3))

    def _steps(self) -> NDArray[np.int32]:
        """Coordinates (segments, points, 3) in steps."""
        recipe = replace(RECIPE, seed=self.seed, points=Range(self.points, self.points))
        found = np.empty((self.segments, self.points, 3), np.int32)
        for own, cloud in zip(found, clouds(recipe, self.segments), strict=True):
            own[:] = np.rint((cloud.points - cloud.points.mean(axis=0)) / STEP)
        return found

    def _write(self, steps: NDArray[np.int32]) -> None:
        """As LAZ, every segment's points in their order, but between those of all others."""
        import laspy

        labels = np.repeat(np.arange(self.segments, dtype=np.uint16), self.points)
        np.random.default_rng(self.seed).shuffle(labels)
        source = np.empty(self.total, np.int64)
        source[np.argsort(labels, kind="stable")] = np.arange(self.total)
        header = laspy.LasHeader(point_format=6, version="1.4")
        header.scales = np.full(3, STEP)
        header.add_extra_dim(laspy.ExtraBytesParams(name=LABEL, type=np.uint16))
        part = self.file.with_suffix(".part.laz")
        with laspy.open(str(part), mode="w", header=header) as file:
            for start in range(0, self.total, PIECE):
                piece = slice(start, start + PIECE)
                points = laspy.ScaleAwarePointRecord.zeros(len(labels[piece]), header=header)
                points.X, points.Y, points.Z = steps[source[piece]].T
                points[LABEL] = labels[piece]
                file.write_points(points)
        part.replace(self.file)

    def read(self) -> float:
        """Seconds of reading the scan piece by piece."""
        import laspy

        begun, total = time.perf_counter(), 0
        with laspy.open(str(self.file)) as file:
            for points in file.chunk_iterator(PIECE):
                total += len(np.column_stack([points.x, points.y, points.z, points[LABEL]]))
        if total != self.total:
            raise RunError(f"{self.file} holds {total:,} points, not {self.total:,}")
        return time.perf_counter() - begun


@dataclass(frozen=True)
class ScanRecord:
    """What it took.

    Attributes
    ----------
    read : seconds of reading the scan
    fit : seconds of `primfit batch` on the segments as Parquet
    whole : seconds of `primfit batch` on the scan
    memory : MiB, the most that any process of the latter had, resident
    answers : segments of which both have the same status, kind, number of points and radius
    """

    segments: int
    points: int
    machine: str
    date: str
    read: float
    fit: float
    whole: float
    memory: float
    answers: int

    @property
    def ratio(self) -> float:
        """Times the scan takes what reading it and fitting its segments take."""
        return self.whole / (self.read + self.fit)

    def save(self, folder: Path) -> Path:
        return written(folder / "scan.json", asdict(self))


def measured(scan: Scan) -> ScanRecord:
    """What it takes; raises `RunError`."""
    read = scan.read()
    out = scan.folder / "of-segments", scan.folder / "of-scan"
    fit, _ = _batch([*map(str, scan.rows)], out[0])
    whole, memory = _batch([str(scan.file), "--labels", LABEL], out[1])
    first, second = map(answers, out)
    same = sum(one == other for one, other in zip(first, second, strict=True))
    return ScanRecord(
        scan.segments,
        scan.total,
        machine(),
        now(),
        round(read, 1),
        round(fit, 1),
        round(whole, 1),
        memory,
        same,
    )


def _batch(inputs: list[str], out: Path) -> tuple[float, float]:
    """Seconds of a run from the start, and the most MiB of a process."""
    shutil.rmtree(out, ignore_errors=True)
    command = [sys.executable, "-m", "primfit", "batch", *inputs, "--out", str(out), "--format", "parquet"]
    begun = time.perf_counter()
    with watching() as watch:
        done = subprocess.run([*command, "--workers", str(WORKERS)], stdout=subprocess.DEVNULL, check=False)
        seconds = time.perf_counter() - begun
    if done.returncode:
        raise RunError(f"primfit batch ended with status {done.returncode}")
    return seconds, max(process.rss for process in watch.known.values())


def told(record: ScanRecord) -> str:
    """The figures, for people: a list in Markdown."""
    return "\n".join(
        [
            f"{record.points:,} points of {record.segments:,} segments in random order:",
            "",
            f"- Reading takes {record.read} s, fitting {record.fit} s, the scan {record.whole} s: "
            f"{record.ratio:.2f} times both.",
            f"- A process has {record.memory:.0f} MiB of memory at most, resident.",
            f"- {record.answers:,} of {record.segments:,} answers agree in status, kind, points and radius.",
        ]
    )
