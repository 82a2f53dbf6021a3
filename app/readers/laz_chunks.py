"""How a LAZ file is compressed: chunks of points and their layers, held against the bytes that are there.

Layouts: M. Isenburg, "LASzip: lossless compression of LiDAR data", 2013, and its layered successor for the
point formats 6 to 10. lazrs allocates what a layer announces, so the sizes are checked before it sees them.
"""

import struct

from .errors import UnreadableFileError
from .las_header import LasHeader
from .rows import check_bytes
from .stretch import Stretch

_LASZIP = (b"laszip encoded", 22204)
_HEADER = struct.Struct("<H10xL16xH")
_ITEM = struct.Struct("<2H2x")
_PLACE = struct.Struct("<q")
_TABLE = struct.Struct("<2L")
_ANY_SIZE = 2**32 - 1
_POINTWISE, _LAYERED = 2, 3
_LAYERS = {10: 9, 11: 1, 12: 2}
_BYTES = 14  # extra bytes, in a layer each


def check_chunks(data: Stretch, header: LasHeader) -> None:
    """Raise where the number of points, of chunks, or the size of a layer cannot be true."""
    compressor, chunk_size, items = _compression(header)
    place, n_chunks = _table(data, header)
    check_bytes(n_chunks * header.point_size, place - header.start, n_chunks)
    if chunk_size != _ANY_SIZE and n_chunks != -(-header.n_points // chunk_size):
        message = f"{header.n_points} points do not fill {n_chunks} chunks of {chunk_size}"
        raise UnreadableFileError("file", message)
    if compressor == _LAYERED:
        n_layers = sum(size if kind == _BYTES else _LAYERS.get(kind, 0) for kind, size in items)
        _check_layers(data, place, header, n_chunks, n_layers)


def _compression(header: LasHeader) -> tuple[int, int, list[tuple[int, int]]]:
    """How the points are compressed, how many in a chunk, and the items of each by kind and size."""
    record = header.records.get(_LASZIP, memoryview(b""))
    if len(record) < _HEADER.size:
        raise UnreadableFileError("header", "the LAZ file does not say how its points are compressed")
    compressor, chunk_size, n_items = _HEADER.unpack(record[: _HEADER.size])
    if compressor not in (_POINTWISE, _LAYERED) or len(record) != _HEADER.size + n_items * _ITEM.size:
        raise UnreadableFileError("header", "the points of the LAZ file are not compressed in chunks")
    items = list(_ITEM.iter_unpack(record[_HEADER.size :]))
    if sum(size for _, size in items) != header.point_size or not chunk_size:
        message = "the compressed points of the LAZ file are not of the size announced"
        raise UnreadableFileError("header", message)
    return compressor, chunk_size, items


def _table(data: Stretch, header: LasHeader) -> tuple[int, int]:
    """Where the table of chunks stands, and how many it announces."""
    check_bytes(_PLACE.size, header.end - header.start, header.n_points)
    (place,) = _PLACE.unpack(data[header.start : header.start + _PLACE.size])
    if place == -1:  # written by who could not go back: it stands at the end
        (place,) = _PLACE.unpack(data[-_PLACE.size :])
    if not header.start + _PLACE.size <= place <= len(data) - _TABLE.size:
        raise UnreadableFileError("file", "the table of chunks does not lie behind the compressed points")
    _, n_chunks = _TABLE.unpack(data[place : place + _TABLE.size])
    return place, n_chunks


def _check_layers(data: Stretch, end: int, header: LasHeader, n_chunks: int, n_layers: int) -> None:
    """Walk the chunks to the end: a whole point, the number of points, the size of each layer, the layers."""
    sizes = struct.Struct(f"<{1 + n_layers}L")
    place, n_points = header.start + _PLACE.size, 0
    for _ in range(n_chunks):
        place += header.point_size + sizes.size
        if place > end:
            break
        count, *layers = sizes.unpack(data[place - sizes.size : place])
        place += sum(layers)
        n_points += count
    if place > end or n_points != header.n_points:
        message = f"the chunks of the LAZ file do not hold the {header.n_points} points announced"
        raise UnreadableFileError("file", message)
