"""LAS and LAZ, versions 1.0 to 1.4: scaled coordinates in float64, decoded by laspy and lazrs.

Points are decoded piece by piece, so that a count costs nothing until its points are there.
"""

import io
import logging
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, BinaryIO

import numpy as np

from .cloud import Cloud, build_from
from .columns import FOUND, Pick, find_columns
from .errors import UnreadableFileError
from .las_header import LasHeader, read_header
from .las_unit import unit_of
from .laz_chunks import check_chunks
from .limits import UNLIMITED, Limits
from .stretch import FileBytes, Stretch

_PIECE = 50_000
_PANIC = "PanicException"
"""What a fault within lazrs, which is written in Rust, raises: not an `Exception`, and nothing to import."""


def read_las(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read a LAS or LAZ file; any dimension of one number a point may be the labels."""
    header = read_header(data)
    limits.check_points(header.n_points)
    if header.compressed and header.n_points:
        limits.check_unpacked(header.n_points * header.point_size, header.end - header.start)
    _check(data, header)
    (cloud,) = _decoded(io.BytesIO(data), header, pick)
    return cloud


def las_pieces(file: BinaryIO, pick: Pick, n_points: int) -> Iterator[Cloud]:
    """The cloud of a LAS, LAZ or COPC file in pieces of so many points, of which it holds one at a time.

    Raises what `read_las` does; some of it after the pieces that were good.
    """
    data = FileBytes(file)
    header = read_header(data)
    _check(data, header)
    file.seek(0)
    yield from _decoded(file, header, pick, n_points)


def _check(data: Stretch, header: LasHeader) -> None:
    """Raise unless the points that the header announces may be there."""
    if not header.compressed:
        header.check_points()
    elif header.n_points:
        check_chunks(data, header)


def _decoded(file: BinaryIO, header: LasHeader, pick: Pick, n_points: int | None = None) -> Iterator[Cloud]:
    """The points in pieces of so many, or in one."""
    try:
        yield from _decode(file, header, pick, n_points)
    except UnreadableFileError:
        raise
    except BaseException as error:  # laspy and lazrs have no common class of errors
        if not isinstance(error, Exception) and type(error).__name__ != _PANIC:
            raise
        if isinstance(error, OSError) and error.errno is not None:  # of the disk, not of what is on it
            raise
        raise UnreadableFileError("file", "the points cannot be decoded: the file is damaged") from error


def _decode(file: BinaryIO, header: LasHeader, pick: Pick, n_points: int | None) -> Iterator[Cloud]:
    import laspy

    logging.getLogger("laspy").setLevel(logging.CRITICAL)  # what it complains about, it also raises
    backend, format = laspy.LazBackend.Lazrs, "laz" if header.compressed else "las"
    with laspy.open(file, read_evlrs=False, laz_backend=backend, closefd=False) as reader:
        dimensions = reader.header.point_format.dimensions
        names = [dimension.name if dimension.num_elements == 1 else "" for dimension in dimensions]
        columns = find_columns(names, pick)
        wanted = {i: names[i] for i in columns.wanted}
        # X is a whole number of steps; x is in the unit of the file.
        wanted |= {i: names[i].lower() for i in columns.points}
        n_read = 0
        for n_new, values in _values(reader, wanted, n_points):
            yield _in_its_unit(build_from(columns, values.__getitem__, format, n_read), header)
            n_read += n_new
    if n_read != header.n_points:
        raise UnreadableFileError(
            "file", f"the header announces {header.n_points} points, {n_read} are there"
        )


def _in_its_unit(cloud: Cloud, header: LasHeader) -> Cloud:
    unit, warning = unit_of(header.records)
    if warning:
        return replace(cloud, unit=None, unit_from=None, warnings=(*cloud.warnings, warning))
    return cloud if unit is None else replace(cloud, unit=unit, unit_from="header")


def _values(
    reader: Any, wanted: dict[int, str], n_points: int | None
) -> Iterator[tuple[int, dict[int, np.ndarray]]]:
    """How many points there are, and their dimensions of these names: piece by piece, or all at once."""
    pieces = (_piece(piece, wanted) for piece in reader.chunk_iterator(n_points or _PIECE))
    if n_points is not None:
        yield from ((len(next(iter(values.values()))), values) for values in pieces)
        return
    found = list(pieces)
    joined = {i: np.concatenate([values[i] for values in found] or [np.empty(0)]) for i in wanted}
    yield sum(len(next(iter(values.values()))) for values in found), joined


def _piece(piece: Any, wanted: dict[int, str]) -> dict[int, np.ndarray]:
    with np.errstate(over="ignore"):  # infinite coordinates are refused with all others
        return {i: np.array(piece[name]) for i, name in wanted.items()}
