"""LAS and LAZ, versions 1.0 to 1.4: scaled coordinates in float64, decoded by laspy and lazrs.

The public header, the variable length records and, in LAZ, the layout of the chunks are held against the
bytes that are there before laspy sees them; then points are decoded chunk by chunk, so that a count costs
nothing until its points are there.
"""

import io
import logging
import math
import struct
from dataclasses import dataclass

import numpy as np

from app.readers.cloud import Cloud, build_from, find_columns
from app.readers.errors import UnreadableFileError
from app.readers.limits import UNLIMITED, Limits
from app.readers.rows import check_bytes

_CHUNK = 50_000
_RECORDS_LIMIT = 64 * 1024
_PUBLIC = struct.Struct("<6xH16x2B68xHLLBHL20x3d3d48x")
_WAVEFORMS = struct.Struct("<Q")
_LARGE = struct.Struct("<QLQ")
_SIZES = {0: 227, 1: 227, 2: 227, 3: 235, 4: 375}
_POINT_SIZES = (20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67)
_RECORD = struct.Struct("<2x16sHH32x")
_COMPRESSED, _FORMAT_BITS = 0x80, 0x3F
_WAVEFORMS_INSIDE = 0x2
_LASZIP = (b"laszip encoded", 22204)
_LASZIP_HEADER = struct.Struct("<H10xL16xH")
_LASZIP_ITEM = struct.Struct("<2xH2x")
_CHUNKED = (2, 3)
_PLACE = struct.Struct("<q")
_TABLE = struct.Struct("<2L")
_ANY_SIZE = 2**32 - 1


@dataclass(frozen=True)
class _Header:
    """Where the points start and end, how many there are, of what size, and the records before them."""

    start: int
    end: int
    n_points: int
    point_size: int
    compressed: bool
    records: dict[tuple[bytes, int], memoryview]


def read_las(data: memoryview, limits: Limits = UNLIMITED, labels: str | None = None) -> Cloud:
    """Read a LAS or LAZ file; any dimension of one number a point may be the labels."""
    header = _header(data)
    limits.check_points(header.n_points)
    if header.compressed and header.n_points:
        limits.check_unpacked(header.n_points * header.point_size)
        _check_chunks(data, header)
    elif not header.compressed:
        _check_points(header)
    try:
        return _decode(data, header, labels)
    except UnreadableFileError:
        raise
    except Exception as error:  # laspy and lazrs have no common class of errors
        raise UnreadableFileError("file", "the points cannot be decoded: the file is damaged") from error


def _decode(data: memoryview, header: _Header, labels: str | None) -> Cloud:
    import laspy

    logging.getLogger("laspy").setLevel(logging.CRITICAL)  # what it complains about, it also raises
    with laspy.open(io.BytesIO(data), read_evlrs=False, laz_backend=laspy.LazBackend.Lazrs) as reader:
        dimensions = reader.header.point_format.dimensions
        names = [dimension.name if dimension.num_elements == 1 else "" for dimension in dimensions]
        columns = find_columns(names, labels)
        wanted = [*columns.used, *([] if columns.label is None else [columns.label])]
        parts: dict[int, list[np.ndarray]] = {i: [] for i in wanted}
        n_read = 0
        for chunk in reader.chunk_iterator(_CHUNK):
            n_read += len(chunk)
            for i in wanted:
                # X is a whole number of steps; x is in the unit of the file.
                name = names[i].lower() if i in columns.points else names[i]
                parts[i].append(np.array(chunk[name]))
    if n_read != header.n_points:
        raise UnreadableFileError(
            "file", f"the header announces {header.n_points} points, {n_read} are there"
        )
    return build_from(columns, lambda i: np.concatenate(parts[i] or [np.empty(0)]), "las")


def _header(data: memoryview) -> _Header:
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
    if (kind := format & _FORMAT_BITS) >= len(_POINT_SIZES) or point_size < _POINT_SIZES[kind]:
        raise UnreadableFileError("header", "the LAS point format is not known, or its points are too short")
    end = len(data)
    if minor >= 3 and encoding & _WAVEFORMS_INSIDE:
        end = _end_before(end, start, *_WAVEFORMS.unpack(data[227:235]))
    if minor >= 4:
        first, n_large, n_all = _LARGE.unpack(data[235:255])
        if n_points not in (0, n_all):
            raise UnreadableFileError("header", "the two numbers of points in the LAS header differ")
        n_points = n_all
        if n_large:
            end = _end_before(end, start, first)
    records = _records(data[size:start], n_records)
    return _Header(start, end, n_points, point_size, bool(format & _COMPRESSED), records)


def _end_before(end: int, start: int, next_start: int) -> int:
    """Where the points end, when something else starts behind them."""
    if not start <= next_start <= end:
        raise UnreadableFileError("header", "extended records or waveforms do not lie behind the points")
    return next_start


def _records(data: memoryview, count: int) -> dict[tuple[bytes, int], memoryview]:
    """The variable length records by user and id."""
    if len(data) > _RECORDS_LIMIT:
        raise UnreadableFileError("header", "the variable length records of the LAS file are over 64 KiB")
    check_bytes(count * _RECORD.size, len(data), count)
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


def _check_points(header: _Header) -> None:
    """Raise unless the points are there, and no more of them than announced."""
    there = header.end - header.start
    check_bytes(header.n_points * header.point_size, there, header.n_points)
    if there >= (header.n_points + 1) * header.point_size:
        n_there = there // header.point_size
        message = f"the header announces {header.n_points} points, there are bytes for {n_there}"
        raise UnreadableFileError("file", message)


def _check_chunks(data: memoryview, header: _Header) -> None:
    """Raise where the number of points or of chunks cannot be true: each chunk starts with a whole point."""
    record = header.records.get(_LASZIP, memoryview(b""))
    if len(record) < _LASZIP_HEADER.size:
        raise UnreadableFileError("header", "the LAZ file does not say how its points are compressed")
    compressor, chunk_size, n_items = _LASZIP_HEADER.unpack(record[: _LASZIP_HEADER.size])
    items = record[_LASZIP_HEADER.size :]
    if compressor not in _CHUNKED or len(items) != n_items * _LASZIP_ITEM.size:
        raise UnreadableFileError("header", "the LAZ file does not say how its points are compressed")
    if sum(size for (size,) in _LASZIP_ITEM.iter_unpack(items)) != header.point_size or not chunk_size:
        message = "the compressed points of the LAZ file are not of the size announced"
        raise UnreadableFileError("header", message)
    n_chunks = _n_chunks(data, header)
    check_bytes(n_chunks * header.point_size, header.end - header.start, n_chunks)
    if chunk_size == _ANY_SIZE:
        return
    if n_chunks != -(-header.n_points // chunk_size):
        message = f"{header.n_points} points do not fill {n_chunks} chunks of {chunk_size}"
        raise UnreadableFileError("file", message)


def _n_chunks(data: memoryview, header: _Header) -> int:
    """The number of chunks, from the table whose place stands before the first chunk."""
    check_bytes(_PLACE.size, header.end - header.start, header.n_points)
    (place,) = _PLACE.unpack(data[header.start : header.start + _PLACE.size])
    if place == -1:  # written by who could not go back: it stands at the end
        (place,) = _PLACE.unpack(data[-_PLACE.size :])
    if not header.start + _PLACE.size <= place <= len(data) - _TABLE.size:
        raise UnreadableFileError("file", "the table of chunks does not lie behind the compressed points")
    _, n_chunks = _TABLE.unpack(data[place : place + _TABLE.size])
    return n_chunks
