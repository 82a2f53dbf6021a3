"""The folders that tools may read from, and how a path that an agent names leads into one of them, or not."""

import os
import stat
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Self

from ..readers.errors import TooLargeError, UnreadableFileError

_READ = os.O_RDONLY | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
# A pipe is opened without waiting for whoever writes to it; a link that was put in place meanwhile is not.
_AS_IT_IS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
_STEP_BY_STEP = os.open in os.supports_dir_fd


class PathRefusedError(UnreadableFileError):
    """The path leads to no file that may be read; the message names it, and says what would be."""

    def __init__(self, path: str, why: str) -> None:
        super().__init__("path", f"{path!r} {why}")
        self.given = path, why

    def __reduce__(self) -> tuple[type[Self], tuple[str, str]]:
        return type(self), self.given


@dataclass(frozen=True)
class Rooted:
    """A file under a root: the root, and the steps from there, none of which is a link."""

    given: str
    root: Path
    steps: tuple[str, ...]

    @property
    def path(self) -> Path:
        return self.root.joinpath(*self.steps)

    @property
    def name(self) -> str:
        return self.steps[-1]

    def read(self, limit: int) -> bytes:
        """All bytes of the file.

        Raises
        ------
        PathRefusedError
            It is no regular file, is gone, or may not be read.
        TooLargeError
            It holds more than `limit` bytes.
        """
        descriptor = self._opened()
        try:
            found = os.fstat(descriptor)
            if not stat.S_ISREG(found.st_mode):
                raise PathRefusedError(
                    self.given, f"is {_sort(found.st_mode)}; a file with a cloud is needed"
                )
            with os.fdopen(descriptor, "rb", closefd=False) as file:
                # Not as much as the system tells: a file may grow while it is read.
                content = file.read(limit + 1)
        finally:
            os.close(descriptor)
        if len(content) > limit:
            size = max(found.st_size, len(content))
            message = f"{self.given!r} holds {size} bytes; the limit is {limit} (max_body_bytes)"
            raise TooLargeError("path", message, f"{size} bytes")
        return content

    def _opened(self) -> int:
        """A descriptor of the file, reached step by step from the root, so that no link leads elsewhere."""
        try:
            if not _STEP_BY_STEP:
                return os.open(self.path, _READ | _AS_IT_IS)
            folder = os.open(self.root, _READ | os.O_DIRECTORY)
            for step in self.steps[:-1]:
                folder = _step(folder, step, _READ | os.O_DIRECTORY | _AS_IT_IS)
            return _step(folder, self.steps[-1], _READ | _AS_IT_IS)
        except (FileNotFoundError, NotADirectoryError):
            raise PathRefusedError(self.given, "leads to no file") from None
        except OSError as error:
            raise PathRefusedError(self.given, f"cannot be read: {error.strerror}") from None


@dataclass(frozen=True)
class Root:
    """A folder as it was named, and where that leads."""

    named: Path
    resolved: Path

    def within(self, path: Path) -> Path | None:
        """The way to a path from here by its words alone, or None; a relative one begins here."""
        if not path.is_absolute():
            return path
        for folder in (self.named, self.resolved):
            if path.is_relative_to(folder):
                return path.relative_to(folder)
        return None


@dataclass(frozen=True)
class Roots:
    """The folders; without any, no path is allowed."""

    folders: tuple[Root, ...] = ()

    @classmethod
    def of(cls, folders: Sequence[Path]) -> Self:
        """Raises `NotADirectoryError` where one is no folder."""
        for folder in folders:
            if not folder.is_dir():
                raise NotADirectoryError(f"{folder} is no folder")
        return cls(tuple(Root(folder.absolute(), folder.resolve()) for folder in folders))

    def find(self, path: str) -> Rooted:
        """Where a path leads: absolute, or from the first root in which there is something of this name.

        Raises `PathRefusedError` where it leads out of the roots, whether or not there is anything: who asks
        learns nothing of what is elsewhere. Of a path that does not begin in a root the system is not asked.
        """
        if ".." not in Path(path).parts:
            with suppress(OSError, ValueError, RuntimeError):
                found = [
                    rooted for root in self.folders if (rooted := self._followed(path, root)) is not None
                ]
                if found:
                    return next((rooted for rooted in found if os.path.lexists(rooted.path)), found[0])
        raise PathRefusedError(path, f"leads to no file under an allowed root, without '..'; {self.said}")

    @property
    def said(self) -> str:
        """The roots in words."""
        if not self.folders:
            return "no root is allowed"
        return f"allowed are files under {', '.join(str(root.named) for root in self.folders)}"

    def _followed(self, path: str, root: Root) -> Rooted | None:
        """Where a path in a root leads once its links are followed; None where that is in none of them."""
        way = root.within(Path(path))
        if way is None:
            return None
        found = Path(os.path.realpath(root.resolved / way))
        for other in self.folders:
            if found != other.resolved and found.is_relative_to(other.resolved):
                return Rooted(path, other.resolved, found.relative_to(other.resolved).parts)
        return None


def _step(folder: int, name: str, flags: int) -> int:
    """Open what has this name in a folder, which is closed."""
    try:
        return os.open(name, flags, dir_fd=folder)
    finally:
        os.close(folder)


def _sort(mode: int) -> str:
    sorts = ((stat.S_ISDIR, "a folder"), (stat.S_ISFIFO, "a pipe"), (stat.S_ISSOCK, "a socket"))
    return next((name for has, name in sorts if has(mode)), "a device")
