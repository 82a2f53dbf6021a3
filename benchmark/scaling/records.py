"""What is kept of a run, as JSON."""

import os
import platform
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path
from typing import Any, Literal, Self

import orjson

Kill = Literal["none", "node", "driver"]
Executor = Literal["local", "ray"]

FOLDER = Path("build/scaling")
"""Where segments, runs and records are unless something else is said."""


class RunError(RuntimeError):
    """The command failed, or ended before what was to be killed was killed."""


@dataclass(frozen=True)
class Asked:
    """Which run it is.

    Attributes
    ----------
    workers : processes of the executor local; nodes of a cluster, with one processor each
    kill, at : what is killed when this share of the tasks is finished
    turn : the same run may be made several times
    """

    n: int
    seed: int
    executor: Executor
    workers: int
    kill: Kill = "none"
    at: float = 0.0
    turn: int = 1

    @property
    def name(self) -> str:
        killed = "" if self.kill == "none" else f"-{self.kill}-killed"
        return f"{self.executor}-{self.workers}-{self.n}{killed}" + (f"-{self.turn}" if self.turn > 1 else "")


@dataclass(frozen=True)
class Memory:
    """The most MiB that one process had; see `watch.Process`. Looks are (seconds, driver, largest worker) of
    what it had at a time, with what is shared counted in equal shares."""

    driver_rss: float
    driver_pss: float
    worker_rss: float
    worker_pss: float
    looks: list[tuple[float, float, float]]


@dataclass(frozen=True)
class RunRecord:
    """What a run took, and what it left.

    Attributes
    ----------
    wall : seconds from the start of the command to its end; of a driver that was killed and started again,
        of both, without the pause between them
    date : when it began
    driver_cpu, worker_cpu, ray_cpu : seconds of processor time: of the driver, of all workers, and of the
        other processes of Ray
    planned, finished : seconds from the start to the plan, and to the part of each task
    tasks : of each its segments, their points, and the sum of the squares of these
    killed : seconds from the start to the kill, or None
    lost : parts that were there when the driver was killed, and are no longer as they were
    twice : parts that were seen to be written twice
    sent, answered : bytes of what goes to a process for all tasks, and of what comes back
    loopback : bytes over the network of this machine alone, of all programs
    rows, unique, expected : rows in all parts, different ids among them, and segments that were asked for
    missing : segments without a row
    digest : SHA-256 of the SHA-256 of all parts
    """

    asked: Asked
    machine: str
    date: str
    wall: float
    driver_cpu: float
    worker_cpu: float
    ray_cpu: float
    memory: Memory
    tasks: list[tuple[int, int, int]]
    planned: float
    finished: list[float]
    killed: float | None
    lost: int
    twice: int
    sent: int
    answered: int
    loopback: int
    points: int
    bytes: int
    rows: int
    unique: int
    expected: int
    missing: int
    statuses: dict[str, int]
    digest: str

    @property
    def once(self) -> bool:
        """Whether each segment that was asked for has exactly one row."""
        return self.rows == self.unique == self.expected and not self.missing

    def save(self, folder: Path) -> Path:
        return written(folder / "runs" / f"{self.asked.name}.json", asdict(self))

    @classmethod
    def read(cls, file: Path) -> Self:
        known: dict[str, Any] = orjson.loads(file.read_bytes())
        asked, memory = Asked(**known.pop("asked")), Memory(**known.pop("memory"))
        return cls(asked=asked, memory=memory, **known)


def records(folder: Path) -> list[RunRecord]:
    """All runs that are kept, the small ones first."""
    found = [RunRecord.read(file) for file in (folder / "runs").glob("*.json")]
    return sorted(found, key=lambda record: (record.asked.n, record.asked.name))


def told(record: RunRecord) -> str:
    """The figures of a run, for people."""
    asked, memory, finished = record.asked, record.memory, record.finished
    killed = [] if record.killed is None else [f"  {asked.kill} killed after {record.killed:.1f} s"]
    lines = [
        f"{asked.name}: {asked.n:,} segments, {record.points:,} points, {len(record.tasks)} tasks",
        f"  {record.wall:.1f} s; plan after {record.planned:.1f} s, parts after {min(finished):.1f} to "
        f"{max(finished):.1f} s",
        *killed,
        f"  processor: driver {record.driver_cpu:.1f} s, workers {record.worker_cpu:.1f} s, "
        f"Ray itself {record.ray_cpu:.1f} s",
        f"  most memory (resident, own share): driver {memory.driver_rss:.0f}, {memory.driver_pss:.0f} MiB; "
        f"a worker {memory.worker_rss:.0f}, {memory.worker_pss:.0f} MiB",
        f"  bytes: {record.sent:,} to workers, {record.answered:,} back, {record.loopback:,} over loopback, "
        f"{record.bytes:,} in parts",
        f"  rows {record.rows:,}, different {record.unique:,}, missing {record.missing:,}; "
        f"parts written twice {record.twice}, finished ones done again {record.lost}",
        f"  SHA-256 of all parts: {record.digest}",
    ]
    return "\n".join(lines)


def written(file: Path, content: Any) -> Path:
    """Write JSON, whole or not at all."""
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_bytes(orjson.dumps(content, option=orjson.OPT_INDENT_2) + b"\n")
    os.replace(part, file)
    return file


def machine() -> str:
    """Which one this is, in words."""
    names = [
        line.partition(":")[2].strip()
        for line in Path("/proc/cpuinfo").read_text().splitlines()
        if line.startswith("model name")
    ]
    return f"{names[0] if names else platform.machine()}, {os.cpu_count()} processors"


def now() -> str:
    return datetime.now().astimezone().isoformat(timespec="seconds")
