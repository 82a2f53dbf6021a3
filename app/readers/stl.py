"""STL, binary and ascii: the corners of its triangles.

Own reader, not a library's: trimesh takes a second and 60 MB to import, for fifty bytes a triangle.
"""

import re
import struct
from collections.abc import Iterator

import numpy as np

from .cloud import Array, Cloud
from .columns import FOUND, Pick
from .errors import UnreadableFileError
from .limits import UNLIMITED, Limits
from .lines import check_lines, lines, load_triples, plain_numbers
from .mesh import build_mesh

_HEAD, _HEADER = 1024, 84
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_ASCII = re.compile(rb"solid\s(?:.*\n)?\s*facet\s", re.IGNORECASE)


def is_stl(data: memoryview) -> bool:
    """Whether the bytes are an STL file: a binary one has no signature, but a count that fits its length."""
    return _ASCII.match(data[:_HEAD]) is not None or _is_binary(data)


def _is_binary(data: memoryview) -> bool:
    """Also where the count is wrong, as far as that can be told: whole triangles, bytes that are no text."""
    n_bytes = len(data) - _HEADER
    if n_bytes < 0:
        return False
    return _count(data) * _TRIANGLE.itemsize == n_bytes or (
        n_bytes % _TRIANGLE.itemsize == 0 and b"\0" in bytes(data[: 4 * _HEADER])
    )


def read_stl(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the distinct corners of the triangles; normals are those of triangles, not of points."""
    corners = _read_binary(data) if _is_binary(data) else _read_ascii(data)
    return build_mesh(corners, None, "stl", limits, pick)


def _count(data: memoryview) -> int:
    return int(struct.unpack_from("<I", data, _HEADER - 4)[0])


def _read_binary(data: memoryview) -> Array:
    announced, there = _count(data), (len(data) - _HEADER) // _TRIANGLE.itemsize
    if announced != there:
        raise UnreadableFileError(
            "file", f"no known format; as a binary STL it announces {announced} triangles, {there} are there"
        )
    triangles = np.frombuffer(data, _TRIANGLE, offset=_HEADER)
    return triangles["corners"].reshape(-1, 3).astype(np.float64)


def _read_ascii(data: memoryview) -> Array:
    check_lines(data)
    text = plain_numbers(bytes(data))

    def rows(keyword: str) -> Iterator[tuple[int, str]]:
        for number, line in lines(text, re.compile(rf"(?i)^[^\S\n]*+{keyword}", re.MULTILINE)):
            if line.lstrip()[: len(keyword)].lower() == keyword:
                yield number, line

    corners = load_triples(lambda: rows("vertex"), "vertex")
    n_facets = sum(1 for _ in rows("facet"))
    if len(corners) != 3 * n_facets or next(rows("endsolid"), None) is None:
        raise UnreadableFileError(
            "file",
            f"{len(corners)} vertices in {n_facets} facets, which have three each; the STL file ends early",
        )
    return corners
