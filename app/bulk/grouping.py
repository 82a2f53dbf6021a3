"""The points of a scan of any size, grouped by their labels on disk: what is held in memory is bounded.

One pass over the scan appends each point to one of several buckets, by its label. The labels of each bucket
are counted, which gives every segment its place in the store; then each bucket is gone through once more, and
its points are written to their places. The points of a segment keep their order, so that each is what
`engine.cut.cut` gives for the whole scan, byte for byte.

A store is three files: NAME.segments holds float64 rows, segment by segment in the order of their labels;
NAME.segments.index a line of JSON for each, `[label, start, stop]`; NAME.segments.json the rest of the cloud.
Nothing is mapped into memory, since mapped pages count as used.
"""

import heapq
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO
from zlib import crc32

import numpy as np
import orjson
from numpy.typing import NDArray

from primfit.fitting.errors import InvalidPointCloudError

from ..engine.cut import Label, whole_labels
from ..readers import Cloud
from ..readers.cloud import Array
from . import places

PIECE = 500_000
"""Points that are held at a time."""

_MOST_BUCKETS = 64
"""Two files of each are open at once, and a process may open 256 on some systems."""

_SUFFIX = ".segments"
_SPREAD = np.uint64(0x9E3779B97F4A7C15)  # 2^64 over the golden ratio: near labels fall into far buckets

Labels = NDArray[np.int64]


def is_store(place: str) -> bool:
    """Whether this is the place of a store."""
    return place.endswith(_SUFFIX)


def store_in(folder: str, name: str) -> str:
    """The place of a store of this name."""
    return places.joined(folder, name + _SUFFIX)


def is_whole(store: str) -> bool:
    """Whether all of the store was written."""
    return places.exists(_head_of(store))


def segment(store: str, start: int, stop: int) -> Cloud:
    """The cloud of these rows of a store."""
    head = _head(store)
    width = head["width"]
    data = places.read_range(store, 8 * width * start, 8 * width * (stop - start))
    rows = np.frombuffer(data, "<f8").reshape(-1, width)
    normals = rows[:, 3:].copy() if head["normals"] else None
    told = {name: head[name] for name in ("format", "label_column", "unit", "unit_from")}
    columns, warnings = tuple(head["columns"]), tuple(head["warnings"])
    return Cloud(rows[:, :3].copy(), columns, normals=normals, warnings=warnings, **told)


def segments(store: str) -> Iterator[tuple[Label, int, int]]:
    """Each label with the rows of its points in the store, by label, ascending."""
    with places.opened(_index_of(store)) as lines:
        for line in lines:
            yield tuple(orjson.loads(line))


def parts(store: str) -> list[str]:
    """The places of all that belongs to a store, the one last that says that it is whole."""
    return [store, _index_of(store), _head_of(store)]


def _index_of(store: str) -> str:
    return store + ".index"


def _head_of(store: str) -> str:
    return store + ".json"


@lru_cache(maxsize=64)
def _head(store: str) -> dict[str, Any]:
    head: dict[str, Any] = orjson.loads(places.read_bytes(_head_of(store)))
    return head


def group(pieces: Iterable[Cloud], store: Path, n_buckets: int) -> None:
    """Group the points of a scan, which comes in pieces that all have labels.

    Parameters
    ----------
    store : where the rows go; its folder is there, and has as much free space as the points take, twice
    n_buckets : each holds its share of the points; any number of them gives the same store

    Raises
    ------
    InvalidPointCloudError
        Labels are neither whole numbers nor strings.
    OSError
        The disk is full, or cannot be read.
    """
    folder = store.with_name(store.name + ".buckets")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    try:
        buckets = [_Bucket(folder / str(i)) for i in range(max(1, min(n_buckets, _MOST_BUCKETS)))]
        head = _spread(pieces, buckets)
        for bucket in buckets:
            bucket.count()
        head["n_segments"] = _write_index(buckets, Path(_index_of(str(store))))
        with store.open("wb") as file:
            for bucket in buckets:
                bucket.scatter(file, head["width"])
        places.write_whole(_head_of(str(store)), orjson.dumps(head))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _spread(pieces: Iterable[Cloud], buckets: "list[_Bucket]") -> dict[str, Any]:
    """Append the points to the buckets of their labels; what else is known of the cloud."""
    first: Cloud | None = None
    width, trusted, n_points = 3, True, 0
    for cloud in pieces:
        if first is None:
            first, width = cloud, 3 if cloud.normals is None else 6
        trusted = trusted and cloud.normals is not None
        n_points += len(cloud.points)
        _append(cloud, width, buckets)
    assert first is not None
    columns = first.columns if trusted else first.columns[:3]
    told = {name: getattr(first, name) for name in ("format", "label_column", "unit", "unit_from")}
    counted = {"n_points": n_points, "width": width, "normals": trusted}
    return {**told, **counted, "columns": list(columns), "warnings": list(first.warnings)}


def _append(cloud: Cloud, width: int, buckets: "list[_Bucket]") -> None:
    assert cloud.labels is not None
    labels = whole_labels(cloud.labels)
    if len(labels) != len(cloud.points):
        raise InvalidPointCloudError(f"{len(labels)} labels for {len(cloud.points)} points", "labels")
    rows = cloud.points if width == 3 else np.column_stack([cloud.points, _normals(cloud)])
    if labels.dtype.kind in "iu":
        numbers = labels.astype(np.int64)
        which, codes = _buckets_of(numbers, len(buckets)), numbers
    else:
        which, codes = _coded(labels, buckets)
    order = np.argsort(which.astype(np.uint16), kind="stable")
    bounds = np.searchsorted(which[order], np.arange(len(buckets) + 1)).tolist()
    for bucket, start, stop in zip(buckets, bounds, bounds[1:], strict=False):
        chosen = order[start:stop]
        if len(chosen):
            bucket.append(codes[chosen], rows[chosen])


def _normals(cloud: Cloud) -> Array:
    return np.zeros_like(cloud.points) if cloud.normals is None else cloud.normals


def _buckets_of(labels: Labels, n_buckets: int) -> NDArray[Any]:
    with np.errstate(over="ignore"):
        return (labels.view(np.uint64) * _SPREAD >> np.uint64(32)) % np.uint64(n_buckets)


def _coded(labels: NDArray[Any], buckets: "list[_Bucket]") -> tuple[NDArray[Any], Labels]:
    """The buckets of strings (N,), and the numbers by which these know them."""
    names: list[list[str]] = [[] for _ in buckets]
    for name in sorted(set(labels.tolist())):
        names[crc32(name.encode()) % len(buckets)].append(name)
    found: dict[str, tuple[int, int]] = {}
    for i, (bucket, known) in enumerate(zip(buckets, names, strict=True)):
        found.update((name, (i, code)) for name, code in zip(known, bucket.codes_of(known), strict=True))
    both = np.array([found[name] for name in labels.tolist()], np.int64).reshape(-1, 2)
    return both[:, 0], both[:, 1]


@dataclass
class _Bucket:
    """The points of some labels on disk, in the order of the scan.

    Files are opened for each piece anew, so that any number of buckets needs no more than one at a time.
    """

    path: Path
    n_names: int = 0

    def codes_of(self, names: list[str]) -> range:
        """Numbers for labels that are strings; the same string may have several."""
        with self._file("names", "ab") as file:
            file.writelines(orjson.dumps(name) + b"\n" for name in names)
        self.n_names += len(names)
        return range(self.n_names - len(names), self.n_names)

    def append(self, codes: Labels, rows: Array) -> None:
        """More points: their labels, or numbers for these, and what there is of each."""
        with self._file("labels", "ab") as file:
            file.write(np.ascontiguousarray(codes, "<i8").data)
        with self._file("rows", "ab") as file:
            file.write(np.ascontiguousarray(rows, "<f8").data)

    def count(self) -> None:
        """Write a line with each label, ascending, and its number of points."""
        ranks, names = self._ranked()
        counts = np.zeros(len(names), np.int64)
        for codes in self._codes():
            counts += np.bincount(ranks(codes), minlength=len(names))
        with self._file("counts", "wb") as file:
            file.writelines(
                orjson.dumps([name, count]) + b"\n"
                for name, count in zip(names, counts.tolist(), strict=True)
            )

    def counted(self, number: int) -> Iterator[tuple[Label, int, int]]:
        """What `count` wrote, with the number of the bucket in between."""
        with self._file("counts", "rb") as file:
            for line in file:
                label, count = orjson.loads(line)
                yield label, number, count

    def starts(self) -> BinaryIO:
        """Where the places of its labels in the store are written to, in the order of the labels."""
        return self._file("starts", "wb")

    def scatter(self, store: BinaryIO, width: int) -> None:
        """Write each point to its place."""
        if not self._has("rows"):
            return
        ranks, _ = self._ranked()
        with self._file("starts", "rb") as file:
            places = np.fromfile(file, "<i8")
        with self._file("rows", "rb") as file:
            for codes in self._codes():
                rows = np.fromfile(file, "<f8", len(codes) * width).reshape(-1, width)
                which = ranks(codes)
                order = np.argsort(which, kind="stable")
                found, counts = np.unique(which, return_counts=True)
                rows, begin = rows[order], 0
                for place, count in zip(places[found].tolist(), counts.tolist(), strict=True):
                    store.seek(8 * width * place)
                    store.write(rows[begin : begin + count].data)
                    begin += count
                places[found] += counts

    def _codes(self) -> Iterator[Labels]:
        if self._has("labels"):
            with self._file("labels", "rb") as file:
                while len(codes := np.fromfile(file, "<i8", PIECE)):
                    yield codes

    def _ranked(self) -> tuple[Callable[[Labels], NDArray[np.intp]], list[Label]]:
        """The labels, ascending, and what tells the places of codes (N,) among them."""
        if not self.n_names:
            labels = np.empty(0, np.int64)
            for codes in self._codes():
                labels = np.union1d(labels, codes)
            return (lambda codes: np.searchsorted(labels, codes).astype(np.intp)), list(labels.tolist())
        with self._file("names", "rb") as file:
            told = [orjson.loads(line) for line in file]
        names = sorted(set(told))
        rank = {name: i for i, name in enumerate(names)}
        table = np.array([rank[name] for name in told], np.intp)
        return table.__getitem__, names

    def _has(self, what: str) -> bool:
        return self.path.with_suffix(f".{what}").exists()

    def _file(self, what: str, mode: str) -> Any:
        return self.path.with_suffix(f".{what}").open(mode)


def _write_index(buckets: list[_Bucket], index: Path) -> int:
    """Give each segment its place, in the order of all labels; how many there are."""
    start = n_segments = 0
    with ExitStack() as stack:
        file = stack.enter_context(index.open("wb"))
        starts = [stack.enter_context(bucket.starts()) for bucket in buckets]
        for label, i, count in heapq.merge(*(bucket.counted(i) for i, bucket in enumerate(buckets))):
            file.write(orjson.dumps([label, start, start + count]) + b"\n")
            starts[i].write(start.to_bytes(8, "little"))
            start += count
            n_segments += 1
    return n_segments
