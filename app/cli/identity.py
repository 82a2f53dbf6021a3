"""By which a file is known under all of its names, links among them."""

import os
import sys
from pathlib import Path

STDIN = "-"


def identity(file: str | Path) -> tuple[int, int] | None:
    """Device and number on it, of `-` those of standard input; None where there is no file."""
    try:
        found = os.fstat(sys.stdin.fileno()) if file == STDIN else os.stat(file)
    except OSError:
        return None
    return found.st_dev, found.st_ino
