"""PLY, ascii and binary: the coordinates, normals and labels of its vertices.

Own reader, not a library's: the counts of the header are held against the bytes that are there before
anything is allocated, and what follows the vertices (faces) is not parsed at all.
"""

from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO, TextIOWrapper
from itertools import accumulate, islice
from typing import Any

import numpy as np

from .cloud import Cloud, build_from
from .columns import FOUND, Pick, find_columns
from .errors import UnreadableFileError
from .limits import UNLIMITED, Limits
from .rows import check_bytes, read_rows

_HEADER_LIMIT = 64 * 1024
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_INTEGERS = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
}  # fmt: skip
_TYPES = _INTEGERS | {"float": "f4", "float32": "f4", "double": "f8", "float64": "f8"}


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

    def dtype(self, order: str, lengths: list[int]) -> np.dtype[Any]:
        """A row as a record, `p0`, `p1`, ...; its lists of these lengths, which `n0`, ... repeat."""
        fields: list[tuple[Any, ...]] = []
        for i, (item, length) in enumerate(zip(self.properties, lengths, strict=True)):
            if item.length_kind is None:
                fields.append((f"p{i}", order + item.kind))
            else:
                fields += [(f"n{i}", order + item.length_kind), (f"p{i}", order + item.kind, (length,))]
        return np.dtype(fields)


def read_ply(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the vertices of a PLY file; lists may stand in or before them if all are of one length."""
    order, elements, start = _header(data)
    names = [element.name for element in elements]
    if "vertex" not in names:
        raise UnreadableFileError("header", "the PLY file has no element named vertex")
    before, vertex = elements[: names.index("vertex")], elements[names.index("vertex")]
    places = [i for i, item in enumerate(vertex.properties) if item.length_kind is None]
    columns = find_columns([vertex.properties[i].name for i in places], pick)
    limits.check_points(vertex.count)
    read = _read_binary if order else _read_ascii
    column = read(data[start:], order, before, vertex, vertex is elements[-1])
    return build_from(columns, lambda i: column(places[i]), "ply")


def _read_binary(
    data: memoryview, order: str, before: list[_Element], vertex: _Element, last: bool
) -> Callable[[int], np.ndarray]:
    start = 0
    for element in before:
        if element.properties:
            start += _rows(data[start:], element, order).nbytes
    rows = _rows(data[start:], vertex, order)
    left = len(data) - start - rows.nbytes
    if last and left >= rows.itemsize:
        raise UnreadableFileError("file", f"{left} bytes follow the {vertex.count} vertices announced")
    return lambda i: rows[f"p{i}"]


def _read_ascii(
    data: memoryview, _: str, before: list[_Element], vertex: _Element, last: bool
) -> Callable[[int], np.ndarray]:
    skip = sum(element.count for element in before)
    lengths = [0] * len(vertex.properties)
    if any(item.length_kind for item in vertex.properties):
        lengths = _lengths_in_text(
            next(islice(TextIOWrapper(BytesIO(data), "latin-1"), skip, None), ""), vertex
        )
    lists = [i for i, item in enumerate(vertex.properties) if item.length_kind]
    starts = [0, *accumulate(1 + length for length in lengths)]
    table = read_rows(data, skip, vertex.count, starts[-1], "vertex", last)
    if any((table[:, starts[i]] != lengths[i]).any() for i in lists):
        raise _uneven()
    return lambda i: table[:, starts[i]]


def _lengths_in_text(line: str, element: _Element) -> list[int]:
    """The lengths of the lists in a row, 0 for what is no list."""
    words, lengths, place = line.split(), [], 0
    for item in element.properties:
        length = 0
        if item.length_kind is not None:
            word = words[place] if place < len(words) else ""
            if not word.isdecimal() or len(word) > 9:
                raise UnreadableFileError("vertex", "a list does not start with its length")
            length = int(word)
        lengths.append(length)
        place += 1 + length
    return lengths


def _rows(data: memoryview, element: _Element, order: str) -> np.ndarray:
    """The rows of an element (count,) as records, all of the size of the first one."""
    lengths, size = _lengths(data, element, order) if element.count else ([0] * len(element.properties), 0)
    check_bytes(element.count * size, len(data), element.count)
    rows = np.ndarray(element.count, element.dtype(order, lengths), data)
    lists = [i for i, item in enumerate(element.properties) if item.length_kind]
    if any((rows[f"n{i}"] != lengths[i]).any() for i in lists):
        raise _uneven()
    return rows


def _lengths(data: memoryview, element: _Element, order: str) -> tuple[list[int], int]:
    """The lengths of the lists in the first row, 0 for what is no list, and the bytes of that row."""
    lengths, size = [], 0
    for item in element.properties:
        length = 0
        size += int((item.length_kind or item.kind)[1])
        if item.length_kind is not None:
            check_bytes(size, len(data), element.count)
            start = size - int(item.length_kind[1])
            length = int(np.ndarray((), order + item.length_kind, data, start))
            if length < 0:
                raise UnreadableFileError("file", "the PLY file holds a list of negative length")
            size += length * int(item.kind[1])
        lengths.append(length)
    return lengths, size


def _uneven() -> UnreadableFileError:
    return UnreadableFileError(
        "file", "lists of different lengths in or before the vertices are not supported"
    )


def _header(data: memoryview) -> tuple[str, list[_Element], int]:
    head = bytes(data[:_HEADER_LIMIT])
    end = head.find(b"\nend_header")
    newline = head.find(b"\n", end + 1)
    if end < 0 or newline < 0:
        raise UnreadableFileError("header", "no end_header line in the first 64 KiB of the PLY file")
    order: str | None = None
    elements: list[_Element] = []
    for number, line in enumerate(head[:end].decode("latin-1").splitlines(), 1):
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
        case [] | ["ply"] | ["comment", *_] | ["obj_info", *_]:
            pass
        case _:
            raise KeyError
    return None
