"""How a table in a text is written: what cuts its rows, where its header is, which columns are x, y and z."""

import csv
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

from .columns import Columns, Pick, canonical, find_columns, is_index, number_columns
from .errors import InvalidPointsError, UnreadableFileError
from .lines import decoded, is_number

_SAMPLE = 20
_HEAD = 1024 * 1024
_DECIMAL_COMMA = re.compile(r"[+-]?\d+,\d+([eE][+-]?\d+)?")
_WHOLE = re.compile(r"[+-]?\d{1,18}")
_ANY_CUT = re.compile(r"[;,\s]+")
_UNITS = "nm|um|\u00b5m|\u03bcm|mm|cm|dm|m|km|in|inch|ft|us-ft|yd|mil|deg|rad|%|-|"
_UNIT = re.compile(rf"(?i)[\[(]?({_UNITS})[\])]?")
_INDEX = ("id", "index", "i", "n", "no", "nr", "number", "point", "point_id", "point3d_id", "pt", "pid")
COMMENT = re.compile("#|//")
# A line that holds more than white space and a comment.
ROW = re.compile(r"^[^\S\n]*+(?!#|//)\S.*", re.MULTILINE)
_DELIMITER_NAMES = {",": "comma", ";": "semicolon", "\t": "tab", "|": "bar", None: "white space"}

Lines = list[tuple[int, str]]


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
    """

    delimiter: str | None
    first_line: int
    width: int
    columns: Columns
    announced: int | None = None
    decimal_comma: bool = False
    ragged: bool = False

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
    announced = _announced(sample)
    if announced is not None:
        del sample[0]
    given = _given_delimiter(sample)
    if given:
        del sample[0]
    first = _first_row(sample)
    delimiter, decimal_comma = _delimiter([line for _, line in sample[first:]], given)
    width = len(cells_of(sample[first][1], delimiter))
    while first and _may_be_row(sample[first - 1][1], delimiter, width):
        first -= 1
    width = len(cells_of(sample[first][1], delimiter))
    names, units, first = _header(sample, first, delimiter, width, pick)
    rows = sample[first:]
    if names is None and _is_numbered(rows, delimiter, width):
        rows = rows[1:]
    ragged = False
    if names is None:
        names = _commented_names(head, delimiter, width)
        ragged = names is not None and delimiter is None and _ends_in_a_list(names, width)
        names = names and (names + [""] * width)[:width]
    if names is None:
        columns = _unnamed([cells_of(line, delimiter) for _, line in rows], delimiter, width, pick)
    else:
        columns = find_columns(names, pick)
        if units:
            columns = columns.in_unit([units[i] for i in columns.points])
    return Layout(delimiter, rows[0][0], width, columns, announced, decimal_comma, ragged)


def cells_of(line: str, delimiter: str | None) -> list[str]:
    """The cells of a row; one in quotes may hold the delimiter, unless that is white space."""
    if delimiter is not None:
        line = line.rstrip().rstrip(delimiter)
    if delimiter is None or '"' not in line:
        cells = line.split(delimiter)
    else:
        cells = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [cell.strip().strip('"').strip() for cell in cells]


def _sample(head: str, whole: bool) -> Lines:
    """Line number and text of the first rows, without comments; `whole` says that `head` is all there is."""
    sample = [
        (1 + head.count("\n", 0, row.start()), COMMENT.split(row[0], maxsplit=1)[0].strip())
        for row in islice(ROW.finditer(head), _SAMPLE)
    ]
    if not sample:
        where = "file holds" if whole else "first MiB holds"
        raise InvalidPointsError("file", f"the {where} no points", no_cloud=True)
    if re.match(r"(?i)(ncols|nrows)\s", sample[0][1]):
        raise UnreadableFileError("file", "an ESRI grid of heights is not a list of points; export it as XYZ")
    return sample


def _announced(sample: Lines) -> int | None:
    """The number of points that the first line of a PTS file tells: a bare one, before rows of several."""
    if len(sample) > 1 and re.fullmatch(r"\d{1,18}", sample[0][1]) and len(_ANY_CUT.split(sample[1][1])) >= 3:
        return int(sample[0][1])
    return None


def _given_delimiter(sample: Lines) -> str | None:
    """What a first line `sep=;` says that cells are cut by, as spreadsheets write it."""
    found = re.fullmatch(r"(?i)\"?sep=([;,|\t])\"?", sample[0][1])
    return found[1] if found and len(sample) > 1 else None


def _first_row(sample: Lines) -> int:
    """Where the rows of numbers begin: at the first line of three numbers, or else at the first of any."""
    numbers = [sum(_is_value(cell.strip('"')) for cell in _ANY_CUT.split(line)) for _, line in sample]
    found = next((k for least in (3, 1) for k, count in enumerate(numbers) if count >= least), None)
    if found is None:
        raise InvalidPointsError("file", "the file holds no rows of numbers", no_cloud=True)
    return found


def _is_value(cell: str) -> bool:
    return is_number(cell) and cell.lower().strip("+-") not in ("nan", "inf", "infinity")


def _may_be_row(line: str, delimiter: str | None, width: int) -> bool:
    """Whether a line above the first three numbers is a row with a fault, not a title or a header."""
    numbers = [is_number(cell) for cell in cells_of(line, delimiter)]
    return all(numbers) or (len(numbers) == width and any(numbers))


def _header(
    sample: Lines, first: int, delimiter: str | None, width: int, pick: Pick
) -> tuple[list[str] | None, list[str] | None, int]:
    """Names of the columns and their units, where lines above the rows tell them, and where the rows begin.

    Above the header there may be titles, and below it a row of units; any other line below is a row.
    """
    above = [cells_of(line, delimiter) for _, line in sample[:first]]
    named = [k for k, cells in enumerate(above) if _names_all(cells)]
    if not named:
        units = [k for k, cells in enumerate(above) if k and _are_units(cells, width)]
        last = units[0] - 1 if units else len(above) - 1
        if above and len(above[last]) == width:
            return above[last], above[units[0]] if units else None, first
        return None, None, first
    names = above[named[-1]]
    if len(names) != width and pick.columns is None:
        line = sample[first][0]
        raise UnreadableFileError(
            "header", f"the header names {len(names)} columns, line {line} holds {width}"
        )
    below = range(named[-1] + 1, first)
    units = [k for k in below if _are_units(above[k], width)]
    rows = next((k for k in below if k not in units), first)
    return (names + [""] * width)[:width], above[units[0]] if units else None, rows


def _are_units(cells: Sequence[str], width: int) -> bool:
    return len(cells) == width and all(map(_UNIT.fullmatch, cells))


def _names_all(names: Sequence[str]) -> bool:
    return {"x", "y", "z"} <= {canonical(name) for name in names}


def _is_numbered(rows: Lines, delimiter: str | None, width: int) -> bool:
    """Whether the first row numbers the columns, 0,1,2, as tables without names are written."""
    first, *others = (cells_of(line, delimiter) for _, line in rows)
    fractions = any(not _WHOLE.fullmatch(cell) for cells in others for cell in cells)
    return first == [str(number) for number in range(width)] and fractions


def _commented_names(head: str, delimiter: str | None, width: int) -> list[str] | None:
    """Names in a comment above the rows, as `# x y z` and `//X,Y,Z`; of several comments the last.

    It need not name all columns, nor only those: where it does not, no words but names of columns may stand
    before x, y and z.
    """
    row = ROW.search(head)
    comments = (head[: row.start()] if row else head).splitlines()
    for comment in reversed(comments):
        for names in _split(comment.strip().lstrip("/# "), delimiter):
            if len(names) == width and _names_all(names):
                return names
            if _names_all(names[:width]) and all(map(_is_column, _up_to_z(names))):
                return names
    return None


def _ends_in_a_list(names: Sequence[str], width: int) -> bool:
    """Whether rows may hold lists behind their columns: a name says so, or there are more or fewer names."""
    return len(names) != width or any("[]" in name for name in names)


def _split(comment: str, delimiter: str | None) -> Iterator[list[str]]:
    """The words of a comment, cut as the rows are, by what else cuts cells, and by white space."""
    yield cells_of(comment, delimiter)
    yield [name.strip() for name in re.split(r"[,;|\t]", comment)]
    yield comment.split()


def _up_to_z(names: Sequence[str]) -> Sequence[str]:
    return names[: 1 + max(k for k, name in enumerate(names) if canonical(name) in ("x", "y", "z"))]


def _is_column(name: str) -> bool:
    return canonical(name) is not None or name.strip().lower().replace(" ", "_") in _INDEX


def _unnamed(rows: list[list[str]], delimiter: str | None, width: int, pick: Pick) -> Columns:
    """Columns of a table without names, where a number from 1 is the name of each.

    The first three are x, y and z, or the three behind one that counts up.
    """
    if pick.columns is None:
        _refuse_decimal_comma_pairs(rows, delimiter)
    first = ["".join(cells[:1]) for cells in rows]
    indexed = width > 3 and all(map(_WHOLE.fullmatch, first)) and is_index([int(cell) for cell in first])
    return number_columns(width, pick, int(indexed))


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
    decimal = [[_DECIMAL_COMMA.fullmatch(cell) for cell in line.split()] for line in rows]
    if any(len(cells) >= 2 and all(cells) for cells in decimal):
        return None
    return "," if any("," in line for line in rows) else None


def _is_padded(rows: list[str], delimiter: str) -> bool:
    """Whether cells between this delimiter hold several numbers: then white space of any kind cuts them."""
    return any(sum(map(is_number, cell.split())) > 1 for line in rows for cell in cells_of(line, delimiter))


def _refuse_decimal_comma_pairs(rows: list[list[str]], delimiter: str | None) -> None:
    """Six bare integers a row, or more, may be three numbers with decimal commas: nobody can tell.

    Not so where what would be a fraction has a sign.
    """
    if delimiter != "," or not all(len(cells) >= 6 and all(map(_WHOLE.fullmatch, cells)) for cells in rows):
        return
    if all(cell[0].isdigit() for cells in rows for cell in cells[1:6:2]):
        raise UnreadableFileError(
            "file",
            f"rows hold {len(rows[0])} whole numbers: either as many columns, or three numbers with decimal "
            "commas; name the columns in a header line, or write a decimal point",
        )
