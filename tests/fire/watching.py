"""A service seen from outside, in /proc: processor time, memory and descriptors of all its processes."""

import json
import os
from contextlib import suppress
from pathlib import Path

MIB = 2**20


class Watch:
    """The processes of the session that a service leads; one that ends while it is looked at counts as 0."""

    def __init__(self, pid: int) -> None:
        self.pid = pid

    def processes(self) -> list[int]:
        """All that live, the service first; a process that has ended and waits for its parent is none."""
        found = []
        for file in Path("/proc").glob("[0-9]*/stat"):
            with suppress(OSError):
                state, _, _, session = file.read_text().rpartition(")")[2].split()[:4]
                if int(session) == self.pid and state != "Z":
                    found.append(int(file.parent.name))
        return sorted(found)

    def pss(self) -> int:
        """Bytes: the memory of all, where pages that several share count once."""
        return sum(map(pss, self.processes()))

    def descriptors(self) -> int:
        n_open = 0
        for pid in self.processes():
            with suppress(OSError):
                n_open += len(os.listdir(f"/proc/{pid}/fd"))
        return n_open


def pss(pid: int) -> int:
    """Bytes that a process holds now; pages that several share count in part."""
    return _kib(pid, "smaps_rollup", "Pss:") * 1024


def cpu_seconds(pid: int) -> float:
    """What all threads of a process have taken of the processor."""
    nanoseconds = 0
    for task in Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with suppress(OSError):
            nanoseconds += int(task.read_text().split()[0])
    return nanoseconds / 1e9


def resident(pid: int) -> int:
    """Bytes that a process holds now."""
    return _kib(pid, "status", "VmRSS:") * 1024


def peak(pid: int) -> int:
    """The most bytes that a process held since it was told to `forget_peak`."""
    return _kib(pid, "status", "VmHWM:") * 1024


def forget_peak(pid: int) -> None:
    Path(f"/proc/{pid}/clear_refs").write_text("5")


def faults(log: Path) -> list[str]:
    """The lines of a log in JSON that tell of a fault of the service."""
    found = []
    for line in log.read_text().splitlines():
        event = json.loads(line) if line.startswith("{") else {"message": line}
        status = event.get("status", 0)
        if status in (500, 502) or "Traceback" in line:
            found.append(line[:200])
    return found


def _kib(pid: int, file: str, field: str) -> int:
    with suppress(OSError):
        for line in Path(f"/proc/{pid}/{file}").read_text().splitlines():
            if line.startswith(field):
                return int(line.split()[1])
    return 0
