"""PLY, ascii and binary: the coordinates and normals of its vertices.

Own reader, not a library's: the counts of the header are held against the bytes that are there before
anything is allocated, and what follows the vertices (faces) is not parsed at all.
"""

from dataclasses import dataclass
from io import BytesIO, TextIOWrapper
from itertools import islice
from typing import Any

import numpy as np

from app.readers.cloud import Cloud, Columns, build_cloud, find_columns
from app.readers.errors import UnreadableFileError
from app.readers.limits import UNLIMITED, Limits

_HEADER_LIMIT = 64 * 1024
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
_TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2",
    "ushort": "u2", "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4",
    "float": "f4", "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip


@dataclass(frozen=True)
class _Element:
    """One element of the header: its name, count, scalar properties (name, type), and names of its lists."""

    name: str
    count: int
    properties: list[tuple[str, str]]
    lists: list[str]


def read_ply(data: memoryview, limits: Limits = UNLIMITED, labels: str | None = None) -> Cloud:
    """Read the vertices of a PLY file."""
    order, elements, start = _header(data)
    names = [element.name for element in elements]
    if "vertex" not in names:
        raise UnreadableFileError("header", "the PLY file has no element named vertex")
    before, vertex = elements[: names.index("vertex")], elements[names.index("vertex")]
    for element in [*before, vertex]:
        if element.lists:
            raise UnreadableFileError("header", "list properties in or before the vertices are not supported")
    columns = find_columns([name for name, _ in vertex.properties])
    limits.check_points(vertex.count)
    read = _read_binary if order else _read_ascii
    return build_cloud(read(data[start:], order, before, vertex, columns), columns.packed(), "ply")


def _read_binary(
    data: memoryview, order: str, before: list[_Element], vertex: _Element, columns: Columns
) -> np.ndarray:
    skip = sum(element.count * _dtype(element, order).itemsize for element in before)
    dtype = _dtype(vertex, order)
    _check_bytes(skip + vertex.count * dtype.itemsize, len(data), vertex.count)
    table = np.frombuffer(data, dtype, count=vertex.count, offset=skip)
    return np.column_stack([table[f"p{i}"].astype(np.float64) for i in columns.used])


def _read_ascii(
    data: memoryview, order: str, before: list[_Element], vertex: _Element, columns: Columns
) -> np.ndarray:
    skip = sum(element.count for element in before)
    width = len(vertex.properties)
    _check_bytes(2 * (skip + vertex.count * width) - 1, len(data), vertex.count)
    lines = islice(TextIOWrapper(BytesIO(data), "latin-1"), skip, skip + vertex.count)
    if not vertex.count:
        return np.empty((0, len(columns.used)))
    try:
        table = np.loadtxt(lines, np.float64, comments=None, ndmin=2)
    except ValueError as error:
        raise UnreadableFileError("vertex", f"a vertex is not a row of {width} numbers") from error
    if table.shape != (vertex.count, width):
        raise UnreadableFileError(
            "vertex",
            f"the header announces {vertex.count} vertices of {width} numbers, "
            f"there are {len(table)} of {table.shape[1]}",
        )
    return table[:, columns.used]


def _check_bytes(needed: int, there: int, count: int) -> None:
    if needed > there:
        raise UnreadableFileError(
            "file",
            f"the header announces {count:.9g} vertices, which need {needed:.9g} bytes; {there} are there",
        )


def _dtype(element: _Element, order: str) -> np.dtype[Any]:
    return np.dtype([(f"p{i}", order + kind) for i, (_, kind) in enumerate(element.properties)])


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
            match line.split():
                case ["format", name, _]:
                    order = _ORDERS[name]
                case ["element", name, count] if count.isdecimal() and len(count) < 16:
                    elements.append(_Element(name, int(count), [], []))
                case ["property", "list", _, _, name]:
                    elements[-1].lists.append(name)
                case ["property", kind, name]:
                    elements[-1].properties.append((name, _TYPES[kind]))
                case [] | ["ply"] | ["comment", *_] | ["obj_info", *_]:
                    pass
                case _:
                    raise KeyError
        except (KeyError, IndexError) as error:
            raise UnreadableFileError(
                "header", f"line {number} of the PLY header is not understood"
            ) from error
    if order is None:
        raise UnreadableFileError("header", "the PLY header has no format line")
    return order, elements, newline + 1
