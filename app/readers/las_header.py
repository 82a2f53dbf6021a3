"""The header of a LAS or LAZ file, versions 1.0 to 1.4, held against the bytes that are there.

Layouts: ASPRS, LAS Specification 1.4 R15, tables 3 to 6.
"""

import math
import struct
from dataclasses import dataclass

from .errors import UnreadableFileError
from .rows import check_bytes
from .stretch import Stretch

_RECORDS_LIMIT = 16 * 1024 * 1024
# Files hold a dozen; laspy makes an object of each.
_MOST_RECORDS = 1000
_PUBLIC = struct.Struct("<6xH16x2B68xHLLBHL20x3d3d48x")
_WAVEFORMS = struct.Struct("<Q")
_LARGE = struct.Struct("<QLQ")
_SIZES = {0: 227, 1: 227, 2: 227, 3: 235, 4: 375}
_POINT_SIZES = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)
_RECORD = struct.Struct("<2x16sHH32x")
_COMPRESSED, _FORMAT_BITS = 0x80, 0x3F
_WAVEFORMS_INSIDE = 0x2


@dataclass(frozen=True)
class LasHeader:
    """Where the points start and end, how many there are, of what size, and the records before them."""

    start: int
    end: int
    n_points: int
    point_size: int
    compressed: bool
    records: dict[tuple[bytes, int], memoryview]

    def check_points(self) -> None:
        """Raise unless the points of a LAS file are there, and no more of them than announced."""
        there = self.end - self.start
        check_bytes(self.n_points * self.point_size, there, self.n_points)
        if there >= (self.n_points + 1) * self.point_size:
            n_there = there // self.point_size
            message = f"the header announces {self.n_points} points, there are bytes for {n_there}"
            raise UnreadableFileError("file", message)


def read_header(data: Stretch) -> LasHeader:
    """Read the public header and the variable length records; extended ones are not read."""
    if len(data) < _PUBLIC.size:
        raise UnreadableFileError("header", "the file ends within the LAS header")
    encoding, major, minor, size, start, n_records, format, point_size, n_points, *rest = _PUBLIC.unpack(
        data[: _PUBLIC.size]
    )
    if major != 1 or minor not in _SIZES:
        raise UnreadableFileError("header", "LAS of another version than 1.0 to 1.4")
    if not _SIZES[minor] <= size <= start <= len(data):
        raise UnreadableFileError(
            "header", "the LAS header, its records and the points do not lie in the file"
        )
    if not all(map(math.isfinite, rest)) or not all(rest[:3]):
        raise UnreadableFileError("header", "a scale or offset of the LAS header is NaN, infinite or 0")
    _check_format(format & _FORMAT_BITS, point_size)
    end = len(data)
    if minor >= 3 and encoding & _WAVEFORMS_INSIDE:
        end = _end_before(end, start, *_WAVEFORMS.unpack(data[227:235]))
    if minor >= 4:
        end, n_points = _large(data, start, end, n_points)
    if start - size > _RECORDS_LIMIT:
        raise UnreadableFileError("header", "the variable length records of the LAS file are over 16 MiB")
    records = _records(data[size:start], n_records)
    return LasHeader(start, end, n_points, point_size, bool(format & _COMPRESSED), records)


def _check_format(format: int, point_size: int) -> None:
    if format >= len(_POINT_SIZES) or point_size < _POINT_SIZES[format]:
        raise UnreadableFileError("header", "the LAS point format is not known, or its points are too short")


def _large(data: Stretch, start: int, end: int, n_points: int) -> tuple[int, int]:
    """Where the points end, and how many they are, by the fields that version 1.4 has for large files."""
    first, n_large, n_all = _LARGE.unpack(data[235:255])
    if n_points not in (0, n_all):
        raise UnreadableFileError("header", "the two numbers of points in the LAS header differ")
    return (_end_before(end, start, first) if n_large else end), n_all


def _end_before(end: int, start: int, next_start: int) -> int:
    """Where the points end, when something else starts behind them."""
    if not start <= next_start <= end:
        raise UnreadableFileError("header", "extended records or waveforms do not lie behind the points")
    return next_start


def _records(data: memoryview, count: int) -> dict[tuple[bytes, int], memoryview]:
    """The variable length records by user and id."""
    check_bytes(count * _RECORD.size, len(data), count)
    if count > _MOST_RECORDS:
        message = f"{count} variable length records in the LAS file; at most {_MOST_RECORDS} are read"
        raise UnreadableFileError("header", message)
    records = {}
    place = 0
    for _ in range(count):
        if place + _RECORD.size > len(data):
            raise UnreadableFileError("header", "a variable length record reaches into the points")
        user, number, length = _RECORD.unpack(data[place : place + _RECORD.size])
        place += _RECORD.size + length
        records[user.rstrip(b"\0"), number] = data[place - length : place]
    if place > len(data):
        raise UnreadableFileError("header", "a variable length record reaches into the points")
    return records
