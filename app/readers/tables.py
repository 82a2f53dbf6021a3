"""How a table in a text is written: what cuts its rows, where its header is, which columns are x, y and z."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from .columns import Columns, Pick, check_width, find_columns, meanings
from .errors import InvalidPointsError, UnreadableFileError
from .headers import MISSING, Lines, above_row, check_order, commented_names, header, wrong_width
from .lines import cells_of, decoded, is_number
from .unnamed import number_columns, place_of_x

_SAMPLE = 20
_HEAD = 1024 * 1024
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_WHOLE = re.compile(r"[+-]?\d{1,18}")
# What may stand before a decimal comma or behind it.
_PART = re.compile(r"[+-]?\d{1,18}(?:[eE][+-]?\d{1,3})?")
_ANY_CUT = re.compile(r"[;,\s]+")
# Those of MATLAB and Fortran, % and !, stand at the beginning of a line only.
COMMENT = re.compile(r"#|//|^\s*[%!]")
# A line that holds more than white space and a comment.
ROW = re.compile(r"^[^\S\n]*+(?!#|//|[%!])\S.*", re.MULTILINE)
_DELIMITER_NAMES = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", None: "white space"}


@dataclass(frozen=True)
class Layout:
    """How a table is written.

    Attributes
    ----------
    delimiter : what cuts the cells of a row; None for white space
    first_line, width : where the first row of numbers is, and how many cells it has
    columns : those that are used
    announced : the number of rows that a PTS file tells on its first line
    decimal_comma : numbers are written with one
    ragged : rows may differ in width behind the columns that are used, as in lists of observations
    by_place : columns have no names, so that their numbers tell which are x, y and z
    """

    delimiter: str | None
    first_line: int
    width: int
    columns: Columns
    announced: int | None = None
    decimal_comma: bool = False
    ragged: bool = False
    by_place: bool = False

    @property
    def read(self) -> tuple[int, ...]:
        """The columns whose numbers are read: those used, and the first one where it may be an index."""
        return (0, *self.columns.used) if self.by_place and self.columns.used[0] else self.columns.used

    def holds(self, width: int) -> bool:
        """Whether a row of so many cells is one of the table."""
        return width == self.width or (self.ragged and width > max(self.columns.wanted))


def look(text: bytes, pick: Pick) -> Layout:
    """What the first lines tell.

    Raises `UnreadableFileError` where they do not tell which columns are x, y and z.
    """
    whole = len(text) <= _HEAD
    head = decoded(text if whole else text[: text.rfind(b"\n", 0, _HEAD)])
    sample = _sample(head, whole)
    begins = 1
    announced = _announced(sample)
    if announced is not None:
        begins = 1 + sample.pop(0)[0]
    given = _given_delimiter(sample)
    if given:
        begins = 1 + sample.pop(0)[0]
    first = _first_row(sample)
    delimiter, decimal_comma = _delimiter([line for _, line in sample[first:]], given)
    width = len(cells_of(sample[first][1], delimiter))
    while first and _may_be_row(sample[first - 1][1], delimiter, width):
        first -= 1
    width = len(cells_of(sample[first][1], delimiter))
    names, units, first = header(sample, first, delimiter, width, pick)
    rows = sample[first:]
    if names is None and _is_numbered(rows, delimiter, width):
        first, rows = first + 1, rows[1:]
    titled = names is not None
    names = names or commented_names(above_row(head, rows[0][0]), delimiter, width, pick)
    ragged = not titled and names is not None and delimiter is None and _ends_in_a_list(names, width)
    behind = names is not None and _are_behind_an_index(names, rows, delimiter, width, pick)
    if titled and names and len(names) + behind < width and not pick.by_number:
        raise wrong_width(names, rows, delimiter, width)
    names = names and ([""] * behind + names + [""] * width)[:width]
    if names is None:
        if pick.columns is None:
            check_order(above_row(head, rows[0][0]))
        columns = _unnamed([cells_of(line, delimiter) for _, line in rows], delimiter, width, pick)
        if announced is not None:  # in a PTS file the first three are x, y and z
            columns = replace(columns, warnings=())
    else:
        columns = find_columns(names, pick)
        if units:
            columns = columns.in_unit([units[i] for i in columns.points])
    # Rows of missing points, which are not looked at, stand before the first one of numbers, too.
    start = 1 + sample[first - 1][0] if first else begins
    by_place = not pick.by_number if behind else names is None and pick.columns is None
    return Layout(delimiter, start, width, columns, announced, decimal_comma, ragged, by_place)


def _sample(head: str, whole: bool) -> Lines:
    """Line number and text of the first rows, without comments; `whole` says that `head` is all there is.

    Rows of missing points are left out, unless there are no others.
    """
    rows = list(islice(_told(head, MISSING), _SAMPLE))
    if not any(map(_is_value, _ANY_CUT.split(" ".join(line for _, line in rows)))):
        rows = list(islice(_told(head), _SAMPLE))
    sample = [(1 + head.count("\n", 0, start), line) for start, line in rows]
    if not sample:
        where = "file holds" if whole else "first MiB holds"
        raise InvalidPointsError("file", f"the {where} no points", no_cloud=True)
    for number, line in sample:
        check_width(1 + sum(1 for _ in _ANY_CUT.finditer(line)), f"line {number}")
    if re.match(r"(?i)(ncols|nrows)\s", sample[0][1]):
        raise UnreadableFileError("file", "an ESRI grid of heights is not a list of points; export it as XYZ")
    return sample


def _told(head: str, but: re.Pattern[str] | None = None) -> Iterator[tuple[int, str]]:
    """Where each row starts, and its text without comments; `but` those of this pattern."""
    for row in ROW.finditer(head):
        line = COMMENT.split(row[0], maxsplit=1)[0].rstrip().lstrip(" ")
        if but is None or not but.fullmatch(line):
            yield row.start(), line


def _announced(sample: Lines) -> int | None:
    """The number of points that the first line of a PTS file tells: a bare one, before rows of several."""
    first = sample[0][1].strip()  # of white space that int() does not take, too
    if len(sample) > 1 and re.fullmatch(r"\d{1,18}", first) and len(_cut(sample[1][1])) >= 3:
        return int(first)
    return None


def _given_delimiter(sample: Lines) -> str | None:
    """What a first line `sep=;` says that cells are cut by, as spreadsheets write it."""
    found = re.fullmatch(r"(?i)\"?sep=([;,|\t])\"?", sample[0][1])
    return found[1] if found and len(sample) > 1 else None


def _first_row(sample: Lines) -> int:
    """Where the rows of numbers begin: at the first line of three numbers, or else at the first of any."""
    for test, least in ((_is_value, 3), (_is_value, 1), (is_number, 1)):
        for k, (_, line) in enumerate(sample):
            if sum(test(cell.strip('"')) for cell in _cut(line)) >= least:
                return k
    raise InvalidPointsError("file", "the file holds no rows of numbers", no_cloud=True)


def _cut(line: str) -> list[str]:
    return _ANY_CUT.split(line.strip())


def _is_value(cell: str) -> bool:
    return is_number(cell) and cell.lower().strip("+-") not in ("nan", "inf", "infinity")


def _may_be_row(line: str, delimiter: str | None, width: int) -> bool:
    """Whether a line above the first three numbers is a row with a fault, not a title or a header."""
    numbers = [is_number(cell) for cell in cells_of(line, delimiter)]
    return all(numbers) or (len(numbers) == width and any(numbers))


def _is_numbered(rows: Lines, delimiter: str | None, width: int) -> bool:
    """Whether the first row numbers the columns, 0,1,2, as tables without names are written.

    Among whole numbers it may be a point, unless it lies apart from all others.
    """
    first, *others = (cells_of(line, delimiter) for _, line in rows)
    numbers = first[1:] if first[0] == "" else first  # an index of rows has no number
    if numbers not in ([str(k + start) for k in range(len(numbers))] for start in (0, 1)):
        return False
    fractions = any({*cell} & {*".,"} and math.isfinite(_value(cell)) for cells in others for cell in cells)
    return fractions or _is_far(*_values([first, *others], width))


def _is_far(table: NDArray[np.float64], _: object) -> bool:
    """Whether the first row (C,) is farther from all others than these are from each other."""
    first, others = table[0], table[1:][np.isfinite(table[1:]).all(axis=1)]
    if not np.isfinite(first).all() or len(others) < 2:
        return False
    distances = np.linalg.norm(others - first, axis=1)
    return bool(distances.min() > np.linalg.norm(np.ptp(others, axis=0)))


def _ends_in_a_list(names: Sequence[str], width: int) -> bool:
    """Whether rows may hold lists behind their columns: a name says so, or there are more or fewer names."""
    return len(names) != width or any("[]" in name for name in names)


def _are_behind_an_index(
    names: list[str], rows: Lines, delimiter: str | None, width: int, pick: Pick
) -> bool:
    """Whether these names, fewer than there are columns, leave out an index that stands before all others.

    Raises `UnreadableFileError` where nobody can tell, and the columns are not picked by their numbers.
    """
    if len(names) >= width or meanings(names)[0] is None:
        return False
    try:
        return place_of_x(*_values([cells_of(line, delimiter) for _, line in rows], width)) == 1
    except UnreadableFileError:
        if pick.by_number:
            return False
        raise


def _unnamed(rows: list[list[str]], delimiter: str | None, width: int, pick: Pick) -> Columns:
    """Columns of a table without names, where a number from 1 is the name of each."""
    if pick.columns is None:
        _refuse_decimal_comma_pairs(rows, delimiter)
    return number_columns(width, pick, *_values(rows, width))


def _values(rows: list[list[str]], width: int) -> tuple[NDArray[np.float64], list[bool]]:
    """The numbers (N, `width`) of rows, and which columns are words or numbers without a point.

    These are no coordinates, if there are others.
    """
    even = [cells for cells in rows if len(cells) >= width]
    values = [_value(cell) for cells in even for cell in cells[:width]]
    table = np.array(values, np.float64).reshape(-1, width)  # also where no row is whole
    return table, [all(_is_strange(cells[i]) for cells in even) for i in range(width)]


def _value(cell: str) -> float:
    cell = cell.replace(",", ".")
    return float(cell) if is_number(cell) else math.nan


def _is_strange(cell: str) -> bool:
    return _WHOLE.fullmatch(cell) is not None or not is_number(cell.replace(",", "."))


def _delimiter(rows: list[str], given: str | None) -> tuple[str | None, bool]:
    """What cuts the cells: semicolon, tab, comma or white space; and whether numbers have a decimal comma."""
    delimiter = given or _found_delimiter(rows)
    if delimiter == ",":
        return delimiter, False
    cells = [cell for line in rows for cell in cells_of(line, delimiter)]
    with_comma = any(map(_DECIMAL_COMMA.fullmatch, cells))
    if with_comma and any("." in cell and is_number(cell) for cell in cells):
        name = _DELIMITER_NAMES[delimiter]
        raise UnreadableFileError(
            "file", f"columns are cut by {name}, and numbers have a decimal comma here and a point there"
        )
    return delimiter, with_comma


def _found_delimiter(rows: list[str]) -> str | None:
    for delimiter in (";", "\t"):
        if all(delimiter in line for line in rows):
            return None if _is_padded(rows, delimiter) else delimiter
    if any(_has_decimal_commas(line.split()) for line in rows):
        return None
    return "," if any("," in line for line in rows) else None


def _has_decimal_commas(cells: list[str]) -> bool:
    """Whether these are numbers, of which two or more have a comma in the place of the point."""
    n_decimal = sum(_DECIMAL_COMMA.fullmatch(cell) is not None for cell in cells)
    return n_decimal > 1 and all(is_number(cell.replace(",", ".")) for cell in cells)


def _is_padded(rows: list[str], delimiter: str) -> bool:
    """Whether cells between this delimiter hold several numbers: then white space of any kind cuts them."""
    return any(sum(map(is_number, cell.split())) > 1 for line in rows for cell in cells_of(line, delimiter))


def _refuse_decimal_comma_pairs(rows: list[list[str]], delimiter: str | None) -> None:
    """Numbers without a point, six a row or more, may be three with decimal commas: nobody can tell.

    Not so where what would be a fraction has a sign. A number or a name of the point may stand before them.
    """
    if delimiter != "," or any("." in cell and is_number(cell) for cells in rows for cell in cells):
        return
    for first in (0, 1):
        pairs = [cells[first : first + 6] for cells in rows]
        if all(len(cells) == 6 and all(map(_PART.fullmatch, cells)) for cells in pairs) and all(
            cell[0].isdigit() for cells in pairs for cell in cells[1::2]
        ):
            raise UnreadableFileError(
                "file",
                f"rows hold {len(rows[0])} cells without a decimal point: either as many columns, or three "
                "numbers with decimal commas; name the columns in a header line, or write a decimal point",
            )
