"""Where tools may read from, and write to."""

from dataclasses import dataclass
from pathlib import Path

from .roots import Roots


@dataclass(frozen=True)
class Places:
    """The folders that paths may lead into, and the one for exports, if there is one."""

    roots: Roots
    output: Path | None = None
