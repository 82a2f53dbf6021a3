"""Temporary files of the service, and how many bytes of bodies may be in them at one time."""

import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from ..wire.problems import InsufficientStorageError, room_needed


class Spool:
    """The folder for bodies that are too large for memory, and what is kept there together.

    Parameters
    ----------
    directory : None for that of the system
    limit : bytes; None for half of what is free now
    owner : stands in the names of the files, so that all of them can be found
    """

    def __init__(self, directory: Path | None, limit: int | None, owner: int) -> None:
        self._directory = Path(directory or tempfile.gettempdir())
        self._prefix = f"primfit-{owner}-"
        self._limit = limit if limit is not None else shutil.disk_usage(self._directory).free // 2
        self.used = 0

    @property
    def pattern(self) -> Path:
        """What all of the files match."""
        return self._directory / f"{self._prefix}*"

    def clear(self) -> None:
        """Remove what is left here of all owners."""
        for file in self._directory.glob("primfit-*"):
            file.unlink(missing_ok=True)

    def file(self) -> Any:
        """An empty file, open for writing, which goes when it is closed."""
        with room_needed():
            return tempfile.NamedTemporaryFile(prefix=self._prefix, dir=self._directory)

    @contextmanager
    def files(self) -> Iterator[Callable[[], Any]]:
        """Makes such files until the block ends, and they with it; asked later, it raises `ValueError`."""
        is_open = True

        def file() -> Any:
            if not is_open:
                raise ValueError("the request that this file is for has ended")
            return made.enter_context(self.file())

        with ExitStack() as made:
            try:
                yield file
            finally:
                is_open = False

    @contextmanager
    def share(self) -> Iterator["Share"]:
        """Room that is taken for one body, and given back at the end."""
        share = Share(self)
        try:
            yield share
        finally:
            self.used -= share.size

    def take(self, size: int) -> None:
        """Count so many bytes more; raises `InsufficientStorageError` where they are too many."""
        if self.used + size > self._limit:
            raise InsufficientStorageError(
                f"bodies of {self.used} bytes are being read, and {size} more would be over {self._limit}, "
                "the limit of this service (max_spooled_bytes); try again later"
            )
        self.used += size


class Share:
    """What one body has of the room."""

    def __init__(self, spool: Spool) -> None:
        self._spool, self.size = spool, 0

    def reach(self, size: int) -> None:
        """Have room for at least so many bytes."""
        if size > self.size:
            self._spool.take(size - self.size)
            self.size = size
