"""The folder that exports are written into: whole files or none, and nothing overwritten unless asked for."""

import os
import secrets
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..engine.names import plain
from ..exports import FORMATS
from ..readers.errors import FieldError
from ..wire.problems import InvalidOptionsError, room_needed

_PACKED = (".gz", ".zst")


def unfinished(owner: int) -> str:
    """How the names begin of files that are being written for the server with this number of its process."""
    return f".primfit-{owner}-"


@dataclass(frozen=True)
class Output:
    """Where the files of one export go.

    Attributes
    ----------
    folder : for them
    name : what the name of each begins with
    owner : number of the process of the server
    overwrite : whether files of these names may be replaced
    source : the file that is read, which never is; None where it lies elsewhere
    """

    folder: Path
    name: str
    owner: int
    overwrite: bool = False
    source: Path | None = None

    def target(self, artifact: str) -> Path:
        return self.folder / f"{self.name}-{FORMATS[artifact].file_name}"

    def check(self, artifacts: Iterable[str]) -> None:
        """Raise `InvalidOptionsError` where a file would be overwritten."""
        for artifact in artifacts:
            target = self.target(artifact)
            if self.source is not None and target.exists() and target.samefile(self.source):
                raise _refused("name", f"{target.name} is the file that is read; give another name")
            if not self.overwrite and os.path.lexists(target):
                raise _exists(target)

    def write(self, artifact: str, content: bytes) -> dict[str, Any]:
        """Write a file, which has its name only when it is whole; what to tell of it."""
        target = self.target(artifact)
        being_written = self.folder / f"{unfinished(self.owner)}{secrets.token_hex(8)}"
        with room_needed(f"files in {self.folder}"):
            try:
                with being_written.open("xb") as file:
                    file.write(content)
                self._place(being_written, target)
            finally:
                with suppress(FileNotFoundError):
                    being_written.unlink()
        return {"artifact": artifact, "path": str(target), "n_bytes": len(content)}

    def _place(self, file: Path, target: Path) -> None:
        if self.overwrite:
            file.replace(target)
            return
        try:
            os.link(file, target)
        except FileExistsError:
            raise _exists(target) from None
        except OSError:  # a file system without a second name for a file
            if os.path.lexists(target):
                raise _exists(target) from None
            file.rename(target)


def name_of(given: str | None, file: str | None) -> str:
    """What names begin with: as given, else as the cloud's file, without its suffixes.

    Raises `InvalidOptionsError` where what is given is not the name of a file.
    """
    if given is not None:
        if not given or plain(given) != given:
            raise _refused(
                "name", "is not fit for the name of a file, of at most 80 characters and no folder"
            )
        return given
    name = file or "cloud"
    if name.lower().endswith(_PACKED):
        name = name.rpartition(".")[0]
    return plain(name.rpartition(".")[0] or name) or "cloud"


def _exists(target: Path) -> InvalidOptionsError:
    return _refused("overwrite", f"{target.name} exists; give `overwrite: true`, or another `name`")


def _refused(field: str, why: str) -> InvalidOptionsError:
    return InvalidOptionsError([FieldError(field, why)])
