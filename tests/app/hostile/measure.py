"""Read hostile bytes in a process of their own, and see what they cost.

The process is forked from a server that has imported the readers and read a small file of every format, so
that what is measured is the input and not the imports.
"""

import atexit
import json
import os
import signal
import struct
import subprocess
import sys
from functools import cache
from typing import Any

from primfit.app.readers import (
    InvalidPointsError,
    TooLargeError,
    UnreadableFileError,
    read,
    without_missing,
)
from primfit.app.service.settings import Settings
from tests.paths import ROOT

LIMITS = Settings().limits
MEMORY = 64 * 2**20
_WORK = 5
"""Seconds of the processor. One is meant; on a busy machine the same work takes several times as long."""
_CLASSES = {kind.__name__: kind for kind in (UnreadableFileError, InvalidPointsError, TooLargeError)}


def refused(data: bytes) -> UnreadableFileError:
    """The error that reading `data` ends in, with little work and 64 MB; anything else fails the test."""
    found = ask(data)
    assert "died" not in found, f"the process ended with status {found['died']}"
    assert found["error"] in _CLASSES, f"not refused, but: {found['error']} {found['message']}"
    assert found["bytes"] < MEMORY
    return _CLASSES[found["error"]](found["field"], found["message"])


def ask(data: bytes) -> dict[str, Any]:
    server = _server()
    assert server.stdin is not None and server.stdout is not None
    server.stdin.write(struct.pack("<Q", len(data)) + data)
    server.stdin.flush()
    return json.loads(server.stdout.readline())


@cache
def _server() -> subprocess.Popen[bytes]:
    """Started once, for all tests of this process."""
    server = subprocess.Popen(
        [sys.executable, "-m", "tests.app.hostile.measure"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=ROOT,
    )
    atexit.register(server.communicate)
    return server


def _serve() -> None:
    """Answer each input with a line of JSON, from a child that is ended when it works too long."""
    from tests.app.readers.written import POINTS, e57, las, laz, npy, npz, pcd, ply, records

    vertices = records(POINTS)
    for data in (npy(POINTS), npz(points=POINTS), ply((vertices, "vertex")), las(), laz(), e57(POINTS)):
        read(data, LIMITS)
    for encoding in ("ascii", "binary", "binary_compressed"):
        read(pcd(POINTS, encoding), LIMITS)
    read(b"1,2,3\n4,5,6\n", LIMITS)
    while size := sys.stdin.buffer.read(8):
        data = sys.stdin.buffer.read(*struct.unpack("<Q", size))
        pid = os.fork()
        if not pid:
            signal.setitimer(signal.ITIMER_PROF, _WORK)
            print(json.dumps(_read(data)), flush=True)
            os._exit(0)
        _, status = os.waitpid(pid, 0)
        if status:
            print(json.dumps({"died": status}), flush=True)


def _read(data: bytes) -> dict[str, Any]:
    """What becomes of reading `data`, and the bytes it took."""
    peak = _peak()
    found: dict[str, Any] = {"error": "nothing", "message": ""}
    try:
        without_missing(read(data, LIMITS), "error")
    except UnreadableFileError as error:
        found = {"error": type(error).__name__, "field": error.field, "message": error.message}
    except BaseException as error:
        found = {"error": type(error).__name__, "message": str(error)}
    return {**found, "bytes": _peak() - peak}


def _peak() -> int:
    """Most bytes that this process ever held in memory."""
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


if __name__ == "__main__":
    _serve()
