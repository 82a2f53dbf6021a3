"""The lines of a text, none of them endless, and the numbers in them."""

import csv
import re
from collections.abc import Callable, Iterator
from itertools import islice

import numpy as np

from .cloud import Array
from .errors import SHOWN, FieldError, InvalidPointsError, UnreadableFileError

_LINE_LIMIT = 64 * 1024
_PIECE = 4 * _LINE_LIMIT
# Bad rows are counted this far: to count millions takes seconds.
COUNTED = 10_000
ENDS_TAKEN = "curl -d takes the line ends out of a file: use --data-binary"
BOM = b"\xef\xbb\xbf"
_HEAD = 1024 * 1024
# Between the cells of one point, with its normal and color, there are no more delimiters.
_MOST_CUTS = 9
# What stands before a cell, and what behind it.
_BEFORE, _BEHIND = rb"(?<![^\s,;|\"])", rb"(?![^\s,;|\"])"
# Not a number, and infinity, as C of Microsoft writes them: `1.#QNAN0`, `-nan(ind)`, `1.#INF00`.
_NO_NUMBER = re.compile(rb"(?i)%b[+-]?(?:1\.#(?:QNAN|SNAN|IND)\w*|nan\(\w*\))%b" % (_BEFORE, _BEHIND))
_INFINITY = re.compile(rb"(?i)%b([+-]?)1\.#INF\w*%b" % (_BEFORE, _BEHIND))
# A number in double precision as Fortran writes it, `1.234D+01`; a bare `12D4` may be a name.
_MANTISSA = rb"[+-]?(?:\d+\.\d*|\.\d+|\d+(?=[dD][+-]))"
_FORTRAN = re.compile(rb"%b(%b)[dD]([+-]?\d{1,3})%b" % (_BEFORE, _MANTISSA, _BEHIND))
_EXPONENT = re.compile(rb"[dD][+-]?\d")

Rows = Callable[[], Iterator[tuple[int, str]]]


def check_line_ends(data: memoryview) -> None:
    """Raise `UnreadableFileError` where a text of more than one point has no line ends."""
    head = bytes(data[:_LINE_LIMIT])
    if b"\n" in head or b"\r" in head or b"\0" in head:
        return
    if len(re.findall(rb"[,;\s]+", head)) > _MOST_CUTS:
        raise UnreadableFileError("line 1", f"the text is one line; {ENDS_TAKEN}")


def check_lines(data: memoryview) -> None:
    """Raise `UnreadableFileError` naming the first line that is over 64 KiB long; nothing is copied whole."""
    start, number = 0, 1
    while len(data) - start > _LINE_LIMIT:
        piece = bytes(data[start : start + _LINE_LIMIT])
        end = max(piece.rfind(b"\n"), piece.rfind(b"\r")) + 1
        if not end:
            hint = f"; {ENDS_TAKEN}" if number == 1 else ""
            raise UnreadableFileError(f"line {number}", f"the line is over 64 KiB long{hint}")
        start += end
        number += piece.count(b"\n", 0, end)


def plain_numbers(text: bytes) -> bytes:
    """A text whose numbers are spelt so that Python reads them, whatever program wrote them.

    Numbers with the exponent D are looked for in the first MiB: who writes them so, writes all of them so.
    """
    if b".#" in text or b"nan(" in text or b"NAN(" in text:
        text = _INFINITY.sub(rb"\1inf", _NO_NUMBER.sub(b"nan", text))
    if (b"D" in text or b"d" in text) and _EXPONENT.search(text, 0, _HEAD):
        text = _FORTRAN.sub(rb"\1e\2", text)
    return text


def decoded(text: bytes) -> str:
    """A text in UTF-8 whose lines end in a line feed, whatever ended them; what is not UTF-8 is replaced."""
    return _decoded(text.removeprefix(BOM))


def _decoded(text: bytes) -> str:
    return text.decode("utf-8", errors="replace").replace("\r\n", "\n").replace("\r", "\n")


def lines(text: bytes, wanted: re.Pattern[str]) -> Iterator[tuple[int, str]]:
    """Number and text of each line, but for empty ones and for long stretches in which nothing is `wanted`.

    Millions of blank lines and comments cost a search, not a step each. For a text that passes `check_lines`.
    """
    number = 1
    for piece in map(_decoded, pieces(text.removeprefix(BOM))):
        if wanted.search(piece):
            for at, line in enumerate(piece.split("\n"), number):
                if line:
                    yield at, line
        number += piece.count("\n")


def pieces(text: bytes, start: int = 0) -> Iterator[bytes]:
    """The text from `start` on, cut between lines."""
    while start < len(text):
        end = start + _PIECE
        if end < len(text):
            end = max(text.rfind(b"\n", start, end), text.rfind(b"\r", start, end)) + 1 or len(text)
            end += text[end - 1 : end + 1] == b"\r\n"
        yield text[start:end]
        start = end


def is_number(cell: str) -> bool:
    """Whether a cell holds a decimal number, NaN or infinity."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell and cell.isascii()


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """The cells of a row; one in quotes may hold the delimiter, unless that is white space."""
    if delimiter is not None:
        line = line.rstrip().rstrip(delimiter)
    if delimiter is None or '"' not in line:
        return [_unquoted(cell.strip()) for cell in line.split(delimiter)]
    return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]


def _unquoted(cell: str) -> str:
    """A cell without the quotes about it; one at its end alone, as in `2"`, belongs to it."""
    return cell[1:-1].strip() if len(cell) > 1 and cell[0] == cell[-1] == '"' else cell


def runs_on(line: str, delimiter: str | None) -> bool:
    """Whether a cell begins with a quote that does not end in the row: it would take the next one in."""
    if delimiter is None:
        line, delimiter = " ".join(line.split()), " "
    return len(list(csv.reader([line, ""], delimiter=delimiter, skipinitialspace=True))) < 2


def counted(n_bad: int) -> str:
    """The number of bad rows, in words where there may be more."""
    return f"{n_bad} or more" if n_bad >= COUNTED else str(n_bad)


def load_triples(rows: Rows, what: str) -> Array:
    """The three numbers after the first word of each row, as (N, 3); `rows` gives line numbers and lines.

    Raises `InvalidPointsError` naming the lines that do not hold three numbers.
    """
    if next(rows(), None) is None:
        return np.empty((0, 3))
    try:
        return np.loadtxt((line for _, line in rows()), np.float64, comments=None, usecols=(1, 2, 3), ndmin=2)
    except ValueError:
        raise _explain(rows, what) from None


def _explain(rows: Rows, what: str) -> InvalidPointsError:
    found = (
        number
        for number, line in rows()
        if len(cells := line.split()[1:4]) < 3 or not all(is_number(cell) for cell in cells)
    )
    bad = list(islice(found, COUNTED))
    errors = [FieldError(f"line {number}", f"a {what} must be three numbers") for number in bad[:SHOWN]]
    return InvalidPointsError(
        errors[0].field, f"{counted(len(bad))} lines hold no {what} of three numbers", errors=errors
    )
