"""CSV, XYZ, TXT, PTS and ASC: rows of numbers, with delimiter, header and comments found by looking."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cloud import Array, Cloud, build_cloud, string_labels
from .columns import FOUND, Pick
from .errors import SHOWN, FieldError, InvalidPointsError, UnreadableFileError
from .formats import NAMES
from .limits import UNLIMITED, Limits
from .lines import COUNTED, cells_of, check_lines, counted, is_number, lines, plain_numbers, runs_on
from .plain import load_plain
from .tables import COMMENT, ROW, Layout, look
from .unnamed import check_first

_WHOLE = re.compile(r"[+-]?\d{1,18}(\.0*)?")
# What ends a file of old DOS programs, and the lines behind it.
_END, _TAIL = b"\x1a\r\n", 64
_BLANK = " \t\r\f\v"
_SIGNS = ("%", "!")


def read_text(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read a text of one point a line; without a header columns are known by their numbers, from 1."""
    check_lines(data)
    text = plain_numbers(_without_end(data))
    if b"\n" not in text:
        text = text.replace(b"\r", b"\n")
    if b"\0" in text:
        raise UnreadableFileError("file", f"neither text nor another format that is read: {NAMES}")
    limits.check_points(text.count(b"\n") // 2 - 1000)
    layout = look(text, pick)
    scans: list[_Scan] = []
    table, labels = load_plain(text, layout) or _load_any(text, layout, scans)
    if layout.announced is not None and not scans:
        scans.append(_Scan(layout.announced, len(table)))
    limits.check_points(len(table))
    if layout.by_place:
        check_first(table[:, 0], layout.width, layout.columns)
        table = table[:, len(layout.read) - len(layout.columns.used) :]
    cloud = build_cloud(table, layout.columns.packed(), "text", labels)
    return replace(cloud, warnings=cloud.warnings + _wrong_counts(scans))


def _without_end(data: memoryview) -> bytes:
    """The text but for what ends an old file, in one copy."""
    tail = bytes(data[-_TAIL:])
    return bytes(data[: len(data) - len(tail) + len(tail.rstrip(_END))])


@dataclass
class _Scan:
    """A scan of a PTS file: how many points its count line announces, and how many follow."""

    announced: int
    n_points: int = 0


def _is_count(line: str, layout: Layout) -> bool:
    """Whether a line of a PTS file tells how many points the next scan has."""
    return layout.announced is not None and re.fullmatch(r"\d{1,18}", line) is not None


def _wrong_counts(scans: Sequence[_Scan]) -> tuple[str, ...]:
    wrong = [scan for scan in scans if scan.announced != scan.n_points]
    if not wrong:
        return ()
    where = "The first line" if len(scans) == 1 else f"{len(wrong)} of {len(scans)} counts are wrong: one"
    return (f"{where} announces {wrong[0].announced} points, {wrong[0].n_points} follow; all are read.",)


def _labels(cells: list[str]) -> NDArray[Any]:
    """Labels (N,): int64 where all of them are whole numbers, else strings."""
    if all(map(_WHOLE.fullmatch, set(cells))):
        return np.array([int(cell.partition(".")[0]) for cell in cells], np.int64)
    return string_labels(cells)


def _rows(text: bytes, layout: Layout) -> Iterator[tuple[int, str]]:
    """Line number and text of each row, without comments, blank lines and delimiters behind the last cell."""
    blank = _BLANK.replace(layout.delimiter or " ", "")
    for number, line in lines(text, ROW):
        if number < layout.first_line:
            continue
        if "#" in line or "//" in line or line.lstrip()[:1] in _SIGNS:
            line = COMMENT.split(line, maxsplit=1)[0]
        line = line.lstrip(" ").rstrip(blank) if layout.delimiter else line.rstrip()
        while layout.delimiter and line.endswith(layout.delimiter) and _width(line, layout) > layout.width:
            line = line[:-1].rstrip(blank)
        if line.strip():
            yield number, line


def _width(line: str, layout: Layout) -> int:
    if layout.delimiter is None:
        return len(line.split())
    return line.count(layout.delimiter) + 1


def _load_any(text: bytes, layout: Layout, scans: list[_Scan]) -> tuple[Array, NDArray[Any] | None]:
    """The same of any table; raises `UnreadableFileError` naming rows that hold no points."""
    cells: list[str] = []
    try:
        table = _load(text, layout, cells, scans)
    except ValueError:
        raise _explain(text, layout) from None
    return table, None if layout.columns.label is None else _labels(cells)


def _load(text: bytes, layout: Layout, labels: list[str], scans: list[_Scan]) -> Array:
    """The used columns as a table; ragged rows and words raise ValueError.

    Cells of labels go to `labels`, and what the count lines of a PTS file tell to `scans`.
    """
    quoted = b'"' in text
    label = layout.columns.label
    cut = layout.delimiter and re.escape(layout.delimiter)
    empty = re.compile(rf"(?:^|{cut})[ ]*(?:{cut}|$)") if cut else None
    seen: dict[str, str] = {}  # labels repeat: each is kept once

    def even_rows() -> Iterator[str]:
        for line in _without_counts(text, layout, scans):
            if not quoted and not layout.holds(_width(line, layout)):
                raise ValueError
            if quoted and '"' in line and runs_on(line, layout.delimiter):
                raise ValueError
            if label is not None:
                cells = cells_of(line, layout.delimiter)
                if not layout.holds(len(cells)):
                    raise ValueError
                cell = cells[label]
                labels.append(seen.setdefault(cell, cell))
            if layout.decimal_comma and "." in line and _has_point(cells_of(line, layout.delimiter), layout):
                raise ValueError
            if empty is not None and not quoted and empty.search(line):
                line = _filled(line, layout.delimiter)
            yield line.replace(",", ".") if layout.decimal_comma else line

    return np.loadtxt(
        even_rows(),
        np.float64,
        comments=None,
        delimiter=layout.delimiter,
        usecols=layout.read,
        ndmin=2,
        quotechar='"' if quoted else None,
    )


def _has_point(cells: Sequence[str], layout: Layout) -> bool:
    """Whether a number that is read has a point, which beside decimal commas means thousands."""
    return any("." in cells[i] for i in layout.read if i < len(cells))


def _filled(line: str, delimiter: str | None) -> str:
    """The row with NaN for its empty cells, as tables have them where a value is missing."""
    return (delimiter or " ").join(cell if cell.strip() else "nan" for cell in line.split(delimiter))


def _without_counts(text: bytes, layout: Layout, scans: list[_Scan]) -> Iterator[str]:
    """The rows of a text; the count lines of a PTS file begin `scans`, and its rows are counted there."""
    if layout.announced is None:
        yield from (line for _, line in _rows(text, layout))
        return
    scans.append(_Scan(layout.announced))
    for _, line in _rows(text, layout):
        if _is_count(line, layout):
            scans.append(_Scan(int(line)))
        else:
            scans[-1].n_points += 1
            yield line


def _explain(text: bytes, layout: Layout) -> UnreadableFileError:
    """Which rows are ragged or hold words: the first of them by line, and how many there are."""
    errors: list[FieldError] = []
    n_bad = 0
    for number, line in _rows(text, layout):
        if _is_count(line, layout):
            continue
        cells = cells_of(line, layout.delimiter)
        if layout.decimal_comma:
            # A point between digits is no decimal one here, and so no number.
            cells = [cell.replace(".", "'").replace(",", ".") for cell in cells]
        if '"' in line and runs_on(line, layout.delimiter):
            bad = [FieldError(f"line {number}", "a cell begins with a quote that does not end in the row")]
        elif not layout.holds(len(cells)):
            message = f"the row holds {len(cells)} values, the first row {layout.width}"
            bad = [FieldError(f"line {number}", message)]
        else:
            bad = [
                FieldError(f"line {number}, column {index + 1}", "not a number", _describe(cells[index]))
                for index in layout.read
                if cells[index] and not is_number(cells[index])
            ]
        n_bad += bool(bad)
        errors += bad[: SHOWN - len(errors)]
        if n_bad == COUNTED:
            break
    if not errors:
        return UnreadableFileError("file", "the rows are not numbers with one delimiter between them")
    return InvalidPointsError(
        errors[0].field, f"{counted(n_bad)} rows are not {layout.width} numbers", errors=errors
    )


def _describe(cell: str) -> str:
    return f"string of {len(cell)} characters" if cell else "empty"
