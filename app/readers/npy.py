"""NPY arrays: (N, 3) or wider, or structured with fields x, y, z. Never a pickle."""

import io
import math
import warnings
from typing import Any

import numpy as np
from numpy.lib import format as npy_format

from app.readers.cloud import Cloud, build_cloud, count_columns, find_columns
from app.readers.errors import InvalidPointsError, UnreadableFileError
from app.readers.limits import UNLIMITED, Limits

_HEADER_LIMIT = 64 * 1024


def read_npy(data: memoryview, limits: Limits = UNLIMITED, labels: str | None = None) -> Cloud:
    """Read an NPY file whose header agrees with the bytes behind it."""
    shape, fortran, dtype, start = _header(data)
    names = dtype.names
    if names is None:
        _check_numeric(dtype, "dtype")
        if len(shape) != 2 or shape[-1] < 3:
            raise InvalidPointsError("shape", f"array of shape {_text(shape)}; points are (N, 3)")
        if shape[0] == 3 < shape[1]:
            raise InvalidPointsError(
                "shape", f"array of shape {_text(shape)}; points are (N, 3): transpose it"
            )
    elif len(shape) != 1:
        raise InvalidPointsError("shape", f"structured array of shape {_text(shape)}; points are (N,)")
    limits.check_points(shape[0])
    needed = math.prod(shape) * dtype.itemsize
    if needed != len(data) - start:
        raise UnreadableFileError(
            "file", f"the header announces {needed} bytes of data, {len(data) - start} are there"
        )
    array = np.frombuffer(data, dtype, offset=start).reshape(shape, order="F" if fortran else "C")
    if names is None:
        return build_cloud(_as_float(array[:, :3]), count_columns(shape[-1]), "npy")
    columns = find_columns(names)
    for index in columns.used:
        _check_numeric(dtype[index], names[index][:40])
    table = np.column_stack([_as_float(array[names[index]]) for index in columns.used])
    return build_cloud(table, columns.packed(), "npy")


def _header(data: memoryview) -> tuple[tuple[int, ...], bool, np.dtype[Any], int]:
    stream = io.BytesIO(data[: _HEADER_LIMIT + 12])
    try:
        version = npy_format.read_magic(stream)
        read = {1: npy_format.read_array_header_1_0, 2: npy_format.read_array_header_2_0}[version[0]]
        with warnings.catch_warnings(action="ignore"):  # headers written by Python 2
            shape, fortran, dtype = read(stream, max_header_size=_HEADER_LIMIT)
    except Exception as error:  # Python's own parser reads the header: it fails in many ways
        raise UnreadableFileError("file", "the NPY header cannot be read, or is over 64 KiB") from error
    if any(isinstance(side, bool) or side < 0 for side in shape):
        raise UnreadableFileError("shape", "the NPY header announces a negative length")
    if dtype.hasobject:
        raise UnreadableFileError("dtype", "an array of Python objects; only numbers are read, never pickles")
    return shape, fortran, dtype, stream.tell()


def _check_numeric(dtype: np.dtype[Any], field: str) -> None:
    if dtype.kind not in "fiu" or dtype.shape:
        raise InvalidPointsError(field, "the array must hold floats or integers", f"dtype kind {dtype.kind}")


def _as_float(array: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        return array.astype(np.float64)


def _text(shape: tuple[int, ...]) -> str:
    return f"({', '.join(f'{side:.6g}' if side > 10**9 else str(side) for side in shape[:6])})"
