"""Tables of nothing but numbers, spelled as JSON spells them: most large texts, read three times as fast."""

import re

import numpy as np
import orjson
from numpy.typing import NDArray

from .cloud import Array
from .lines import BOM, pieces
from .tables import Layout

_SPELLED = b"0123456789+-.eE \n"
_COMMENTS = re.compile(rb"(?:[^\S\n]*+(?:(?:#|//|[%!])[^\n]*+)?\n)*+")
# Longer whole numbers are no labels.
_LABELS_BELOW = 10**18

Labels = NDArray[np.int64]
Rows = list[list[float]]


def load_plain(text: bytes, layout: Layout) -> tuple[Array, Labels | None] | None:
    """The columns that are read, (N, len(layout.read)), and the labels (N,) where a column of them is used.

    None where the rows hold anything else: words, quotes, comments, empty cells, labels that are not whole,
    or more cells here than there. `app.readers.text` reads these.
    """
    if layout.ragged or layout.decimal_comma or text.count(b"\r") != text.count(b"\r\n"):
        return None
    tables: list[Array] = []
    labels: list[int] = []
    for piece in pieces(text, _begin(text, layout.first_line)):
        if piece := piece.replace(b"\r\n", b"\n").strip(b"\n"):
            try:
                rows = _rows(piece, layout.delimiter)
                tables.append(_table(rows, layout))
                labels += _labels(rows, layout)
            except ValueError:
                return None
    if not tables:
        return None
    return np.concatenate(tables), None if layout.columns.label is None else np.array(labels, np.int64)


def _begin(text: bytes, first_line: int) -> int:
    """Where the rows begin: behind the lines before the first one, and the comments that follow these."""
    start = len(BOM) if text.startswith(BOM) else 0
    for _ in range(1, first_line):
        start = text.find(b"\n", start) + 1
    comments = _COMMENTS.match(text, start)
    return comments.end() if comments else start


def _rows(piece: bytes, delimiter: str | None) -> Rows:
    """The numbers of each row; raises ValueError where there is anything but numbers."""
    if delimiter is None:
        piece, delimiter = b"\n".join(b",".join(line.split()) for line in piece.split(b"\n")), ","
    if piece.translate(None, _SPELLED + delimiter.encode()):
        raise ValueError
    rows: Rows = orjson.loads(b"[[%b]]" % piece.replace(delimiter.encode(), b",").replace(b"\n", b"],["))
    return rows


def _table(rows: Rows, layout: Layout) -> Array:
    """The columns that are read; raises ValueError where the rows are not as wide as those of the layout."""
    table = np.array(rows, np.float64)
    if table.shape != (len(rows), layout.width):
        raise ValueError
    return table[:, layout.read]


def _labels(rows: Rows, layout: Layout) -> list[int]:
    """The labels, where a column of them is used; raises ValueError where one is not whole."""
    label = layout.columns.label
    cells = [] if label is None else [row[label] for row in rows]
    labels = [cell for cell in cells if isinstance(cell, int) and abs(cell) < _LABELS_BELOW]
    if len(labels) < len(cells):
        raise ValueError
    return labels
