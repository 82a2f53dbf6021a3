"""Rows of numbers cut by white space, behind a header that says how many there are."""

from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from itertools import chain, islice

import numpy as np

from .cloud import Array
from .errors import UnreadableFileError
from .lines import plain_numbers


def check_bytes(needed: int, there: int, count: int) -> None:
    """Raise where the rows that a header announces need more bytes than there are."""
    if needed > there:
        message = f"the header announces {count:.9g} rows, which need {needed:.9g} bytes; {there} are there"
        raise UnreadableFileError("file", message)


def read_rows(
    data: memoryview,
    skip: int,
    count: int,
    width: int,
    field: str,
    last: bool = False,
    pick: Callable[[str], str] | None = None,
) -> Array:
    """`count` rows of `width` numbers, as (count, width), behind `skip` lines; `last`: nothing may follow.

    `pick` makes of each line what is read of it. Raises `UnreadableFileError` with `field` where the rows are
    not what the header announces.
    """
    check_bytes(2 * (skip + count * width) - 1, len(data), count)
    text = TextIOWrapper(BytesIO(plain_numbers(bytes(data))), "latin-1")
    lines = islice(text, skip, None if last else skip + count)
    told = (line for line in lines if not last or line.strip())
    rows = told if pick is None else map(pick, told)
    if (first := next(rows, None)) is None:
        table = np.empty((0, width))
    else:
        try:
            table = np.loadtxt(chain([first], rows), np.float64, comments=None, ndmin=2)
        except UnreadableFileError:
            raise
        except ValueError as error:
            raise UnreadableFileError(field, f"a row is not one of {width} numbers") from error
    if table.shape != (count, width):
        found = f"there are {len(table)} of {table.shape[1]}"
        raise UnreadableFileError(field, f"the header announces {count} rows of {width} numbers, {found}")
    return table
