"""CSV, XYZ, TXT, PTS and ASC: rows of numbers, with delimiter, header and comments found by looking."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cloud import Cloud, build_cloud, string_labels
from .errors import SHOWN, FieldError, InvalidPointsError, UnreadableFileError
from .limits import UNLIMITED, Limits
from .lines import COUNTED, ENDS_TAKEN, check_lines, counted, is_number, lines
from .tables import COMMENT, ROW, Layout, cells_of, look

_CUT = re.compile(rb"[;,\s]+")
# More than this is hardly one point: a scanner's row may hold coordinates, color, intensity, normal, time.
_MOST_IN_A_ROW = 20
_WHOLE = re.compile(r"[+-]?\d{1,18}(\.0*)?")
# What ends a file of old DOS programs.
_CTRL_Z = b"\x1a"


def read_text(data: memoryview, limits: Limits = UNLIMITED, labels: str | None = None) -> Cloud:
    """Read a text of one point a line; without a header `labels` is the number of a column, from 1."""
    check_lines(data)
    text = bytes(data).rstrip(_CTRL_Z)
    if b"\n" not in text:
        text = text.replace(b"\r", b"\n")
    if b"\0" in text:
        raise UnreadableFileError("file", "neither text nor a format that is known (CSV, XYZ, TXT, NPY, PLY)")
    _check_ends(text)
    limits.check_points(text.count(b"\n") // 2 - 1000)
    layout = look(text, labels)
    if layout.announced is not None:
        limits.check_points(layout.announced)
    cells: list[str] = []
    try:
        table = _load(text, layout, cells)
    except ValueError:
        raise _explain(text, layout) from None
    limits.check_points(len(table))
    if layout.announced not in (None, len(table)):
        message = f"the first line announces {layout.announced} points, {len(table)} follow"
        raise UnreadableFileError("line 1", message)
    found = None if layout.columns.label is None else _labels(cells)
    return build_cloud(table, layout.columns.packed(), "text", found)


def _check_ends(text: bytes) -> None:
    """Refuse a text of one line that holds the numbers of several points."""
    if b"\n" not in text.strip() and (n_values := len(_CUT.split(text))) > _MOST_IN_A_ROW:
        raise UnreadableFileError("file", f"the file holds one line, of {n_values} values; {ENDS_TAKEN}")


def _labels(cells: list[str]) -> NDArray[Any]:
    """Labels (N,): int64 where all of them are whole numbers, else strings."""
    if all(map(_WHOLE.fullmatch, set(cells))):
        return np.array([int(cell.partition(".")[0]) for cell in cells], np.int64)
    return string_labels(cells)


def _rows(text: bytes, layout: Layout) -> Iterator[tuple[int, str]]:
    """Line number and text of each row, without comments, blank lines and trailing delimiters."""
    tail = layout.delimiter or " "
    for number, line in lines(text, ROW):
        if number < layout.first_line:
            continue
        if "#" in line or "//" in line:
            line = COMMENT.split(line, maxsplit=1)[0]
        line = line.rstrip().rstrip(tail)
        if line:
            yield number, line


def _width(line: str, layout: Layout) -> int:
    if layout.delimiter is None:
        return len(line.split())
    return line.count(layout.delimiter) + 1


def _load(text: bytes, layout: Layout, labels: list[str]) -> np.ndarray:
    """The used columns as a table; ragged rows and words raise ValueError. Cells of labels go to `labels`."""
    quoted = b'"' in text
    label = layout.columns.label
    seen: dict[str, str] = {}  # labels repeat: each is kept once

    def even_rows() -> Iterator[str]:
        for _, line in _rows(text, layout):
            if not quoted and _width(line, layout) != layout.width:
                raise ValueError
            if label is not None:
                cells = cells_of(line, layout.delimiter)
                if len(cells) != layout.width:
                    raise ValueError
                cell = cells[label]
                labels.append(seen.setdefault(cell, cell))
            yield line.replace(",", ".") if layout.decimal_comma else line

    return np.loadtxt(
        even_rows(),
        np.float64,
        comments=None,
        delimiter=layout.delimiter,
        usecols=layout.columns.used,
        ndmin=2,
        quotechar='"' if quoted else None,
    )


def _explain(text: bytes, layout: Layout) -> UnreadableFileError:
    """Which rows are ragged or hold words: the first of them by line, and how many there are."""
    errors: list[FieldError] = []
    n_bad = 0
    for number, line in _rows(text, layout):
        cells = cells_of(line, layout.delimiter)
        if layout.decimal_comma:
            cells = [cell.replace(",", ".") for cell in cells]
        if len(cells) != layout.width:
            message = f"the row holds {len(cells)} values, the first row {layout.width}"
            bad = [FieldError(f"line {number}", message)]
        else:
            bad = [
                FieldError(f"line {number}, column {index + 1}", "not a number", _describe(cells[index]))
                for index in layout.columns.used
                if not is_number(cells[index])
            ]
        n_bad += bool(bad)
        errors += bad[: SHOWN - len(errors)]
        if n_bad == COUNTED:
            break
    if not errors:
        return UnreadableFileError("file", "the rows are not numbers cut by one delimiter")
    return InvalidPointsError(
        errors[0].field, f"{counted(n_bad)} rows are not {layout.width} numbers", errors=errors
    )


def _describe(cell: str) -> str:
    return f"string of {len(cell)} characters" if cell else "empty"
