"""The worker processes of a running service, looked at from outside."""

import contextlib
from pathlib import Path

import pytest

needs_proc = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds the workers in /proc")


def workers(pid: int) -> list[int]:
    """The worker processes of a service: what was forked by its fork server."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
    forkers = {child for child, parent in parents.items() if parent == pid}
    return [child for child, parent in parents.items() if parent in forkers]


def ticks(pid: int) -> int:
    """Processor time that a process has used, in hundredths of a second."""
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11])
