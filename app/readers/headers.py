"""The header of a table in a text, or in a comment above it: names of its columns, and their units."""

import re
from collections.abc import Iterator, Sequence

from .columns import Pick, meanings
from .errors import UnreadableFileError
from .lines import cells_of

_UNITS = "nm|um|\u00b5m|\u03bcm|mm|cm|dm|m|km|in|inch|ft|us-ft|yd|mil|deg|rad|%|-|"
_UNIT = re.compile(rf"(?i)[\[(]?({_UNITS})[\])]?")
_INDEX = {
    "id", "index", "idx", "i", "n", "no", "nr", "number", "nummer", "name", "p", "point", "point_id",
    "point_no", "point_number", "point3d_id", "pt", "pid", "pnr", "punkt", "vertex", "vertex_id", "row",
    "frame",
}  # fmt: skip
# A word before the names in a comment, `columns: x y z`; punctuation that begins one; what cuts its words.
_BEFORE_NAMES = re.compile(r"^[^\w\[(\"]*(?:[^\W\d][\w ]*[:=]\s+)?")
_WORDS = re.compile(r"[\s,;|\"'()\[\]{}]+")
# A row of a point that is missing.
MISSING = re.compile(r"(?i)[\s,;|\"]*+(?:[+-]?(?:nan|inf(?:inity)?)(?:[\s,;|\"]++|$))*+")
# Names are looked for so far above the rows, and so many words into a sentence.
_LINES_ABOVE, _PROSE = 100, 200

Lines = list[tuple[int, str]]


def header(
    sample: Lines, first: int, delimiter: str | None, width: int, pick: Pick
) -> tuple[list[str] | None, list[str] | None, int]:
    """Names of the columns and their units, where lines above the rows tell them, and where the rows begin.

    Above the header there may be titles, and below it a row of units; any other line below is a row.
    """
    above = [_names_in(line, delimiter, width) or cells_of(line, delimiter) for _, line in sample[:first]]
    named = [k for k, cells in enumerate(above) if _names_all(cells)]
    if not named:
        units = [k for k, cells in enumerate(above) if k and _are_units(cells, width)]
        last = units[0] - 1 if units else len(above) - 1
        if above and len(above[last]) == width:
            return above[last], above[units[0]] if units else None, first
        return None, None, first
    names = above[named[-1]]
    if len(names) not in (width, width - 1) and pick.columns is None:
        raise wrong_width(names, sample[first:], delimiter, width)
    below = range(named[-1] + 1, first)
    units = [k for k in below if _are_units(above[k], width)]
    rows = next((k for k in below if k not in units), first)
    return names[:width], above[units[0]] if units else None, rows


def wrong_width(names: Sequence[str], rows: Lines, delimiter: str | None, width: int) -> UnreadableFileError:
    """A header that names other columns than its rows hold, or those behind something else than an index."""
    message = f"the header names {len(names)} columns, line {rows[0][0]} holds {width}"
    if delimiter == "," and width == 2 * len(names):
        message += "; if commas are decimal, separate the cells by semicolons or write a decimal point"
    else:
        message += f"; say which are x, y and z: columns={'2,3,4' if width > 3 else '1,2,3'}"
    return UnreadableFileError("header", message)


def _are_units(cells: Sequence[str], width: int) -> bool:
    return len(cells) == width and all(map(_UNIT.fullmatch, cells))


def _names_all(names: Sequence[str]) -> bool:
    return {"x", "y", "z"} <= {*meanings(names)}


def above_row(head: str, row: int) -> list[str]:
    """The last lines above a row that hold more than signs of comments, and are no rows of missing points."""
    lines = head.split("\n", row)[: row - 1]
    return [line for line in lines if not MISSING.fullmatch(line.lstrip("/#%! "))][-_LINES_ABOVE:]


def commented_names(above: list[str], delimiter: str | None, width: int, pick: Pick) -> list[str] | None:
    """Names in a comment above the rows, as `# x y z` and `//X,Y,Z`; of several comments the last.

    Raises `UnreadableFileError` where none tells the columns of x, y and z, but one names them.
    """
    for comment in reversed(above):
        names = _names_in(comment, delimiter, width)
        if names is not None:
            return names
    for comment in reversed(above):
        words = [word for word in _WORDS.split(comment.lstrip("/#%! "), _PROSE)[:_PROSE] if word]
        told = meanings(words)
        place = next((k for k in range(len(told) - 2) if {*told[k : k + 3]} == {"x", "y", "z"}), None)
        if place is not None and place + 3 > width:  # words before them name no columns
            return words[place : place + 3]
        if place and pick.columns is None:
            message = "a comment names x, y and z, but not which columns they are; say which: columns=2,3,4"
            raise UnreadableFileError("columns", message)
    return None


def _names_in(line: str, delimiter: str | None, width: int) -> list[str] | None:
    """Names of the columns in a line, in whatever way it is cut.

    It need not name all columns, nor only those: where it does not, no words but names of columns may stand
    before x, y and z.
    """
    for names in _split(line.strip(" ").lstrip("/#%! "), delimiter):
        if len(names) == width and _names_all(names):
            return names
        if _names_all(names[:width]) and all(_are_columns(names)[: _number_up_to_z(names)]):
            return names
    return None


def _split(line: str, delimiter: str | None) -> Iterator[list[str]]:
    """The names in a line, cut as the rows are, by what else cuts cells, and by white space."""
    if delimiter is not None:
        yield cells_of(line, delimiter)
    names = re.sub(
        r"(?<!\s)\s++(?=[\[(])", "", _BEFORE_NAMES.sub("", line.strip())
    )  # a unit belongs to its name
    if names[:1] in ("[", "("):
        names = names.strip("[()] ")
    yield cells_of(names, delimiter)
    yield [name.strip() for name in re.split(r"[,;|\t]", names)]
    yield [name for name in re.split(r"[\s,;|\"]+", names) if name]


def _number_up_to_z(names: Sequence[str]) -> int:
    return 1 + max(k for k, name in enumerate(meanings(names)) if name in ("x", "y", "z"))


def _are_columns(names: Sequence[str]) -> list[bool]:
    """Which of these are names of coordinates, normals or an index."""
    bare = [name.strip().lower().replace(" ", "_") for name in names]
    told = meanings(names)
    return [a is not None or b in _INDEX for a, b in zip(told, bare, strict=True)]


def check_order(above: Sequence[str]) -> None:
    """Raise `UnreadableFileError` where a line of names alone has some of x, y and z in another order.

    Then the first three columns are not these.
    """
    for line in above:
        words = [word for word in _WORDS.split(line.lstrip("/#%! "), _PROSE)[:_PROSE] if word]
        told = [name for name in meanings(words) if name in ("x", "y", "z")]
        if told != sorted(told) and all(_are_columns(words)):
            message = f"a line above the rows names {', '.join(told)} in this order, no other names are found"
            message += "; say which columns are x, y and z: columns=1,2,3"
            raise UnreadableFileError("columns", message)
