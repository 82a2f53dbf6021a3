"""Processor time and memory of the processes below this one, from /proc while they run."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from threading import Event, Thread
from time import monotonic
from typing import Literal

EVERY = 0.5
"""Seconds from one look to the next; what a process does after the last one before its end is not counted."""

SHARED_EVERY = 10
"""Looks after which memory is asked for that is shared, which costs some milliseconds a process."""

TICK = 1 / os.sysconf("SC_CLK_TCK")
MIB = 1024.0

RAY_WORKERS = ("ray::primfit", "ray::IDLE")
"""Names of processes that do tasks of Ray; its agents are called `ray::`, too."""

Role = Literal["driver", "worker", "ray", "other"]


@dataclass
class Process:
    """What is known of a process.

    Attributes
    ----------
    born : clock ticks since the start of the machine; with the number of the process no other has it
    cpu : seconds of processor time, user and system
    rss, pss : the most memory that it had in MiB: resident as the kernel keeps it, and, at the looks, with
        what it shares counted in equal shares
    """

    pid: int
    parent: int
    born: int
    role: Role
    cpu: float = 0.0
    rss: float = 0.0
    pss: float = 0.0


@dataclass(frozen=True)
class Look:
    """The memory at a time [s since the start] in MiB: of the driver, and of the largest worker."""

    at: float
    driver: float
    worker: float


@dataclass
class Watch:
    """The processes below this one, since `watching` began."""

    drivers: set[int] = field(default_factory=set)
    known: dict[tuple[int, int], Process] = field(default_factory=dict)
    looks: list[Look] = field(default_factory=list)
    _begun: float = field(default_factory=monotonic)
    _n: int = 0

    def look(self) -> None:
        """Ask for all of them once."""
        alive = [process for process in self._found() if self._asked(process)]
        if self._n % SHARED_EVERY == 0:
            memory = {role: [_pss(p) for p in alive if p.role == role] for role in ("driver", "worker")}
            most = {role: max(values, default=0.0) for role, values in memory.items()}
            self.looks.append(Look(round(monotonic() - self._begun, 1), most["driver"], most["worker"]))
        self._n += 1

    def at_work(self) -> int:
        """How many workers are at a task, or may be: those of Ray say it by their name."""
        return sum(_at_work(p) for p in list(self.known.values()) if p.role == "worker")

    def cpu(self, role: Role) -> float:
        """Seconds of processor time of all processes of a role."""
        return sum(process.cpu for process in self.known.values() if process.role == role)

    def most(self, role: Role, what: Literal["rss", "pss"]) -> float:
        """The most MiB that one process of a role had."""
        return round(max((getattr(p, what) for p in self.known.values() if p.role == role), default=0.0), 1)

    def _found(self) -> list[Process]:
        """Processes below this one, and those known that have lost their parents."""
        stats = dict(_stats())
        below = {os.getpid()} | {pid for pid, (_, born, _) in stats.items() if (pid, born) in self.known}
        more = True
        while more:
            found = {pid for pid, (parent, *_) in stats.items() if parent in below} - below
            below |= found
            more = bool(found)
        return [self._known(pid, *stats[pid]) for pid in below - {os.getpid()} if pid in stats]

    def _known(self, pid: int, parent: int, born: int, cpu: float) -> Process:
        process = self.known.setdefault((pid, born), Process(pid, parent, born, "other"))
        process.cpu = max(process.cpu, cpu)
        return process

    def _asked(self, process: Process) -> bool:
        """Whether it is alive; its role changes, for processes of Ray are named by what they do."""
        try:
            if process.role != "worker":
                process.role = self._role(process)
            status = Path(f"/proc/{process.pid}/status").read_text()
        except OSError:
            return False
        if "VmHWM:" not in status:
            return False
        process.rss = max(process.rss, int(status.partition("VmHWM:")[2].split()[0]) / MIB)
        return True

    def _role(self, process: Process) -> Role:
        if process.pid in self.drivers:
            return "driver"
        command = _command(process.pid)
        if command.startswith(RAY_WORKERS):
            return "worker"
        if "forkserver" in command:
            return "worker" if "forkserver" in _command(process.parent) else "other"
        return "ray" if "/ray/" in command else "other"


@contextmanager
def watching() -> Iterator[Watch]:
    """Look again and again, until the end of the `with`."""
    watch, over = Watch(), Event()

    def go_on() -> None:
        while not over.wait(EVERY):
            watch.look()

    thread = Thread(target=go_on, daemon=True)
    thread.start()
    try:
        yield watch
    finally:
        over.set()
        thread.join()


def loopback() -> int:
    """Bytes that went over the network of this machine alone since it started."""
    lines = Path("/proc/net/dev").read_text().splitlines()
    [line] = [each for each in lines if each.lstrip().startswith("lo:")]
    return int(line.partition(":")[2].split()[0])


def _stats() -> Iterator[tuple[int, tuple[int, int, float]]]:
    """Parent, birth and processor time of all processes."""
    for name in os.listdir("/proc"):
        if not name.isdecimal():
            continue
        try:
            fields = Path(f"/proc/{name}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        yield int(name), (int(fields[1]), int(fields[19]), TICK * (int(fields[11]) + int(fields[12])))


def _command(pid: int) -> str:
    return Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")


def _at_work(process: Process) -> bool:
    try:
        fields = Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
        command = _command(process.pid)
    except OSError:
        return False
    return int(fields[19]) == process.born and fields[0] not in "ZX" and not command.startswith("ray::IDLE")


def _pss(process: Process) -> float:
    try:
        lines = Path(f"/proc/{process.pid}/smaps_rollup").read_text()
    except OSError:
        return 0.0
    pss = int(lines.partition("\nPss:")[2].split()[0]) / MIB if "\nPss:" in lines else 0.0
    process.pss = max(process.pss, pss)
    return round(pss, 1)
