"""Tables without names: what stands before x, y and z is told by its numbers, or the caller is asked."""

from collections.abc import Callable

import numpy as np
import pytest

from primfit.app.readers import Pick, UnreadableFileError, read
from tests.app.readers.written import npy

POINTS = np.random.default_rng(4).normal(size=(40, 3)).round(4) * 30.0
COLORS = np.random.default_rng(5).integers(0, 255, (40, 3))

BEFORE: dict[str, Callable[[int], str]] = {
    "an index with gaps": lambda i: str(i + 1 + i // 3),
    "an index of tens": lambda i: str(10 * i),
    "an index backwards": lambda i: str(400 - i),
    "an index that starts again": lambda i: str(i % 30),
    "an index in floats": lambda i: f"{i + i // 3:.6e}",
    "identifiers": lambda i: str(100000000 + i * 7919 % 1003),
    "seconds": lambda i: f"{1611234567.1 + i * 0.0133:.6f}",
    "seconds of several points": lambda i: f"{1611234567.1 + i // 3 * 0.0133:.6f}",
    "an intensity": lambda i: str(COLORS[i, 0]),
    "one label": lambda i: "3",
    "one label in floats": lambda i: "3.000000e+00",
    "one fraction": lambda i: "1.5",
    "a name": lambda i: f"P{i}",
    "nothing": lambda i: "",
}


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
@pytest.mark.parametrize("before", BEFORE.values(), ids=BEFORE)
def test_what_may_be_no_coordinate_is_not_taken_for_one(before: Callable[[int], str], delimiter: str) -> None:
    rows = [delimiter.join([before(i), *map(repr, point)]) for i, point in enumerate(POINTS.tolist())]
    text = "\n".join(rows).encode()
    with pytest.raises(UnreadableFileError, match=r"1,2,3 or 2,3,4; say which: columns=2,3,4") as caught:
        read(text)
    assert caught.value.field == "columns"
    np.testing.assert_array_equal(read(text, pick=Pick(columns=(2, 3, 4))).points, POINTS)


def test_colors_before_the_points_are_none() -> None:
    for rows in (np.column_stack([COLORS, POINTS]), np.column_stack([COLORS[:, :2], POINTS, COLORS])):
        text = "\n".join(" ".join(f"{x:g}" for x in row) for row in rows)
        for data in (text.encode(), npy(rows)):
            with pytest.raises(UnreadableFileError, match=r"say which: columns=[34],[45],[56]"):
                read(data)


def test_shares_of_colors_before_the_points_are_none() -> None:
    for rows in (
        np.column_stack([COLORS / 255.0, POINTS]),
        np.column_stack([np.arange(40), COLORS / 255.0, POINTS]),
    ):
        text = "\n".join(" ".join(f"{x:g}" for x in row) for row in rows).encode()
        with pytest.raises(UnreadableFileError, match=r"say which: columns=(4,5,6|5,6,7)"):
            read(text)


def test_an_identifier_behind_an_index_is_none() -> None:
    rows = np.column_stack([np.arange(40), np.arange(40) * 7 % 40, POINTS])
    for data in (npy(rows), "\n".join(" ".join(f"{x:g}" for x in row) for row in rows).encode()):
        with pytest.raises(UnreadableFileError, match=r"2,3,4 or 3,4,5; say which: columns=3,4,5"):
            read(data)


def test_a_plane_of_one_x_keeps_it_where_no_other_columns_may_be_the_point() -> None:
    rows = np.column_stack([POINTS * [0.0, 1.0, 1.0] + [2.5, 0.0, 0.0], np.tile([1.0, 0.0, 0.0], (40, 1))])
    for data in (npy(rows), "\n".join(" ".join(f"{x:.4f}" for x in row) for row in rows).encode()):
        np.testing.assert_allclose(read(data).points, rows[:, :3], atol=1e-3)


@pytest.mark.parametrize("first", [np.cumsum(np.arange(40) % 3 + 1), np.linspace(0.0, 0.7, 40)])
def test_arrays_are_read_by_the_same_rules(first: np.ndarray) -> None:
    with pytest.raises(UnreadableFileError, match=r"1,2,3 or 2,3,4"):
        read(npy(np.column_stack([first, POINTS])))


BEHIND = {
    "an intensity": COLORS[:, :1],
    "colors": COLORS,
    "normals": np.tile([0.6, 0.0, 0.8], (40, 1)),
    "fractions": COLORS / 255.0,
}


@pytest.mark.parametrize("behind", BEHIND.values(), ids=BEHIND)
def test_the_first_three_are_x_y_and_z_whatever_follows(behind: np.ndarray) -> None:
    for points in (POINTS, POINTS * [1.0, 1.0, 0.0], np.rint(POINTS) if behind is COLORS else POINTS):
        rows = np.column_stack([points, behind])
        text = "\n".join(" ".join(f"{x:g}" for x in row) for row in rows)
        np.testing.assert_allclose(read(text.encode()).points, points, atol=1e-3)
        np.testing.assert_array_equal(read(npy(rows)).points, points)


def test_which_columns_are_taken_is_said_where_there_are_others() -> None:
    rows = np.column_stack([POINTS, COLORS])
    for table, taken in ((rows, "1, 2, 3"), (np.column_stack([np.arange(40), rows]), "2, 3, 4")):
        text = "\n".join(" ".join(f"{x:g}" for x in row) for row in table)
        for data in (text.encode(), npy(table)):
            warning = f"The {table.shape[1]} columns have no names: columns {taken} are taken for x, y and z."
            assert read(data).warnings == (warning,)
    assert read(npy(POINTS)).warnings == () and read(b"2\n1 2 3 4\n5 6 7 8\n").warnings == ()


def test_a_grid_whose_first_row_counts_up_has_no_index() -> None:
    """Heights as an image has them: x counts up along a row of 25, which is longer than what is looked at."""
    rows = [(i % 25, i // 25, 10.0 + i % 7 / 8.0, 200) for i in range(100)]
    text = "\n".join("{} {} {} {}".format(*row) for row in rows)
    with pytest.raises(UnreadableFileError, match=r"1,2,3 or 2,3,4"):
        read(text.encode())


def test_numbers_of_columns_may_begin_at_one_and_leave_out_the_index() -> None:
    for header, before in (("1,2,3", ""), (",0,1,2", "{},"), (",1,2,3", "{},")):
        rows = [before.format(i) + "{!r},{!r},{!r}".format(*p) for i, p in enumerate(POINTS.tolist())]
        np.testing.assert_array_equal(read("\n".join([header, *rows]).encode()).points, POINTS)
