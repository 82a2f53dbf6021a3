"""Files on this machine and objects behind a URL, by a few functions: `s3://`, `gs://`, `https://`, others.

What is remote is reached by fsspec, which the extra `remote` brings. A server that throttles, answers 503 or
loses the connection is asked again for about a minute, on top of what its client does by itself.
"""

import errno
import io
import os
import random
import re
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

NEEDED = "addresses such as s3://bucket/folder need an extra: pip install 'primfit[remote]'"

PAUSES = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0)
"""Seconds before each further attempt, halved at random so that many workers do not ask at once."""

_PIECE = 2**26
"""Bytes of a large object that are asked for at once."""

_AHEAD = 2**20
"""Bytes that are read at once of an object that is read piece by piece."""

_POINT, _UNKNOWN = 40, 1000
"""Bytes of a point in a file, roughly; points of a file of which nobody tells the size."""

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://")
_FINAL = (FileNotFoundError, PermissionError, IsADirectoryError, NotADirectoryError, FileExistsError)
_FINAL_NUMBERS = (errno.EPERM, errno.ENOSYS)
# What is raised for lost connections beside OSError, by packages that may not be there.
_LOST = {
    "aiohttp.ClientError",
    "botocore.HTTPClientError",
    "botocore.ResponseParserError",
    "gcsfs.HttpError",
    "http.HTTPException",
    "requests.RequestException",
    "urllib3.HTTPError",
}
_AGAIN, _REFUSED = (408, 429), (401, 403)

T = TypeVar("T")


class Entry(NamedTuple):
    """What a folder holds under a name: a folder, or a file of `size` bytes; None where nobody tells."""

    name: str
    is_folder: bool
    size: int | None


def is_remote(place: str) -> bool:
    """Whether a place is a URL."""
    return _URL.match(place) is not None


def read_bytes(place: str) -> bytes:
    """All of a file; `OSError` with the place in it."""
    if not is_remote(place):
        return Path(place).read_bytes()
    return _patiently(place, lambda files, path: bytes(files.cat_file(path)))


def read_range(place: str, start: int, n_bytes: int) -> bytes:
    """So many bytes of a file from there on; `OSError` where it does not have them."""
    if is_remote(place):
        return _patiently(place, lambda files, path: _ranged(files, path, start, n_bytes))
    with open(place, "rb") as file:
        file.seek(start)
        data = file.read(n_bytes)
    if len(data) < n_bytes:
        raise OSError(errno.EIO, f"it ends within the {n_bytes} bytes from {start} on", place)
    return data


def _ranged(files: Any, path: str, start: int, n_bytes: int) -> bytes:
    data = bytes(files.cat_file(path, start=start, end=start + n_bytes)) if n_bytes else b""
    if len(data) != n_bytes:
        raise OSError(errno.EIO, f"{n_bytes} bytes from {start} on were asked for, {len(data)} came")
    return data


def write_whole(place: str, data: bytes | memoryview) -> None:
    """Write all of a file or nothing, so that an interrupted run leaves no half of it.

    Here it is renamed from a random name: one made from its own may be the name of an input.
    """
    if is_remote(place):
        _patiently(place, lambda files, path: files.pipe_file(path, bytes(data)))
        return
    target = Path(place)
    target.parent.mkdir(parents=True, exist_ok=True)
    part = target.with_name(f".{os.urandom(8).hex()}.part")
    try:
        with part.open("xb") as stream:
            stream.write(data)
        os.replace(part, target)
    except OSError as error:
        raise OSError(error.errno, error.strerror, place) from None
    finally:
        with suppress(OSError):  # it is there after a failure only
            part.unlink()


def exists(place: str) -> bool:
    """Whether there is such a file or folder."""
    return _info(place) is not None


def is_folder(place: str) -> bool:
    """Whether there is such a folder."""
    info = _info(place)
    return info is not None and info.is_folder


def size(place: str) -> int | None:
    """The bytes of a file, where somebody tells; `FileNotFoundError` where there is none."""
    info = _info(place)
    if info is None:
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), place)
    return info.size


def _info(place: str) -> Entry | None:
    name = place.rstrip("/").rpartition("/")[2]
    try:
        if is_remote(place):
            found = _patiently(place, lambda files, path: files.info(path))
            return Entry(name, found["type"] == "directory", found.get("size"))
        return Entry(name, os.path.isdir(place), os.stat(place).st_size)
    except (FileNotFoundError, NotADirectoryError):
        return None


def names(folder: str, links: bool = False) -> Iterator[Entry]:
    """What a folder holds, by name; a link to a folder is one where `links` says so, else nothing: a search
    of any depth would go round in circles."""
    entries = _listed(folder) if is_remote(folder) else _scanned(folder, links)
    yield from sorted(entries, key=lambda entry: entry[:2])


def _scanned(folder: str, links: bool) -> Iterator[Entry]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=links):
                yield Entry(entry.name, True, None)
            elif entry.is_file():
                yield Entry(entry.name, False, entry.stat().st_size)


def _listed(folder: str) -> Iterator[Entry]:
    place = folder.rstrip("/") + "/"
    for found in _patiently(place, lambda files, path: files.ls(path, detail=True)):
        name = found["name"].rstrip("/").rpartition("/")[2]
        # An object may stand for the folder itself.
        if name and found["name"].rstrip("/") not in (place.rstrip("/"), _path_in(place).rstrip("/")):
            yield Entry(name, found["type"] == "directory", found.get("size"))


def joined(folder: str, name: str) -> str:
    """The place of what lies in a folder."""
    return name if folder in ("", ".") else f"{folder.rstrip('/')}/{name}"


def about_points(n_bytes: int | None) -> int:
    """How many points a file of so many bytes holds, roughly."""
    return _UNKNOWN if n_bytes is None else n_bytes // _POINT


def fetch(place: str, target: Path) -> None:
    """Copy a file from a URL to this machine by pieces, each of which is asked for again where it is lost."""
    n_bytes = size(place)
    with target.open("wb") as file:
        if n_bytes is None:
            file.write(read_bytes(place))
            return
        for start in range(0, n_bytes, _PIECE):
            file.write(read_range(place, start, min(_PIECE, n_bytes - start)))


def put(source: Path, place: str) -> None:
    """Copy a file from this machine to a URL."""
    _patiently(place, lambda files, path: files.put_file(str(source), path))


def opened(place: str) -> io.BufferedReader:
    """A file for a library that reads it piece by piece from where it likes."""
    return io.BufferedReader(_Remote(place), _AHEAD) if is_remote(place) else open(place, "rb")


def _patiently(place: str, action: Callable[[Any, str], T]) -> T:
    """What comes of an action on a file system and a path in it, tried again after faults that may pass."""
    for pause in (*PAUSES, None):
        try:
            return action(_files(_protocol(place)), _path_in(place))
        except ImportError:
            raise
        except Exception as error:
            if pause is None or not _may_pass(error):
                raise _told(error, place, 1 + len(PAUSES) if pause is None else 1) from error
            time.sleep(pause * (0.5 + 0.5 * random.random()))
    raise AssertionError


def _protocol(place: str) -> str:
    return place.partition("://")[0].lower()


@cache
def _files(protocol: str) -> Any:
    try:
        import fsspec
    except ImportError as error:
        raise ImportError(NEEDED) from error
    try:
        return fsspec.filesystem(protocol, use_listings_cache=False)
    except ImportError as error:
        raise ImportError(f"{protocol}://: {error}") from error


def _path_in(place: str) -> str:
    """The path by which the file system knows a place."""
    return str(_files(_protocol(place))._strip_protocol(place))


def _may_pass(error: BaseException) -> bool:
    """Whether the same may succeed a little later."""
    if isinstance(error, FileNotFoundError) and error.__cause__ is not None:
        return _may_pass(error.__cause__)  # so fsspec says that a server gave no answer
    status = _status_of(error)
    if 400 <= status < 500:
        return status in _AGAIN
    if isinstance(error, OSError):
        return not isinstance(error, _FINAL) and error.errno not in _FINAL_NUMBERS
    kinds = type(error).__mro__
    return not _LOST.isdisjoint(f"{kind.__module__.partition('.')[0]}.{kind.__name__}" for kind in kinds)


def _status_of(error: BaseException) -> int:
    """The status of an answer by HTTP; 0 where there was none."""
    # aiohttp tells it by the first name, gcsfs by the second, which is deprecated in aiohttp.
    status = error.status if hasattr(error, "status") else getattr(error, "code", None)
    return status if isinstance(status, int) else 0


def _told(error: Exception, place: str, n_attempts: int) -> OSError:
    """The error with its place in it."""
    if isinstance(error, FileNotFoundError) and n_attempts == 1:
        return FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), place)
    refused = isinstance(error, PermissionError) or _status_of(error) in _REFUSED
    number = errno.EACCES if refused else getattr(error, "errno", None)
    why = getattr(error, "strerror", None) or str(error) or type(error).__name__
    many = f" (asked {n_attempts} times)" if n_attempts > 1 else ""
    return OSError(errno.EIO if number in (None, errno.ENOENT) else number, f"{why}{many}", place)


class _Remote(io.RawIOBase):
    """An object behind a URL as a file that is open to be read."""

    def __init__(self, place: str) -> None:
        n_bytes = size(place)
        self._place, self._at = place, 0
        self._whole = read_bytes(place) if n_bytes is None else None
        self._n_bytes = len(self._whole) if self._whole is not None else n_bytes or 0

    def readinto(self, buffer: Any) -> int:
        """Fill the buffer as far as there is something left."""
        wanted = min(len(buffer), max(0, self._n_bytes - self._at))
        if not wanted:
            return 0
        if self._whole is None:
            buffer[:wanted] = read_range(self._place, self._at, wanted)
        else:
            buffer[:wanted] = self._whole[self._at : self._at + wanted]
        self._at += wanted
        return wanted

    def seek(self, place: int, whence: int = os.SEEK_SET) -> int:
        """Go to a byte, from the start, from here, or from the end."""
        self._at = place + {os.SEEK_SET: 0, os.SEEK_CUR: self._at, os.SEEK_END: self._n_bytes}[whence]
        return self._at

    def tell(self) -> int:
        """The byte that is read next."""
        return self._at

    def readable(self) -> bool:
        """It may be read."""
        return True

    def seekable(self) -> bool:
        """It may be read from anywhere."""
        return True
