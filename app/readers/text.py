"""CSV, XYZ, TXT, PTS and ASC: rows of numbers, with delimiter, header and comments found by looking."""

import csv
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cloud import (
    AUTO_LABELS,
    Cloud,
    Columns,
    build_cloud,
    canonical,
    count_columns,
    find_columns,
    find_label,
    string_labels,
)
from .errors import SHOWN, FieldError, InvalidPointsError, UnreadableFileError
from .limits import UNLIMITED, Limits
from .lines import COUNTED, check_lines, counted, decoded, is_number, lines

_SAMPLE = 20
_HEAD = 1024 * 1024
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_COMMENT = re.compile("#|//")
# A line that holds more than white space and a comment.
_ROW = re.compile(r"^[^\S\n]*+(?!#|//)\S.*", re.MULTILINE)
_WHOLE = re.compile(r"[+-]?\d{1,18}(\.0*)?")
_DELIMITER_NAMES = {",": "comma", ";": "semicolon", "\t": "tab", None: "white space"}


@dataclass(frozen=True)
class _Layout:
    """How a text is written: delimiter (None: white space), line of the first row, its width, columns.

    `announced` is the number of rows that a PTS file tells on its first line.
    """

    delimiter: str | None
    first_line: int
    width: int
    columns: Columns
    announced: int | None = None


def read_text(data: memoryview, limits: Limits = UNLIMITED, labels: str | None = None) -> Cloud:
    """Read a text of one point a line; without a header `labels` is the number of a column, from 1."""
    check_lines(data)
    text = bytes(data)
    if b"\n" not in text:
        text = text.replace(b"\r", b"\n")
    if b"\0" in text:
        raise UnreadableFileError("file", "neither text nor a format that is known (CSV, XYZ, TXT, NPY, PLY)")
    limits.check_points(text.count(b"\n") // 2 - 1000)
    layout = _look(text, labels)
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


def _labels(cells: list[str]) -> NDArray[Any]:
    """Labels (N,): int64 where all of them are whole numbers, else strings."""
    if all(map(_WHOLE.fullmatch, set(cells))):
        return np.array([int(cell.partition(".")[0]) for cell in cells], np.int64)
    return string_labels(cells)


def _look(text: bytes, labels: str | None) -> _Layout:
    """Delimiter, header and columns from the first lines."""
    whole = len(text) <= _HEAD
    head = decoded(text if whole else text[: text.rfind(b"\n", 0, _HEAD)])
    sample = _sample(head, whole)
    announced = _announced(sample)
    if announced is not None:
        del sample[0]
    delimiter = _delimiter([line for _, line in sample])
    names = _header(sample, delimiter)
    first_line, first = sample[0 if names is None else 1]
    width = len(_cells(first, delimiter))
    if names is None:
        names = _commented_header(_last_comment(head), delimiter, width)
    if names is None:
        _refuse_decimal_comma_pairs([line for _, line in sample], delimiter)
        columns = _count_columns(width, labels)
    elif len(names) != width:
        raise UnreadableFileError(
            "header", f"the header names {len(names)} columns, line {first_line} holds {width}"
        )
    else:
        columns = find_columns(names, labels)
    return _Layout(delimiter, first_line, width, columns, announced)


def _sample(head: str, whole: bool) -> list[tuple[int, str]]:
    """Line number and text of the first rows, without comments; `whole` says that `head` is all there is."""
    sample = [
        (1 + head.count("\n", 0, row.start()), _COMMENT.split(row[0], maxsplit=1)[0].strip())
        for row in islice(_ROW.finditer(head), _SAMPLE)
    ]
    if not sample:
        where = "file holds" if whole else "first MiB holds"
        raise InvalidPointsError("file", f"the {where} no points")
    if re.match(r"(?i)(ncols|nrows)\s", sample[0][1]):
        raise UnreadableFileError("file", "an ESRI grid of heights is not a list of points; export it as XYZ")
    return sample


def _header(sample: list[tuple[int, str]], delimiter: str | None) -> list[str] | None:
    """The names in the first row; None where it holds numbers."""
    cells = _cells(sample[0][1], delimiter)
    if any(is_number(cell) for cell in cells):
        return None
    if len(sample) == 1:
        raise InvalidPointsError("file", "the file holds no rows of numbers")
    return cells


def _last_comment(head: str) -> str:
    """The last line that says something before the first row; empty where there is none."""
    row = _ROW.search(head)
    before = head[: row.start()] if row else head
    return before.rstrip().rpartition("\n")[2].strip()


def _announced(sample: list[tuple[int, str]]) -> int | None:
    """The number of points that the first line of a PTS file tells: a bare one, before rows of several."""
    if len(sample) > 1 and re.fullmatch(r"\d{1,18}", sample[0][1]) and len(sample[1][1].split()) >= 3:
        return int(sample[0][1])
    return None


def _count_columns(width: int, labels: str | None) -> Columns:
    """Columns of a table without names, where a number from 1 is the name of each."""
    columns = count_columns(width)
    if labels in (None, AUTO_LABELS):
        return columns
    label = find_label([str(number) for number in range(1, width + 1)], labels)
    return replace(columns, label=label, label_name=labels)


def _delimiter(lines: list[str]) -> str | None:
    """Semicolon, tab, comma or white space, whichever the first lines are cut by."""
    body = lines[1:] or lines
    for delimiter in (";", "\t"):
        if all(delimiter in line for line in body):
            return _checked(delimiter, body)
    if any(len(cells) >= 2 and _n_decimal_commas(cells) == len(cells) for cells in map(str.split, body)):
        raise _decimal_comma(None)
    return "," if any("," in line for line in body) else None


def _checked(delimiter: str, body: list[str]) -> str:
    """The delimiter, unless numbers between it use a decimal comma."""
    if any(_n_decimal_commas(_cells(line, delimiter)) for line in body):
        raise _decimal_comma(delimiter)
    return delimiter


def _n_decimal_commas(cells: list[str]) -> int:
    """How many cells are numbers with a decimal comma."""
    return sum(_DECIMAL_COMMA.fullmatch(cell) is not None for cell in cells)


def _decimal_comma(delimiter: str | None) -> UnreadableFileError:
    name = _DELIMITER_NAMES[delimiter]
    return UnreadableFileError(
        "file", f"columns are cut by {name} and numbers use a decimal comma; write a decimal point"
    )


def _refuse_decimal_comma_pairs(lines: list[str], delimiter: str | None) -> None:
    """Six bare integers a row without a header may be three numbers with decimal commas: nobody can tell."""
    if delimiter == "," and all(re.fullmatch(r"[+-]?\d+(\s*,\s*[+-]?\d+){5}", line) for line in lines):
        raise UnreadableFileError(
            "file",
            "rows hold six integers: either six columns, or three numbers with decimal commas; "
            "name the columns in a header line, or write a decimal point",
        )


def _commented_header(comment: str, delimiter: str | None, width: int) -> list[str] | None:
    """Names in the last comment before the rows, as `# x y z` and `//X Y Z`."""
    bare = comment.lstrip("/# ")
    for names in (_cells(bare, delimiter), bare.split()):
        if len(names) == width and {"x", "y", "z"} <= {canonical(name) for name in names}:
            return names
    return None


def _cells(line: str, delimiter: str | None) -> list[str]:
    """The cells of a row; one in quotes may hold the delimiter, unless that is white space."""
    if delimiter is not None:
        line = line.rstrip().rstrip(delimiter)
    if delimiter is None or '"' not in line:
        cells = line.split(delimiter)
    else:
        cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [cell.strip().strip('"').strip() for cell in cells]


def _rows(text: bytes, layout: _Layout) -> Iterator[tuple[int, str]]:
    """Line number and text of each row, without comments, blank lines and trailing delimiters."""
    tail = layout.delimiter or " "
    for number, line in lines(text, _ROW):
        if number < layout.first_line:
            continue
        if "#" in line or "//" in line:
            line = _COMMENT.split(line, maxsplit=1)[0]
        line = line.rstrip().rstrip(tail)
        if line:
            yield number, line


def _width(line: str, layout: _Layout) -> int:
    if layout.delimiter is None:
        return len(line.split())
    return line.count(layout.delimiter) + 1


def _load(text: bytes, layout: _Layout, labels: list[str]) -> np.ndarray:
    """The used columns as a table; ragged rows and words raise ValueError. Cells of labels go to `labels`."""
    quoted = b'"' in text
    label = layout.columns.label
    seen: dict[str, str] = {}  # labels repeat: each is kept once

    def even_rows() -> Iterator[str]:
        for _, line in _rows(text, layout):
            if not quoted and _width(line, layout) != layout.width:
                raise ValueError
            if label is not None:
                cells = _cells(line, layout.delimiter)
                if len(cells) != layout.width:
                    raise ValueError
                cell = cells[label]
                labels.append(seen.setdefault(cell, cell))
            yield line

    return np.loadtxt(
        even_rows(),
        np.float64,
        comments=None,
        delimiter=layout.delimiter,
        usecols=layout.columns.used,
        ndmin=2,
        quotechar='"' if quoted else None,
    )


def _explain(text: bytes, layout: _Layout) -> UnreadableFileError:
    """Which rows are ragged or hold words: the first of them by line, and how many there are."""
    errors: list[FieldError] = []
    n_bad = 0
    for number, line in _rows(text, layout):
        cells = _cells(line, layout.delimiter)
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
