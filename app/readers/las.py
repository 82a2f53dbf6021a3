"""LAS and LAZ, versions 1.0 to 1.4: scaled coordinates in float64, decoded by laspy and lazrs.

Points are decoded piece by piece, so that a count costs nothing until its points are there.
"""

import io
import logging
from dataclasses import replace
from typing import Any

import numpy as np

from .cloud import Cloud, build_from
from .columns import FOUND, Pick, find_columns
from .errors import UnreadableFileError
from .las_header import LasHeader, read_header
from .las_unit import unit_of
from .laz_chunks import check_chunks
from .limits import UNLIMITED, Limits

_PIECE = 50_000
_PANIC = "PanicException"
"""What a fault within lazrs, which is written in Rust, raises: not an `Exception`, and nothing to import."""


def read_las(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read a LAS or LAZ file; any dimension of one number a point may be the labels."""
    header = read_header(data)
    limits.check_points(header.n_points)
    if header.compressed and header.n_points:
        limits.check_unpacked(header.n_points * header.point_size, header.end - header.start)
        check_chunks(data, header)
    elif not header.compressed:
        header.check_points()
    try:
        return _decode(data, header, pick)
    except UnreadableFileError:
        raise
    except BaseException as error:  # laspy and lazrs have no common class of errors
        if not isinstance(error, Exception) and type(error).__name__ != _PANIC:
            raise
        raise UnreadableFileError("file", "the points cannot be decoded: the file is damaged") from error


def _decode(data: memoryview, header: LasHeader, pick: Pick) -> Cloud:
    import laspy

    logging.getLogger("laspy").setLevel(logging.CRITICAL)  # what it complains about, it also raises
    with laspy.open(io.BytesIO(data), read_evlrs=False, laz_backend=laspy.LazBackend.Lazrs) as reader:
        dimensions = reader.header.point_format.dimensions
        names = [dimension.name if dimension.num_elements == 1 else "" for dimension in dimensions]
        columns = find_columns(names, pick)
        wanted = {i: names[i] for i in columns.wanted}
        # X is a whole number of steps; x is in the unit of the file.
        wanted |= {i: names[i].lower() for i in columns.points}
        n_read, values = _values(reader, wanted)
    if n_read != header.n_points:
        raise UnreadableFileError(
            "file", f"the header announces {header.n_points} points, {n_read} are there"
        )
    format = "laz" if header.compressed else "las"
    return _in_its_unit(build_from(columns, values.__getitem__, format), header)


def _in_its_unit(cloud: Cloud, header: LasHeader) -> Cloud:
    unit, warning = unit_of(header.records)
    if warning:
        return replace(cloud, unit=None, unit_from=None, warnings=(*cloud.warnings, warning))
    return cloud if unit is None else replace(cloud, unit=unit, unit_from="header")


def _values(reader: Any, wanted: dict[int, str]) -> tuple[int, dict[int, np.ndarray]]:
    """How many points are there, and their dimensions of these names."""
    parts: dict[int, list[np.ndarray]] = {i: [] for i in wanted}
    n_read = 0
    for piece in reader.chunk_iterator(_PIECE):
        n_read += len(piece)
        with np.errstate(over="ignore"):  # infinite coordinates are refused with all others
            for i, name in wanted.items():
                parts[i].append(np.array(piece[name]))
    return n_read, {i: np.concatenate(pieces or [np.empty(0)]) for i, pieces in parts.items()}
