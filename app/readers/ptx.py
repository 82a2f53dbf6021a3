"""PTX, gridded scans as Leica Cyclone writes them: the points of all scans, each moved by its pose.

A scan has ten lines of head and one row for each place of its grid. The head tells the numbers of columns and
rows, the scanner's position and axes, and a matrix (4, 4) that a point [x y z 1], as a row, is multiplied by.
Where nothing came back the row is 0 0 0.
"""

import re
from collections.abc import Iterator
from dataclasses import replace
from io import BytesIO, TextIOWrapper
from itertools import chain, islice

import numpy as np

from .cloud import Array, Cloud, build_cloud
from .columns import FOUND, XYZ, Pick, check_no_columns
from .errors import InvalidPointsError, TooLargeError, UnreadableFileError
from .limits import UNLIMITED, Limits
from .lines import check_lines, decoded, is_number, plain_numbers
from .rows import check_bytes

_LOOKED_AT = 4 * 1024
# A scan is one position of the scanner, which is moved by hand.
_MOST_SCANS = 1000
# How many numbers each line of a head holds.
_WIDTHS = (1, 1, 3, 3, 3, 3, 4, 4, 4, 4)
_COUNT = re.compile(r"\d{1,9}")
_ROW_BYTES = len("0 0 0\n")

Lines = Iterator[tuple[int, str]]


def is_ptx(data: memoryview) -> bool:
    """Whether the first lines are the head of a scan."""
    return _is_head([line for line in decoded(bytes(data[:_LOOKED_AT])).split("\n") if line.strip()][:10])


def read_ptx(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read the points of all scans in the frame of the file, without those that are missing.

    A last scan that is cut off is read as far as its lines are whole, with a warning. Any other scan that is
    not as long as its head announces is refused.
    """
    check_no_columns(pick, "a PTX file")
    check_lines(data)
    text = plain_numbers(bytes(data))
    lines = enumerate(TextIOWrapper(BytesIO(text), "latin-1"), 1)
    told = ((number, line) for number, line in lines if line.strip())
    cut = None if text.endswith((b"\n", b"\r")) else 1 + (text.count(b"\n") or text.count(b"\r"))
    parts: list[Array] = []
    warnings, announced, n_zero = [], 0, 0
    while (scan := _head(told, len(parts) + 1)) is not None:
        n_points, matrix = scan
        if len(parts) == _MOST_SCANS:
            raise TooLargeError("file", f"the PTX file has more than {_MOST_SCANS} scans, the limit")
        announced += n_points
        limits.check_points(announced)
        check_bytes(_ROW_BYTES * n_points - 1, len(text), n_points)
        points = _rows(told, n_points, len(parts) + 1, cut)
        if len(points) < n_points:
            there = f"{len(points)} whole rows follow; they are read."
            warnings.append(f"The file ends early: its last scan announces {n_points} points, {there}")
        measured = points[points.any(axis=1)]
        n_zero += len(points) - len(measured)
        with np.errstate(invalid="ignore", over="ignore"):
            parts.append(measured @ matrix[:3, :3] + matrix[3, :3])
    if not sum(map(len, parts)):
        raise InvalidPointsError("file", f"no points were measured: all {n_zero} rows of the scans are 0 0 0")
    cloud = build_cloud(np.concatenate(parts), XYZ, "ptx")
    return replace(cloud, dropped={"zero": n_zero}, warnings=tuple(warnings))


def _is_head(lines: list[str]) -> bool:
    words = [line.split() for line in lines]
    if tuple(map(len, words)) != _WIDTHS or not all(_COUNT.fullmatch(line[0]) for line in words[:2]):
        return False
    return all(is_number(word) for line in words for word in line)


def _head(told: Lines, scan: int) -> tuple[int, Array] | None:
    """How many points a scan announces, and the matrix that moves them; None at the end of the file."""
    head = list(islice(told, len(_WIDTHS)))
    if not head:
        return None
    field, lines = f"line {head[0][0]}", [line for _, line in head]
    if not _is_head(lines):
        message = (
            f"the head of scan {scan} should begin here: the numbers of columns and rows, and eight lines"
        )
        raise UnreadableFileError(field, message)
    matrix = np.array([line.split() for line in lines[6:]], np.float64)
    if not np.isfinite(matrix).all() or not np.allclose(matrix[:, 3], [0.0, 0.0, 0.0, 1.0], atol=1e-6):
        message = f"the matrix of scan {scan} moves no points that are rows: its last column is not 0 0 0 1"
        raise UnreadableFileError(f"line {head[6][0]}", message)
    return int(lines[0].split()[0]) * int(lines[1].split()[0]), matrix


def _rows(told: Lines, n_points: int, scan: int, cut: int | None) -> Array:
    """The coordinates (N, 3) of a scan, fewer than announced where the file ends early.

    `cut` is the number of a last line that has no end: it is read only if it is the last row announced.
    """

    def rows() -> Iterator[str]:
        for n_read, (number, line) in enumerate(islice(told, n_points)):
            is_row = len(line.split(None, 2)) == 3
            if number == cut and not (is_row and n_read + 1 == n_points):
                return
            if not is_row:
                message = f"scan {scan} announces {n_points} points, {n_read} follow"
                raise UnreadableFileError(f"line {number}", message)
            yield line

    lines = rows()
    if (first := next(lines, None)) is None:
        return np.empty((0, 3))
    try:
        return np.loadtxt(chain([first], lines), np.float64, comments=None, usecols=(0, 1, 2), ndmin=2)
    except UnreadableFileError:
        raise
    except ValueError:
        message = f"a row of scan {scan} does not begin with three numbers"
        raise UnreadableFileError("file", message) from None
