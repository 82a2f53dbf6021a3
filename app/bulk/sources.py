"""What a run is about, as a stream of references: files, folders, globs, lists, URLs, scans, Parquet files.

Ids are unique by construction: that of a file is its path as given; what an earlier folder or glob holds is
left out of the later ones; and single files are compared with each other in bounded memory.
"""

import os
from collections import Counter
from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import lru_cache
from hashlib import sha256
from itertools import accumulate, chain
from pathlib import Path
from tempfile import TemporaryDirectory

import orjson

from primfit.fitting.errors import InvalidPointCloudError

from ..readers import Cloud, Pick, UnreadableFileError, read
from ..readers.columns import as_columns
from ..readers.formats import PACKED, SUFFIXES
from ..readers.las import las_pieces
from ..readers.ply import ply_pieces
from . import grouping, parquet, places
from .parts import FOLDER
from .refs import Ref, file_id, segment_id
from .repeated import repeated

_LIST = "@"
_WILD, _WILD_URL = "*?[", "*["
_PREDICTION = "_prediction.txt"
_BUCKET = 1_000_000
"""Points of a bucket, about: a bucket is put in order in memory that does not depend on it."""


class GivenTwiceError(ValueError):
    """A file is named twice; the message says which."""


def references(
    inputs: Sequence[str],
    labels: str | None,
    columns: object,
    scratch: str,
    others: Counter[str] | None = None,
) -> Iterator[Ref]:
    """The segments that inputs hold, in an order that depends on nothing but the inputs.

    Parameters
    ----------
    inputs : files, folders, globs (`**` for folders of any depth) and URLs of these; `@list.txt` for a list
        with one of them a line
    labels : the column of labels, or `AUTO_LABELS`; None where each file is one cloud
    columns : the option of `engine.fit`
    scratch : a folder, or its URL, that every worker sees: for scans that are grouped by their labels
    others : counts files that lie in folders and are left out, by suffix

    Raises
    ------
    GivenTwiceError
        A file is named twice.
    OSError
        A folder or a list cannot be read; `scratch` is full.
    """
    wide = [_Wide.of(name) for name in _names(inputs) if _is_wide(name)]
    _check_single(inputs)
    counted: Counter[str] = Counter() if others is None else others
    for file, n_bytes in _files(inputs, wide, counted):
        yield from _segments(file, n_bytes, labels, columns, _absolute(scratch))


def stands_on(inputs: Sequence[str]) -> str | None:
    """The folder that relative names of inputs are of; None where none is. Raises `OSError`."""
    names = chain((name.removeprefix(_LIST) for name in inputs), _names(inputs))
    return None if all(places.is_remote(name) or os.path.isabs(name) for name in names) else os.getcwd()


def _names(inputs: Sequence[str]) -> Iterator[str]:
    """The inputs, and in the place of each list its lines."""
    for name in inputs:
        if not name.startswith(_LIST):
            yield name
            continue
        with places.opened(name[len(_LIST) :]) as lines:
            for line in lines:
                if text := line.decode("utf-8-sig").strip():
                    yield text


def _is_wide(name: str) -> bool:
    """Whether a name stands for more than one file: a folder or a glob."""
    if places.is_remote(name):
        return name.endswith("/") or _has_wild(name) or not _names_file(name)
    return os.path.isdir(name) or (_has_wild(name) and not os.path.exists(name))


def _has_wild(name: str) -> bool:
    """Whether a name is a pattern; in a URL a question mark begins a query."""
    return any(sign in name for sign in (_WILD_URL if places.is_remote(name) else _WILD))


def _names_file(url: str) -> bool:
    """Whether a URL, by its looks, is that of a file, and not of a folder or bucket."""
    protocol, _, way = url.partition("://")
    return protocol.lower() in ("http", "https") or ("/" in way and "." in way.rpartition("/")[2])


def _is_cloud(name: str) -> bool:
    """Whether a file that was found in a folder is taken for a cloud, by its name."""
    if name.endswith(_PREDICTION):
        return False
    bare, suffix = os.path.splitext(name)
    if suffix.lower() in PACKED:
        suffix = os.path.splitext(bare)[1]
    return suffix.lower() in SUFFIXES or parquet.is_parquet(name)


@dataclass(frozen=True)
class _Wide:
    """A folder, and which of the files in it are meant: all clouds, or those of a pattern of names."""

    folder: str
    pattern: tuple[str, ...] | None

    @classmethod
    def of(cls, name: str) -> "_Wide":
        head, parts = _split(name)
        wild = next((i for i, part in enumerate(parts) if _has_wild(part)), len(parts))
        if wild == len(parts) or (not places.is_remote(name) and os.path.isdir(name)):
            return cls(_joined(head, parts), None)
        return cls(_joined(head, parts[:wild]), tuple(parts[wild:]))

    def covers(self, file: str) -> bool:
        """Whether this file would be found here."""
        folder, name = _absolute(self.folder).rstrip("/") + "/", _absolute(file)
        if not name.startswith(folder):
            return False
        way = name[len(folder) :].split("/")
        return self.takes(way) and not (self._any_depth and _through_link(folder, tuple(way[:-1])))

    def takes(self, parts: Sequence[str]) -> bool:
        """Whether a file of this way from the folder on is meant."""
        return _is_cloud(parts[-1]) if self.pattern is None else _matches(parts, self.pattern)

    def files(self, others: Counter[str]) -> Iterator[tuple[str, int | None]]:
        """The files that are meant, and their bytes; those of a folder by their names, and so on inwards."""
        yield from self._within(self.folder, (), others)

    @property
    def _any_depth(self) -> bool:
        """Whether folders are searched however deep they are; links are not followed there."""
        return self.pattern is None or "**" in self.pattern

    def _within(
        self, folder: str, way: tuple[str, ...], others: Counter[str]
    ) -> Iterator[tuple[str, int | None]]:
        entries = list(places.names(folder or ".", links=not self._any_depth))
        if any(entry.name == FOLDER for entry in entries):
            return  # the answers of a run
        for name, is_folder, n_bytes in entries:
            inner, place = (*way, name), places.joined(folder, name)
            if is_folder:
                if self._reaches(len(inner)):
                    yield from self._within(place, inner, others)
            elif self.takes(inner):
                yield place, n_bytes
            elif self.pattern is None and not name.endswith(_PREDICTION):
                others[os.path.splitext(name)[1].lower() or "without suffix"] += 1

    def _reaches(self, depth: int) -> bool:
        """Whether something may be meant so many folders below."""
        return self._any_depth or (self.pattern is not None and depth < len(self.pattern))


@lru_cache(maxsize=1024)
def _through_link(folder: str, way: tuple[str, ...]) -> bool:
    """Whether one of the folders on the way inwards is a link."""
    if places.is_remote(folder):
        return False
    inner = accumulate(way, places.joined, initial=folder)
    return any(os.path.islink(each) for each in list(inner)[1:])


def _matches(parts: Sequence[str], pattern: Sequence[str]) -> bool:
    """Whether names match a pattern, in which `**` stands for any number of them; as in a shell, only a dot
    matches a dot at the beginning."""
    if not pattern:
        return not parts
    if pattern[0] == "**":
        return any(_matches(parts[i:], pattern[1:]) for i in range(len(parts) + 1))
    if not parts or (parts[0].startswith(".") and not pattern[0].startswith(".")):
        return False
    return fnmatchcase(parts[0], pattern[0]) and _matches(parts[1:], pattern[1:])


def _split(name: str) -> tuple[str, list[str]]:
    """What a name starts with, `s3://`, `/` or nothing, and its parts."""
    if places.is_remote(name):
        protocol, _, way = name.partition("://")
        return f"{protocol}://", [part for part in way.split("/") if part]
    way = os.path.normpath(name).replace(os.sep, "/")
    return ("/" if way.startswith("/") else ""), [part for part in way.split("/") if part not in ("", ".")]


def _joined(head: str, parts: Sequence[str]) -> str:
    return head + "/".join(parts)


def _absolute(name: str) -> str:
    """A name by which the same file is known, whatever folder it is looked at from."""
    return name if places.is_remote(name) else os.path.abspath(name).replace(os.sep, "/")


def _clean(name: str) -> str:
    """A file as it is named in ids: without `./` and doubled slashes."""
    return name if places.is_remote(name) else os.path.normpath(name).replace(os.sep, "/")


def _files(
    inputs: Sequence[str], wide: Sequence[_Wide], others: Counter[str]
) -> Iterator[tuple[str, int | None]]:
    """The files, each once, and their bytes where somebody tells."""
    n_wide = 0
    for name in _names(inputs):
        if _is_wide(name):
            before, n_wide = wide[:n_wide], n_wide + 1
            for file, n_bytes in wide[n_wide - 1].files(others):
                if not any(each.covers(file) for each in before):
                    yield file, n_bytes
        elif not any(each.covers(name) for each in wide):
            yield _clean(name), _bytes_of(name)


def _bytes_of(name: str) -> int | None:
    """The bytes of a file; it is not worth a request to a server to know them."""
    try:
        return None if places.is_remote(name) else os.stat(name).st_size
    except OSError:
        return None  # who reads it says why


def _check_single(inputs: Sequence[str]) -> None:
    """Raise where a file is named twice, by whatever path."""
    twice = repeated(lambda: (_absolute(name) for name in _names(inputs) if not _is_wide(name)))
    if twice is not None:
        raise GivenTwiceError(f"{twice} is given twice")


def _segments(
    file: str, n_bytes: int | None, labels: str | None, columns: object, scratch: str
) -> Iterator[Ref]:
    """The segments of a file, or the file as one; what is wrong with it is said by its one reference."""
    whole = Ref(file_id(file), file, None, places.about_points(n_bytes), _store_of(file))
    if n_bytes is None and not places.is_remote(file):
        yield _missing(whole)
        return
    try:
        if parquet.is_parquet(file):
            found = _parquet(file, labels, columns, scratch)
        elif labels is None:
            found = None
        else:
            found = _grouped(file, labels, columns, scratch)
        yield from [whole] if found is None else found
    except UnreadableFileError as error:
        yield _with_problem(whole, error.field, error.message, error.no_cloud)
    except InvalidPointCloudError as error:
        yield _with_problem(whole, "labels", str(error), False)


def _missing(whole: Ref) -> Ref:
    """A file whose size nobody knows, with the reason."""
    try:
        os.stat(whole.file)
    except OSError as error:
        return _with_problem(whole, "file", error.strerror or str(error), False)
    return whole


def _with_problem(whole: Ref, field: str, message: str, no_cloud: bool) -> Ref:
    return Ref(whole.id, whole.file, None, 0, whole.store, problem=(field, message, no_cloud))


def _store_of(file: str) -> str | None:
    """Where any machine finds a file; None where that is its name."""
    absolute = _absolute(file)
    return None if absolute == file else absolute


def _parquet(file: str, labels: str | None, columns: object, scratch: str) -> Iterable[Ref] | None:
    place = _absolute(file)
    found = parquet.references(file, place, columns)
    if found is not None:
        return found
    if labels is not None and (segments := _grouped(file, labels, columns, scratch)) is not None:
        return segments
    n_rows = parquet.n_rows(place)
    return [Ref(file_id(file), file, None, n_rows, place, 0, n_rows)]


def _grouped(file: str, labels: str, columns: object, scratch: str) -> Iterator[Ref] | None:
    """The segments of a file with labels, grouped in a store; None where it has none."""
    pick = Pick(labels, as_columns(columns))
    try:
        store = grouping.store_in(scratch, _name_of(file, pick))
        if not grouping.is_whole(store):
            with TemporaryDirectory(prefix="primfit-") as folder:
                if not _group(file, pick, store, Path(folder)):
                    return None
    except (FileNotFoundError, PermissionError) as error:
        if error.filename not in (file, _absolute(file)):
            raise
        raise UnreadableFileError("file", error.strerror or str(error)) from None
    return (
        Ref(segment_id(file, label), file, label, stop - start, store, start, stop)
        for label, start, stop in grouping.segments(store)
    )


def _name_of(file: str, pick: Pick) -> str:
    """A name for the store of a file: another one where the file or what is asked of it has changed."""
    if places.is_remote(file):
        told: list[int | None] = [places.size(file)]
    else:
        state = os.stat(file)
        told = [state.st_size, state.st_mtime_ns]
    known = orjson.dumps([_absolute(file), told, pick.labels, pick.columns])
    return sha256(known).hexdigest()[:20]


def _group(file: str, pick: Pick, store: str, folder: Path) -> bool:
    """Group a file; False where it has no labels, or no points that could carry them."""
    place = _absolute(file)
    if places.is_remote(file) and not parquet.is_parquet(file):
        place = str(folder / "scan")
        places.fetch(file, Path(place))
    pieces = _pieces(place, pick)
    with closing(pieces):
        first = next(pieces, None)
        if first is None or first.labels is None or not len(first.labels):
            return False
        target = Path(store) if not places.is_remote(store) else folder / Path(store).name
        target.parent.mkdir(parents=True, exist_ok=True)
        n_points = os.stat(place).st_size // 8 if not places.is_remote(place) else 10 * _BUCKET
        grouping.group(chain([first], pieces), target, 1 + n_points // _BUCKET)
    if places.is_remote(store):
        for ours, theirs in zip(grouping.parts(str(target)), grouping.parts(store), strict=True):
            places.put(Path(ours), theirs)
    return True


def _pieces(place: str, pick: Pick) -> Generator[Cloud]:
    """The cloud in a file: in pieces where its format lets them be read, else as one."""
    if parquet.is_parquet(place):
        yield from parquet.point_pieces(place, pick)
        return
    with open(place, "rb") as file:
        start = file.read(4)
        pieces: Iterator[Cloud] | None = None
        if start == b"LASF":
            pieces = las_pieces(file, pick, grouping.PIECE)
        elif start[:3].lower() == b"ply":
            pieces = ply_pieces(file, pick, grouping.PIECE)
        if pieces is not None:
            yield from pieces
            return
        file.seek(0)
        yield read(file.read(), pick=pick)
