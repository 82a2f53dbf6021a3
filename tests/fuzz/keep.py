"""Keep few of the inputs that fuzzing found: `python -m tests.fuzz.keep [NAME ...]`.

From `build/fuzz/NAME` to `corpus/NAME`: the smallest first, and of them each that reaches a line of the
readers which none before it reaches, up to some kilobytes a target.
"""

import hashlib
import sys
from contextlib import suppress
from types import FrameType
from typing import Any

from tests.fuzz.__main__ import BUILD, CORPUS
from tests.fuzz.seeds import SEEDS
from tests.fuzz.targets import TARGETS

_MOST_BYTES = 6 * 1024
_TRACED = ("/app/readers/", "/app/wire/")
Lines = set[tuple[str, int]]


def _lines(name: str, data: bytes) -> Lines:
    """The lines of the readers that an input reaches."""
    reached: Lines = set()

    def trace(frame: FrameType, event: str, _: Any) -> Any:
        file = frame.f_code.co_filename
        if not any(part in file for part in _TRACED):
            return None
        reached.add((file, frame.f_lineno))
        return trace

    sys.settrace(trace)
    try:
        with suppress(Exception):
            TARGETS[name](data)
    finally:
        sys.settrace(None)
    return reached


def keep(name: str) -> None:
    reached = set().union(*(_lines(name, seed) for seed in SEEDS[name]))
    folder, n_bytes = CORPUS / name, 0
    found = {path.read_bytes() for at in (BUILD / name, folder) for path in at.glob("*")}
    for path in folder.glob("*"):
        path.unlink()
    for data in sorted(found, key=lambda data: (len(data), data)):
        lines = _lines(name, data)
        if lines <= reached or n_bytes + len(data) > _MOST_BYTES:
            continue
        reached |= lines
        n_bytes += len(data)
        folder.mkdir(parents=True, exist_ok=True)
        (folder / hashlib.sha256(data).hexdigest()[:12]).write_bytes(data)
    print(f"{name}: {len(list(folder.glob('*')))} inputs, {n_bytes} bytes, {len(reached)} lines")


if __name__ == "__main__":
    for each in sys.argv[1:] or TARGETS:
        keep(each)
