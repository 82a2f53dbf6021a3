"""NPY arrays: (N, 3) or wider, organized (H, W, 3), or structured with fields x, y, z. Never a pickle."""

import io
import math
import warnings
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.lib import format as npy_format

from .cloud import Cloud, build_from, check_numbers
from .columns import FOUND, Pick, find_columns
from .errors import InvalidPointsError, UnreadableFileError
from .limits import UNLIMITED, Limits
from .unnamed import check_first, number_columns

HEADER_LIMIT = 10_000
"""Bytes; NumPy reads no longer ones by default, since Python's parser takes milliseconds for them."""

# Of the arrays whose rows are points, hardly one has more columns.
_MOST_COLUMNS = 16
SHORT = 256
"""Bytes of a header that is kept in mind; NumPy writes 128 for an array (N, 3)."""


@dataclass(frozen=True)
class ArrayHeader:
    """What an NPY header announces, and where the data behind it start."""

    shape: tuple[int, ...]
    fortran: bool
    dtype: np.dtype[Any]
    start: int

    @property
    def end(self) -> int:
        """Bytes of the whole file, if the header is right."""
        return self.start + math.prod(self.shape) * self.dtype.itemsize

    def check(self, limits: Limits) -> None:
        """Raise unless it announces numbers, and no more of them than points may be read."""
        if self.dtype.hasobject:
            message = "an array of Python objects; only numbers are read, never pickles"
            raise UnreadableFileError("dtype", message)
        if not self.dtype.itemsize:
            raise UnreadableFileError("dtype", "elements of no bytes; points are floats or integers")
        limits.check_points(math.prod(self.shape[:-1] or self.shape))

    def check_points(self) -> None:
        """Raise unless points may have this shape: (N, 3), wider, or (N,) records; or organized ones."""
        if self.dtype.names is not None:
            if len(self.shape) not in (1, 2):
                raise self._misshapen("structured array", "(N,), or organized (H, W)")
        elif len(self.shape) not in (2, 3) or self.shape[-1] < 3:
            raise self._misshapen("array", "(N, 3), or organized (H, W, 3)")
        elif is_transposed(self.shape):
            wanted = "(N, 3)" if len(self.shape) == 2 else "(H, W, 3)"
            raise self._misshapen("array", f"{wanted}: transpose it")

    def _misshapen(self, what: str, wanted: str) -> InvalidPointsError:
        return InvalidPointsError("shape", f"{what} of shape {as_text(self.shape)}; points are {wanted}")


def is_transposed(shape: tuple[int, ...]) -> bool:
    """Whether the first axis of an array (N, C) or (H, W, C) may be that of the coordinates.

    So is (3, N), and with a few long rows (4, N) and (3, H, W).
    """
    return (len(shape) == 2 and shape[0] == 3 < shape[1]) or 2 < shape[0] <= _MOST_COLUMNS < shape[-1]


def read_npy(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read an NPY file whose header agrees with the bytes behind it."""
    header = read_header(data)
    header.check_points()
    header.check(limits)
    array = read_array(data, header)
    if header.dtype.names is not None:
        return read_records(array, "npy", pick)
    return read_table(array, "npy", pick)


def read_header(data: memoryview) -> ArrayHeader:
    """Read the header of an NPY file, of which the first `HEADER_LIMIT + 12` bytes are enough."""
    end = 10 + int.from_bytes(data[8:10], "little")
    usual = bytes(data[6:7]) == b"\x01" and end <= SHORT
    return _usual_header(bytes(data[:end])) if usual else _parse_header(bytes(data[: HEADER_LIMIT + 12]))


@lru_cache(maxsize=64)
def _usual_header(start: bytes) -> ArrayHeader:
    """That of clouds of one size, which a client sends again and again: Python's parser takes a while."""
    return _parse_header(start)


def _parse_header(start: bytes) -> ArrayHeader:
    stream = io.BytesIO(start)
    try:
        version = npy_format.read_magic(stream)
        read = {1: npy_format.read_array_header_1_0, 2: npy_format.read_array_header_2_0}[version[0]]
        with warnings.catch_warnings(action="ignore"):  # headers written by Python 2
            shape, fortran, dtype = read(stream, max_header_size=HEADER_LIMIT)
    except Exception as error:  # Python's own parser reads the header: it fails in many ways
        raise UnreadableFileError(
            "file", f"the NPY header cannot be read, or is over {HEADER_LIMIT} bytes"
        ) from error
    if any(isinstance(side, bool) or side < 0 for side in shape):
        raise UnreadableFileError("shape", "the NPY header announces a negative length")
    return ArrayHeader(shape, fortran, dtype, stream.tell())


def read_array(data: memoryview, header: ArrayHeader) -> np.ndarray:
    """The array behind a checked header, as a view; exactly the bytes announced must be there."""
    if header.end != len(data):
        needed, there = header.end - header.start, len(data) - header.start
        raise UnreadableFileError("file", f"the header announces {needed} bytes of data, {there} are there")
    array = np.frombuffer(data, header.dtype, offset=header.start)
    return array.reshape(header.shape, order="F" if header.fortran else "C")


def read_records(array: np.ndarray, format: str, pick: Pick) -> Cloud:
    """The cloud of a structured array (N,), or of an organized one (H, W), its fields found by name."""
    names = array.dtype.names or ()
    array = array.reshape(-1)
    return build_from(find_columns(names, pick), lambda i: array[names[i]], format)


def read_table(array: np.ndarray, format: str, pick: Pick) -> Cloud:
    """The cloud of an array (N, C), or of an organized one (H, W, C), whose columns have numbers from 1."""
    check_numbers(array.dtype, "dtype")
    table = array.reshape(-1, array.shape[-1])
    width = table.shape[1]
    columns = number_columns(width, pick, table)
    if pick.columns is None:
        check_first(table[:, 0], width, columns)
    return build_from(columns, lambda i: table[:, i], format)


def as_text(shape: tuple[int, ...]) -> str:
    """A shape for a message, however long it claims to be."""
    return f"({', '.join(f'{side:.6g}' if side > 10**9 else str(side) for side in shape[:6])})"
