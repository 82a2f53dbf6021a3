"""Columns of a table without names, which are known by their numbers from 1: where x, y and z may stand.

They are the first three, or the three behind an index that counts up. Where the numbers tell that these are
something else, or may be, nothing is guessed: the caller is asked.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .cloud import Array
from .columns import AUTO_LABELS, XYZ, Columns, Pick, check_width, find_columns, find_label
from .errors import UnreadableFileError

# A first column of fewer numbers may count up, or rise, by accident.
_COUNTING, _RISING = 3, 8
# Rows that are looked at where the rest would tell little more.
_FEW = 1000


def number_columns(
    width: int, pick: Pick, table: Array | None = None, no_numbers: Sequence[bool] = ()
) -> Columns:
    """The columns of a table of this width; `table` (N, `width`) holds its rows, or the first of them.

    `no_numbers` says of each column whether it is known to hold no coordinates, however it looks.

    Raises `UnreadableFileError` where the table has fewer than three columns, or x, y and z may be several.
    """
    if width < 3:
        message = f"rows hold {width} values; a point needs x, y and z"
        raise UnreadableFileError("file", message, no_cloud=True)
    check_width(width)
    numbers = [str(number) for number in range(1, width + 1)]
    if pick.columns is not None:
        return find_columns(numbers, pick)
    label = None if pick.labels in (None, AUTO_LABELS) else find_label(numbers, pick.labels)
    label_name = None if label is None else pick.labels
    if table is None or width == 3:
        return Columns(XYZ.names, XYZ.points, (), label, label_name)
    odd = _are_odd(table, no_numbers)
    first = _place(table, odd)
    spare = not (odd[1:4].any() or any(_is_constant(column) for column in table[:_FEW, 1:4].T))
    places = tuple(range(first, first + 3))
    names = tuple(numbers[i] for i in places) if first else XYZ.names
    taken = f"columns {', '.join(numbers[i] for i in places)} are taken for x, y and z."
    warning = f"The {width} columns have no names: {taken}"
    return Columns(names, places, (), label, label_name, warnings=(warning,), spare=spare)


def is_index(values: ArrayLike) -> bool:
    """Whether the numbers of a first column (N,) are an index: whole ones, each one more than the last."""
    numbers = np.asarray(values)
    if len(numbers) < _COUNTING:
        return False
    with np.errstate(all="ignore"):
        return bool(numbers[0] == np.rint(numbers[0]) and (numbers[1:] - numbers[:-1] == 1).all())


def check_first(values: ArrayLike, width: int, columns: Columns) -> None:
    """Raise `UnreadableFileError` where the whole first column (N,) tells something else than its first rows.

    An index counts up to the end. A column that never falls may be a time or an index with gaps,
    before a point as well as its x; one number in all rows may be a label.
    """
    if width == 3:
        return
    if (
        not is_index(values)
        if columns.points[0]
        else _rises(values) or (columns.spare and _is_constant(values))
    ):
        raise _several(width, 0, 1)


def _rises(values: ArrayLike) -> bool:
    """Whether numbers (N,) never fall, and are not all the same: many points may have one time."""
    numbers: NDArray[Any] = np.asarray(values)
    if len(numbers) < _RISING or not numbers[-1] > numbers[0]:
        return False
    return bool((numbers[1:] >= numbers[:-1]).all())


def place_of_x(table: Array, no_numbers: Sequence[bool] = ()) -> int:
    """Where x stands in a table (N, C) without names: 0, or 1 behind an index.

    Raises `UnreadableFileError` where whole numbers and words stand there and three columns of fractions
    follow, or shares of a color and three columns that are none.
    """
    return _place(table, _are_odd(table, no_numbers))


def _place(table: Array, odd: NDArray[np.bool_]) -> int:
    first = int(is_index(table[:, 0]) and table.shape[1] > 3)
    others = [i for i in range(first + 1, len(odd) - 2) if not odd[i : i + 3].any()] if odd[first] else []
    if not others and _are_shares(table[:_FEW, first : first + 6]):
        others = [first + 3]
    if others:
        raise _several(table.shape[1], first, others[0])
    return first


def _are_odd(table: Array, no_numbers: Sequence[bool]) -> NDArray[np.bool_]:
    """Which columns hold whole numbers or words."""
    odd = [bool(i < len(no_numbers) and no_numbers[i]) for i in range(table.shape[1])]
    return np.array(odd) | [_is_counted(table[:, i]) for i in range(table.shape[1])]


def _is_constant(values: ArrayLike) -> bool:
    """Whether all these numbers (N,) are the same one."""
    numbers = np.asarray(values)
    there = numbers[np.isfinite(numbers)]
    return len(there) >= _RISING and bool((there == there[0]).all())


def _are_shares(values: Array) -> bool:
    """Whether the first three of six columns (N, 6) are within 0 and 1, as colors are, the others not."""
    if values.shape[1] < 6:
        return False
    colors, others = values[:, :3], values[:, 3:]
    with np.errstate(invalid="ignore"):
        return bool(((colors >= 0.0) & (colors <= 1.0)).all() and (np.abs(others) > 1.0).any(axis=0).all())


def _is_counted(values: NDArray[Any]) -> bool:
    """Whether these numbers (N,) are whole ones, not all the same, as of counts, colors and identifiers."""
    there = values[np.isfinite(values)]
    for some in (there[:_COUNTING], there):  # most columns hold a fraction among their first numbers
        if not (some == np.rint(some)).all():
            return False
    return bool((there != there[:1]).any())


def _several(width: int, *places: int) -> UnreadableFileError:
    sets = [f"{place + 1},{place + 2},{place + 3}" for place in places]
    message = (
        f"{width} columns without names: x, y and z may be those of the numbers {' or '.join(sets)}; "
        f"say which: columns={sets[-1]}, or names in a header line"
    )
    return UnreadableFileError("columns", message)
