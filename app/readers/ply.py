"""PLY, ascii and binary: the coordinates, normals and labels of its vertices.

Own reader, not a library's: the counts of the header are held against the bytes that are there before
anything is allocated, and what follows the vertices (faces) is not parsed at all.
"""

import re
import struct
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np
from numpy.typing import NDArray

from .cloud import Cloud, build_from
from .columns import FOUND, Columns, Pick, find_columns
from .errors import TooLargeError, UnreadableFileError
from .limits import UNLIMITED, Limits
from .rows import check_bytes, read_rows
from .stretch import FileBytes, Stretch

_HEADER_LIMIT = 64 * 1024
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_INTEGERS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
}  # fmt: skip
_TYPES = _INTEGERS | {
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8", "int64": "i8", "uint64": "u8",
}  # fmt: skip
# Lists of different lengths are stepped over one by one, some three million a second.
_LISTS_LIMIT = 1_000_000
_END = re.compile(rb"[\r\n][ \t]*end_header(?=[ \t]*[\r\n])")


@dataclass(frozen=True)
class _Property:
    """One property of an element: its name, type and, for a list, the type of its length."""

    name: str
    kind: str
    length_kind: str | None = None


@dataclass(frozen=True)
class _Element:
    """One element of the header: its name, how many rows it has, and what they hold."""

    name: str
    count: int
    properties: list[_Property]

    @property
    def n_lists(self) -> int:
        """How many lists each row holds."""
        return sum(item.length_kind is not None for item in self.properties)

    @property
    def least_size(self) -> int:
        """The bytes of a row whose lists are empty."""
        return sum(_size(item.length_kind or item.kind) for item in self.properties)


def read_ply(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the vertices of a PLY file; lists of any length may stand in or before them."""
    order, elements, start = _header(data)
    before, vertex = _to_the_vertices(elements)
    columns, places = _chosen(vertex, pick)
    limits.check_points(vertex.count)
    read = _read_binary if order else _read_ascii
    column = read(data[start:], order, before, vertex, vertex is elements[-1])
    return build_from(columns, lambda i: column(places[i]), "ply")


def ply_pieces(file: BinaryIO, pick: Pick, n_points: int) -> Iterator[Cloud] | None:
    """The cloud of a binary PLY file in pieces of so many points; None where rows do not have one size."""
    data = FileBytes(file)
    order, elements, start = _header(data)
    before, vertex = _to_the_vertices(elements)
    if not order or any(element.n_lists for element in (*before, vertex)):
        return None
    columns, places = _chosen(vertex, pick)
    for element in (*before, vertex):
        n_bytes = element.count * element.least_size
        check_bytes(n_bytes, len(data) - start, element.count)
        start += n_bytes
    _check_end(len(data) - start, vertex, vertex is elements[-1])
    begin = start - vertex.count * vertex.least_size

    def pieces() -> Iterator[Cloud]:
        for first in range(0, vertex.count, n_points):
            count = min(n_points, vertex.count - first)
            place = begin + first * vertex.least_size
            column = _columns_of(data[place : place + count * vertex.least_size], order, vertex, count)
            yield build_from(columns, lambda i: column(places[i]), "ply", first)  # noqa: B023

    return pieces()


def _to_the_vertices(elements: list[_Element]) -> tuple[list[_Element], _Element]:
    """The elements before the vertices, and these."""
    names = [element.name for element in elements]
    if "vertex" not in names:
        raise UnreadableFileError("header", "the PLY file has no element named vertex")
    return elements[: names.index("vertex")], elements[names.index("vertex")]


def _chosen(vertex: _Element, pick: Pick) -> tuple[Columns, list[int]]:
    """Which of the properties that are no lists are read, and where each of these stands among all."""
    places = [i for i, item in enumerate(vertex.properties) if item.length_kind is None]
    return find_columns([vertex.properties[i].name for i in places], pick), places


def _read_ascii(
    data: memoryview, _: str, before: list[_Element], vertex: _Element, last: bool
) -> Callable[[int], np.ndarray]:
    skip = sum(element.count for element in before)
    if not vertex.n_lists:
        table = read_rows(data, skip, vertex.count, len(vertex.properties), "vertex", last)
        return lambda i: table[:, i]
    lists = [item.length_kind is not None for item in vertex.properties]
    table = read_rows(data, skip, vertex.count, lists.count(False), "vertex", last, _Without(lists))
    return lambda i: table[:, lists[:i].count(False)]


@dataclass(frozen=True)
class _Without:
    """Leaves the lists out of a row of an ascii file; `lists` says which properties are some."""

    lists: list[bool]

    def __call__(self, line: str) -> str:
        words, kept, place = line.split(), [], 0
        for is_list in self.lists:
            word = words[place] if place < len(words) else ""
            place += 1
            if not is_list:
                kept.append(word)
            elif word.isdecimal() and len(word) < 10:
                place += int(word)
            else:
                raise UnreadableFileError("vertex", "a list does not start with its length")
        if place != len(words):
            raise UnreadableFileError("vertex", "a row is not as long as its lists say")
        return " ".join(kept)


def _read_binary(
    data: memoryview, order: str, before: list[_Element], vertex: _Element, last: bool
) -> Callable[[int], np.ndarray]:
    data, starts = _starts(data, [*before, vertex], order)
    _check_end(len(data) - int(starts[-1]), vertex, last)
    if not vertex.n_lists:
        return _columns_of(data, order, vertex, vertex.count)
    return lambda i: _column(data, order, vertex.properties[: i + 1], starts[:-1])


def _check_end(left: int, vertex: _Element, last: bool) -> None:
    """Raise where bytes of more vertices follow those announced."""
    if last and left >= vertex.least_size:
        raise UnreadableFileError("file", f"{left} bytes follow the {vertex.count} vertices announced")


def _columns_of(data: memoryview, order: str, vertex: _Element, count: int) -> Callable[[int], np.ndarray]:
    """The columns of so many rows without lists."""
    kinds = [(f"p{i}", order + item.kind) for i, item in enumerate(vertex.properties)]
    rows = np.ndarray(count, np.dtype(kinds), data)
    return lambda i: rows[f"p{i}"]


def _starts(data: memoryview, elements: list[_Element], order: str) -> tuple[memoryview, NDArray[np.int64]]:
    """The bytes from the last of these elements on, and where its rows start, if it has lists, and end."""
    end = n_stepped = 0
    for element in elements:
        data = data[end:]
        check_bytes(element.count * element.least_size, len(data), element.count)
        size = _row_size(data, element, order)
        if size is None:
            n_stepped += element.count * element.n_lists
            if n_stepped > _LISTS_LIMIT:
                limit = f"at most {_LISTS_LIMIT} of different lengths are read"
                raise TooLargeError("file", f"{n_stepped} lists in or before the vertices; {limit}")
            starts = _walk(data, element, order)
        else:
            each = element is elements[-1] and element.n_lists > 0
            starts = size * np.arange(0 if each else element.count, element.count + 1)
        end = int(starts[-1])
    return data, starts


def _row_size(data: memoryview, element: _Element, order: str) -> int | None:
    """The bytes of each row of an element, or None where its rows differ in the lengths of their lists."""
    size, lengths = 0, []
    for item in element.properties:
        if item.length_kind is None or not element.count:
            size += _size(item.length_kind or item.kind)
            continue
        kind = np.dtype(order + item.length_kind)
        if size + kind.itemsize > len(data):
            return None
        length = int(np.ndarray((), kind, data, size))
        if length < 0:
            return None
        lengths.append((length, kind, size))
        size += kind.itemsize + length * _size(item.kind)
    if size * element.count > len(data):
        return None
    for length, kind, place in lengths:
        if (np.ndarray(element.count, kind, data, place, (size,)) != length).any():
            return None
    return size


def _walk(data: memoryview, element: _Element, order: str) -> NDArray[np.int64]:
    """Where each row of an element starts, and where the last one ends: nothing but steps finds it."""
    steps, gap = [], 0
    for item in element.properties:
        if item.length_kind is None:
            gap += _size(item.kind)
        else:
            length = struct.Struct(order + np.dtype(item.length_kind).char)
            steps.append((gap, length.unpack_from, length.size, _size(item.kind)))
            gap = 0
    starts, place = array("q", [0]), 0
    try:
        for _ in range(element.count):
            for before, unpack, size, each in steps:
                place += before
                (length,) = unpack(data, place)
                if length < 0:
                    raise UnreadableFileError("file", "the PLY file holds a list of negative length")
                place += size + length * each
            place += gap
            starts.append(place)
    except struct.error:
        place = len(data) + 1
    if place > len(data):
        message = f"the file ends within the {element.count} rows of lists that its header announces"
        raise UnreadableFileError("file", message)
    return np.frombuffer(starts, np.int64)


def _column(
    data: memoryview, order: str, properties: list[_Property], starts: NDArray[np.int64]
) -> np.ndarray:
    """The last of these properties in the rows that start there: lists before it move it from row to row."""
    places = starts
    for item in properties[:-1]:
        if item.length_kind is None:
            places = places + _size(item.kind)
        else:
            lengths = _gathered(data, order + item.length_kind, places).astype(np.int64)
            places = places + _size(item.length_kind) + lengths * _size(item.kind)
    return _gathered(data, order + properties[-1].kind, places)


def _gathered(data: memoryview, kind: str, places: NDArray[np.int64]) -> np.ndarray:
    """The numbers (N,) of this type that start at these bytes."""
    size = _size(kind)
    if len(places) == 0:
        return np.empty(0, kind)
    windows = np.lib.stride_tricks.sliding_window_view(np.frombuffer(data, np.uint8), size)
    return windows[places].view(kind)[:, 0]


def _size(kind: str) -> int:
    return int(kind[-1])


def _header(data: Stretch) -> tuple[str, list[_Element], int]:
    """The order of the bytes, the elements, and where their rows start.

    Lines end as the first one does: a body in binary may begin with the other letter.
    """
    head = bytes(data[:_HEADER_LIMIT])
    found = _END.search(head)
    end = b"\r" if re.match(rb"(?i)ply[ \t]*\r(?!\n)", head) else b"\n"
    newline = head.find(end, found.end()) if found else -1
    if found is None or newline < 0:
        raise UnreadableFileError("header", "no end_header line in the first 64 KiB of the PLY file")
    order: str | None = None
    elements: list[_Element] = []
    for number, line in enumerate(re.split("\r\n?|\n", head[: found.start()].decode("latin-1")), 1):
        try:
            told = _header_line(line.split(), elements)
        except (KeyError, IndexError) as error:
            raise UnreadableFileError(
                "header", f"line {number} of the PLY header is not understood"
            ) from error
        order = order if told is None else told
    if order is None:
        raise UnreadableFileError("header", "the PLY header has no format line")
    return order, elements, newline + 1


def _header_line(words: list[str], elements: list[_Element]) -> str | None:
    """Add what a line tells of the elements; the order of the bytes, if it tells that."""
    match words:
        case ["format", name, _]:
            return _ORDERS[name]
        case ["element", name, count] if count.isdecimal() and len(count) < 16:
            elements.append(_Element(name, int(count), []))
        case ["property", "list", length, kind, name]:
            elements[-1].properties.append(_Property(name, _TYPES[kind], _INTEGERS[length]))
        case ["property", kind, name]:
            elements[-1].properties.append(_Property(name, _TYPES[kind]))
        case [] | ["ply" | "PLY"] | ["comment", *_] | ["obj_info", *_]:
            pass
        case _:
            raise KeyError
    return None
