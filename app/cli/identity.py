"""By which a file is known under all of its names, links among them."""

import os
from pathlib import Path


def identity(file: str | Path) -> tuple[int, int] | None:
    """Device and number on it; None where there is no file."""
    try:
        found = os.stat(file)
    except OSError:
        return None
    return found.st_dev, found.st_ino
