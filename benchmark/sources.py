"""Which state of the code made a record."""

import hashlib
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = (
    ("fitting", "**/*.py"),
    ("fitting", "**/*.pyx"),
    ("fitting", "**/*.h"),
    ("models", "*.py"),
    ("models/weights", "*.npz"),
)
"""Folders and files that primfit's answers depend on."""


def own_files() -> list[Path]:
    """Those of `SOURCES`."""
    return [path for folder, pattern in SOURCES for path in sorted((ROOT / folder).glob(pattern))]


def paper_files(method: str) -> list[Path]:
    """What a method of the paper depends on besides: the code of all of them, and its own weights."""
    patterns = ("*.py", "parts/*.py", f"weights/{method}*.npz")
    return [path for pattern in patterns for path in sorted((ROOT / "paper").glob(pattern))]


def digest(files: Iterable[Path]) -> str:
    """The start of the SHA-256 of what is in them."""
    found = hashlib.sha256()
    for path in files:
        found.update(path.read_bytes())
    return found.hexdigest()[:8]
