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
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import prod
from pathlib import Path
from typing import Any, BinaryIO
from zlib import crc32

import numpy as np
import orjson
from numpy.typing import NDArray

from ..engine.cut import Label, in_order, labels_of
from ..readers import Cloud
from ..readers.cloud import Array, per_point
from . import places

PIECE = 500_000
"""Points that are held at a time."""

_MOST_BUCKETS = 64
"""Two files of each are open at once, and a process may open 256 on some systems."""

_SUFFIX = ".segments"
_TOLD = ("format", "options", "label_column", "unit", "unit_from")
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
    rows, begin, arrays = np.frombuffer(data, "<f8").reshape(-1, width), 0, {}
    for name, shape in head["shapes"].items():
        end = begin + prod(shape)
        arrays[name] = rows[:, begin:end].reshape(-1, *shape).astype(np.float64)
        begin = end
    if not head["trusted"]:
        del arrays["normals"]
    told = {name: head[name] for name in _TOLD}
    columns, warnings = tuple(head["columns"]), tuple(head["warnings"])
    return Cloud(**{"normals": None, **arrays, **told}, columns=columns, warnings=warnings)


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
    shapes: dict[str, tuple[int, ...]] = {}
    n_points, n_normals = 0, 0
    for cloud in pieces:
        if first is None:
            first, shapes = cloud, {name: values.shape[1:] for name, values in per_point(cloud).items()}
        n_points += len(cloud.points)
        n_normals += 0 if cloud.normals is None else len(cloud.points)
        _append(cloud, shapes, buckets)
    assert first is not None
    # A piece without normals has one without a direction: then none is trusted.
    trusted = "normals" not in shapes or n_normals == n_points
    columns = first.columns if trusted else first.columns[:3]
    told = {name: getattr(first, name) for name in _TOLD}
    counted = {"n_points": n_points, "width": sum(map(prod, shapes.values())), "shapes": shapes}
    return {**told, **counted, "trusted": trusted, "columns": columns, "warnings": first.warnings}


def _append(cloud: Cloud, shapes: Mapping[str, tuple[int, ...]], buckets: "list[_Bucket]") -> None:
    labels, arrays, n_points = labels_of(cloud), per_point(cloud), len(cloud.points)
    values = [arrays.get(name, np.zeros((n_points, *shape))) for name, shape in shapes.items()]
    rows = values[0] if len(values) == 1 else np.column_stack([v.reshape(n_points, -1) for v in values])
    if labels.dtype.kind in "iu":
        codes = labels.astype(np.int64)
        which = _buckets_of(codes, len(buckets))
    else:
        which, codes = _coded(labels, buckets)
    order = np.argsort(which.astype(np.uint16), kind="stable")
    bounds = np.searchsorted(which[order], np.arange(len(buckets) + 1)).tolist()
    for bucket, (start, stop) in zip(buckets, pairwise(bounds), strict=True):
        if stop > start:
            bucket.append(codes[order[start:stop]], rows[order[start:stop]])


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
        names, counts = self._names(), Counter[Label]()
        for codes in self._codes():
            found, _, starts = in_order(codes)
            for code, (start, stop) in zip(found, pairwise([*starts.tolist(), len(codes)]), strict=True):
                counts[names[int(code)] if names else code] += stop - start
        with self._file("counts", "wb") as file:
            file.writelines(orjson.dumps(told) + b"\n" for told in sorted(counts.items()))

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
        names, places = self._names(), self._places()
        with self._file("rows", "rb") as file:
            for codes in self._codes():
                rows = np.fromfile(file, "<f8", len(codes) * width).reshape(-1, width)
                found, order, starts = in_order(codes)
                rows = rows[order]
                for code, (start, stop) in zip(found, pairwise([*starts.tolist(), len(codes)]), strict=True):
                    label = names[int(code)] if names else code
                    store.seek(8 * width * places[label])
                    store.write(rows[start:stop].data)
                    places[label] += stop - start

    def _places(self) -> dict[Label, int]:
        """Where the first point of each label goes."""
        with self._file("starts", "rb") as file:
            starts = np.fromfile(file, "<i8").tolist()
        return {label: start for (label, *_), start in zip(self.counted(0), starts, strict=True)}

    def _codes(self) -> Iterator[Labels]:
        if self._has("labels"):
            with self._file("labels", "rb") as file:
                while len(codes := np.fromfile(file, "<i8", PIECE)):
                    yield codes

    def _names(self) -> list[str]:
        """The strings that the codes stand for; none where the codes are the labels."""
        if not self.n_names:
            return []
        with self._file("names", "rb") as file:
            return [orjson.loads(line) for line in file]

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
