"""A run of `primfit batch` as people start it, watched, with a node or the driver killed on the way."""

import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from datetime import datetime
from hashlib import sha256
from pathlib import Path
from typing import Any

import orjson

from . import asked as app
from .cluster import cluster, kill_node
from .records import Asked, Memory, RunError, RunRecord, machine
from .sets import SegmentSet
from .watch import Watch, loopback, watching

SLEEP = 0.2
"""Seconds from one look at the parts to the next."""

PATIENCE = 120.0
"""Seconds in which the workers of a driver that was killed end."""


@dataclass
class Parts:
    """The parts of a run as they come: each is written anew, not changed, so that another file in its place
    is work done twice."""

    out: Path
    seen: dict[str, tuple[int, int]] = field(default_factory=dict)
    twice: set[str] = field(default_factory=set)
    _tasks: int = 0

    def look(self) -> None:
        for file in app.part_files(self.out):
            stat = file.stat()
            now = (stat.st_ino, stat.st_mtime_ns)
            if self.seen.setdefault(file.name, now) != now:
                self.twice.add(file.name)
                self.seen[file.name] = now

    @property
    def share(self) -> float:
        """Of the tasks that are finished."""
        plan = self.out / app.FOLDER / "plan.jsonl"
        if not self._tasks and plan.exists():
            self._tasks = plan.read_bytes().count(b"\n")
        return len(self.seen) / max(1, self._tasks)


def run(asked: Asked, folder: Path) -> RunRecord:
    """Make the run anew; raises `RunError`, and `FileNotFoundError` where its segments are not drawn."""
    chosen = SegmentSet(folder / "segments", asked.seed, asked.n)
    out = folder / "runs" / asked.name
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    command = [sys.executable, "-m", "primfit", "batch", f"@{chosen.listed()}", "--out", str(out)]
    command += ["--format", "parquet"]
    with cluster(asked.workers) if asked.executor == "ray" else nullcontext() as nodes, watching() as watch:
        if nodes is None:
            command += ["--workers", str(asked.workers)]
        else:
            command += ["--executor", "ray", "--address", nodes.address]
        before = loopback()
        went = _Course(asked, command, Parts(out), watch, nodes)
        went.go()
        moved = loopback() - before
        watch.look()
    return _record(asked, chosen, went, moved)


@dataclass
class _Course:
    """A run on its way."""

    asked: Asked
    command: list[str]
    parts: Parts
    watch: Watch
    nodes: Any
    wall: float = 0.0
    started: float = 0.0
    killed: float | None = None
    lost: int = 0

    def go(self) -> None:
        with self._driver() as process:
            if self.asked.kill != "none":
                self._follow(process, self.asked.at)
                self._kill(process)
            if self.asked.kill != "driver":
                self._follow(process)
                self._ended(process)
        if self.asked.kill == "driver":
            self._start_again()

    @contextmanager
    def _driver(self) -> Iterator[subprocess.Popen[bytes]]:
        begun = time.time()
        self.started = self.started or begun
        process = subprocess.Popen(self.command, stdout=subprocess.DEVNULL)
        self.watch.drivers.add(process.pid)
        try:
            yield process
        finally:
            process.kill()
            process.wait()
            self.wall += time.time() - begun

    def _follow(self, process: subprocess.Popen[bytes], share: float = 2.0) -> None:
        """Look at the parts until so many are finished, or the driver has ended."""
        while self.parts.share < share:
            try:
                process.wait(SLEEP)
            except subprocess.TimeoutExpired:
                self.parts.look()
            else:
                break
        self.parts.look()

    def _kill(self, process: subprocess.Popen[bytes]) -> None:
        if process.poll() is not None:
            raise RunError(f"the run ended with status {process.returncode} before anything was killed")
        self.killed = time.time() - self.started
        if self.asked.kill == "driver":
            process.kill()
        else:
            kill_node(self.nodes)

    def _ended(self, process: subprocess.Popen[bytes]) -> None:
        if process.returncode:
            raise RunError(f"primfit batch ended with status {process.returncode}")

    def _start_again(self) -> None:
        end = time.monotonic() + PATIENCE
        while self.watch.at_work():
            if time.monotonic() > end:
                raise RunError("workers of the driver that was killed do not end")
            time.sleep(SLEEP)
        self.parts.look()
        before = dict(self.parts.seen)
        with self._driver() as process:
            self._follow(process)
            self._ended(process)
        self.lost = sum(self.parts.seen.get(name) != stat for name, stat in before.items())


def _record(asked: Asked, chosen: SegmentSet, went: _Course, moved: int) -> RunRecord:
    import pyarrow.parquet

    out, watch = went.parts.out, went.watch
    files = app.part_files(out)
    ids: Counter[str] = Counter()
    statuses: Counter[str] = Counter()
    for file in files:
        table = pyarrow.parquet.read_table(str(file), columns=["id", "status"])
        ids.update(table["id"].to_pylist())
        statuses.update(table["status"].to_pylist())
    sums = [sha256(file.read_bytes()).hexdigest() for file in files]
    manifest = orjson.loads((out / app.FOLDER / "manifest.json").read_bytes())
    if not manifest["complete"] or [part["sha256"] for part in manifest["parts"]] != sums:
        raise RunError(f"the manifest in {out} does not say what is there")
    tasks = [app.holds(task) for task in app.planned(out)]
    there, back = app.sent(out)
    plan = out / app.FOLDER / "plan.jsonl"
    return RunRecord(
        asked=asked,
        machine=machine(),
        date=datetime.fromtimestamp(went.started).astimezone().isoformat(timespec="seconds"),
        wall=round(went.wall, 2),
        driver_cpu=round(watch.cpu("driver"), 2),
        worker_cpu=round(watch.cpu("worker"), 2),
        ray_cpu=round(watch.cpu("ray"), 2),
        memory=Memory(
            driver_rss=watch.most("driver", "rss"),
            driver_pss=watch.most("driver", "pss"),
            worker_rss=watch.most("worker", "rss"),
            worker_pss=watch.most("worker", "pss"),
            looks=[(look.at, look.driver, look.worker) for look in watch.looks],
        ),
        tasks=tasks,
        planned=round(plan.stat().st_mtime - went.started, 2),
        finished=[round(file.stat().st_mtime - went.started, 2) for file in files],
        killed=went.killed and round(went.killed, 2),
        lost=went.lost,
        twice=len(went.parts.twice),
        sent=there,
        answered=back,
        loopback=moved,
        points=sum(points for _, points, _ in tasks),
        bytes=sum(file.stat().st_size for file in files),
        rows=ids.total(),
        unique=len(ids),
        expected=asked.n,
        missing=sum(id not in ids for id in chosen.ids()),
        statuses=dict(sorted(statuses.items())),
        digest=sha256("\n".join(sums).encode()).hexdigest(),
    )
