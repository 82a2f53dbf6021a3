"""PCD, the format of the Point Cloud Library: ascii, binary and binary_compressed.

Own reader on top of liblzf: the header is held against the bytes that are there before anything is allocated.
"""

import re
import struct
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np

from .cloud import Cloud, build_from
from .columns import FOUND, Pick, find_columns
from .errors import UnreadableFileError
from .limits import UNLIMITED, Limits
from .rows import check_bytes, read_rows

_HEADER_LIMIT = 64 * 1024
_POINT_LIMIT = 64 * 1024
_LZF_RATIO = 88  # three bytes may repeat 264 that came before
_SIZES = struct.Struct("<2L")
_KINDS = {"F": "48", "I": "1248", "U": "1248"}
_ENTRIES = ("VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA")
# What FIELDS was called in the first versions.
_OLD_FIELDS = "COLUMNS"


@dataclass(frozen=True)
class _Field:
    """One field of a point: how often it repeats, and how one of it is written."""

    name: str
    kind: np.dtype[Any]
    count: int

    @property
    def itemsize(self) -> int:
        return self.kind.itemsize * self.count


@dataclass(frozen=True)
class _Header:
    """The fields of a point, how many points there are, how they are written, and where they start."""

    fields: list[_Field]
    n_points: int
    encoding: str
    start: int

    @property
    def point_size(self) -> int:
        return sum(field.itemsize for field in self.fields)


def is_pcd(data: memoryview) -> bool:
    """Whether the first line that is no comment begins a PCD header: its first entry, or the one after it."""
    for line, _ in _lines(bytes(data[:_HEADER_LIMIT])):
        words = line.partition("#")[0].split()
        if words:
            return words[0] in _ENTRIES[:2] and len(words) > 1
    return False


def read_pcd(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read a PCD file; depth cameras write a row of NaN where nothing came back."""
    header = _header(data)
    columns = find_columns([field.name if field.count == 1 else "" for field in header.fields], pick)
    limits.check_points(header.n_points)
    fields = _READERS[header.encoding](data[header.start :], header, limits)
    return build_from(columns, fields.__getitem__, "pcd")


def _read_ascii(data: memoryview, header: _Header, _: Limits) -> list[np.ndarray]:
    starts = [0, *accumulate(field.count for field in header.fields)]
    table = read_rows(data, 0, header.n_points, starts[-1], "file", last=True)
    return [table[:, start] for start in starts[:-1]]


def _read_binary(data: memoryview, header: _Header, _: Limits) -> list[np.ndarray]:
    """Points one after the other; exactly the bytes announced must be there."""
    needed = header.n_points * header.point_size
    check_bytes(needed, len(data), header.n_points)
    if needed < len(data):
        message = f"the header announces {header.n_points} points, {len(data) - needed} bytes follow them"
        raise UnreadableFileError("file", message)
    point = np.dtype([(f"f{i}", field.kind, (field.count,)) for i, field in enumerate(header.fields)])
    points = np.ndarray(header.n_points, point, data)
    return [points[name][:, 0] for name in point.names or ()]


def _read_compressed(data: memoryview, header: _Header, limits: Limits) -> list[np.ndarray]:
    """One field after the other, packed by liblzf, behind their packed and unpacked size."""
    from lzf import decompress

    if len(data) < _SIZES.size:
        raise UnreadableFileError("file", "the file ends before the sizes of the compressed data")
    packed, unpacked = _SIZES.unpack(data[: _SIZES.size])
    limits.check_unpacked(unpacked, packed)
    if unpacked != header.n_points * header.point_size:
        message = f"{header.n_points} points of {header.point_size} bytes do not unpack to {unpacked} bytes"
        raise UnreadableFileError("file", message)
    check_bytes(_SIZES.size + packed, len(data), header.n_points)
    if unpacked > packed * _LZF_RATIO:
        raise UnreadableFileError("file", f"{packed} bytes cannot unpack to {unpacked}")
    try:
        plain = decompress(bytes(data[_SIZES.size : _SIZES.size + packed]), unpacked) if unpacked else b""
    except ValueError:
        plain = None
    if plain is None or len(plain) != unpacked:
        raise UnreadableFileError("file", "the compressed data are damaged")
    starts = accumulate((field.itemsize * header.n_points for field in header.fields), initial=0)
    return [
        np.ndarray((header.n_points, field.count), field.kind, plain, start)[:, 0]
        for field, start in zip(header.fields, starts, strict=False)
    ]


_READERS: dict[str, Callable[[memoryview, _Header, Limits], list[np.ndarray]]] = {
    "ascii": _read_ascii,
    "binary": _read_binary,
    "binary_compressed": _read_compressed,
}


def _header(data: memoryview) -> _Header:
    entries: dict[str, list[str]] = {}
    for number, (line, start) in enumerate(_lines(bytes(data[:_HEADER_LIMIT])), 1):
        match line.partition("#")[0].split():
            case []:
                continue
            case [name, *words] if name in _ENTRIES and name not in entries:
                entries[name] = words
            case [name, *words] if name == _OLD_FIELDS and "FIELDS" not in entries:
                entries["FIELDS"] = words
            case _:
                raise UnreadableFileError("header", f"line {number} of the PCD header is not understood")
        if name == "DATA":
            if " ".join(words) not in _READERS:
                raise UnreadableFileError("DATA", "data must be ascii, binary or binary_compressed")
            return _Header(_fields(entries), _n_points(entries), words[0], start)
    raise UnreadableFileError("header", "no DATA line in the first 64 KiB of the PCD file")


def _lines(head: bytes) -> Iterator[tuple[str, int]]:
    """Each whole line, and where the next one starts; all end as the first one does."""
    newline = re.search(rb"\r?\n|\r", head)
    letter = newline[0][-1:] if newline else b"\n"
    start = 0
    while (end := head.find(letter, start) + 1) > 0:
        yield head[start:end].decode("latin-1"), end
        start = end


def _fields(entries: dict[str, list[str]]) -> list[_Field]:
    names = entries.get("FIELDS", [])
    sizes, types = entries.get("SIZE", []), entries.get("TYPE", [])
    counts = _numbers("COUNT", entries.get("COUNT", ["1"] * len(names)))
    if not len(names) == len(sizes) == len(types) == len(counts):
        message = "FIELDS, SIZE, TYPE and COUNT of the PCD header are not of one length"
        raise UnreadableFileError("header", message)
    if any(size not in (*_KINDS.get(kind, ""),) for kind, size in zip(types, sizes, strict=True)):
        message = "a field of the PCD header is none of F 4, 8 and I, U 1, 2, 4, 8"
        raise UnreadableFileError("header", message)
    kinds = [np.dtype(f"<{kind.lower()}{size}") for kind, size in zip(types, sizes, strict=True)]
    fields = [_Field(*field) for field in zip(names, kinds, counts, strict=True)]
    if not all(counts) or sum(field.itemsize for field in fields) > _POINT_LIMIT:
        raise UnreadableFileError("COUNT", "a field of the PCD header has no values, or a point over 64 KiB")
    return fields


def _n_points(entries: dict[str, list[str]]) -> int:
    """POINTS, or WIDTH times HEIGHT; where all are given they must agree."""
    named = {name: _numbers(name, entries[name]) for name in ("WIDTH", "HEIGHT", "POINTS") if name in entries}
    match named:
        case {"WIDTH": [width], "HEIGHT": [height], "POINTS": [n_points]} if width * height == n_points:
            return n_points
        case {"WIDTH": [width], "HEIGHT": [height]} if "POINTS" not in named:
            return width * height
        case {"POINTS": [n_points]} if len(named) == 1:
            return n_points
    raise UnreadableFileError("POINTS", "POINTS of the PCD header is not WIDTH times HEIGHT")


def _numbers(name: str, words: Sequence[str]) -> list[int]:
    if not all(word.isdecimal() and word.isascii() and len(word) < 16 for word in words):
        raise UnreadableFileError(name, f"{name} of the PCD header must be whole numbers, not negative")
    return [int(word) for word in words]
