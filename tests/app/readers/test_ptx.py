"""PTX: the points of all scans, moved by the pose of each; what is missing is counted."""

from collections.abc import Callable
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from primfit.app.readers import Limits, TooLargeError, UnreadableFileError, read, without_missing

POINTS = np.random.default_rng(8).normal(size=(12, 3)).round(6) * 10.0
STRAIGHT = np.eye(3)
QUARTER = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
"""Moves a row (x, y, z) to (-y, x, z)."""
SHIFT = np.array([1e6, -2e6, 3.0])


def scan(points: np.ndarray, shape: tuple[int, int], turn: np.ndarray = STRAIGHT, tail: str = " 0.5") -> str:
    head = [str(number) for number in shape]
    head += [" ".join(map(str, row)) for row in (SHIFT, *turn)]
    head += [" ".join(map(str, [*row, 0])) for row in turn] + [" ".join(map(str, [*SHIFT, 1]))]
    return "\n".join([*head, *(" ".join(map(repr, row)) + tail for row in points.tolist())]) + "\n"


ONE = scan(POINTS, (3, 4))
TWO = scan(POINTS[:6], (2, 3)) + scan(POINTS[6:], (6, 1), QUARTER, " 0.5 10 20 30")


@pytest.mark.parametrize("tail", ["", " 0.5", " 0.500 120 130 140"], ids=["points", "intensity", "color"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"], ids=["Unix", "Windows", "old Mac"])
def test_points_are_moved_by_the_matrix_of_their_scan(tail: str, end: str) -> None:
    data = scan(POINTS, (3, 4), QUARTER, tail).replace("\n", end).encode()
    for whole in (data, data.removesuffix(end.encode())):
        cloud = read(whole)
        expected = np.column_stack([-POINTS[:, 1], POINTS[:, 0], POINTS[:, 2]]) + SHIFT
        np.testing.assert_allclose(cloud.points, expected, rtol=0.0, atol=1e-9)
        assert cloud.format == "ptx"
        assert cloud.columns == ("x", "y", "z")
        assert cloud.dropped == {"zero": 0}
        assert cloud.warnings == ()


def test_all_scans_of_a_file_are_read() -> None:
    turned = np.column_stack([-POINTS[6:, 1], POINTS[6:, 0], POINTS[6:, 2]])
    expected = np.vstack([POINTS[:6], turned]) + SHIFT
    for text in (TWO, TWO.replace("\n6\n1\n", "\n\n6\n1\n"), TWO + "\n"):
        np.testing.assert_allclose(read(text.encode()).points, expected, rtol=0.0, atol=1e-9)


def test_rows_of_zeros_are_missing_and_counted() -> None:
    holes = POINTS.copy()
    holes[::3] = 0.0
    holes[1, :2] = 0.0
    cloud = read((scan(holes, (3, 4)) + scan(holes, (12, 1))).encode())
    np.testing.assert_allclose(cloud.points, np.vstack([np.delete(holes, np.s_[::3], axis=0)] * 2) + SHIFT)
    assert cloud.dropped == {"zero": 8}
    with pytest.raises(UnreadableFileError, match="all 12 rows of the scans are 0 0 0"):
        read(scan(np.zeros((12, 3)), (3, 4)).encode())


CUT = {
    "after a line": (ONE[: ONE.rindex("\n", 0, -1) + 1], 11),
    "within a number": (ONE[: ONE.rindex(" ", 0, -9) - 2], 11),
    "within a long row": (scan(POINTS, (3, 4), tail=" 0.5 10 20 30")[:-8], 12),
    "of two scans": (TWO[: TWO.rindex("\n", 0, -1) + 1], 11),
    "in the third line": ("\n".join(ONE.split("\n")[:13]), 2),
}


@pytest.mark.parametrize(("text", "n_points"), CUT.values(), ids=CUT)
def test_a_last_scan_that_is_cut_off_is_read_with_a_warning(text: str, n_points: int) -> None:
    cloud = read(text.encode())
    assert len(cloud.points) == n_points
    if n_points == 12:
        assert cloud.warnings == ()
    else:
        (warning,) = cloud.warnings
        assert "its last scan announces" in warning


BROKEN: dict[str, tuple[Callable[[], str], str, str]] = {
    "a short scan before another one": (
        lambda: TWO.replace("2\n3\n", "2\n4\n", 1), "line 17", "scan 1 announces 8 points, 6 follow"
    ),
    "a long scan": (lambda: ONE.replace("3\n4\n", "3\n3\n", 1), "line 20", "the head of scan 2"),
    "a matrix of columns": (
        lambda: ONE.replace("1.0 0.0 0.0 0\n", "1.0 0.0 0.0 1e6\n", 1), "line 7", "last column is not 0 0 0 1"
    ),
    "a matrix of no numbers": (
        lambda: ONE.replace("1.0 0.0 0.0 0\n", "nan 0.0 0.0 0\n", 1), "line 7", "moves no points"
    ),
    "a word": (lambda: ONE + ONE.replace("0.5\n", "0.5\nx ", 1)[:-4], "file", "a row of scan 2"),
    "more announced than there can be": (lambda: ONE.replace("3\n4\n", "3000\n4\n", 1), "file", "12000 rows"),
}  # fmt: skip


@pytest.mark.parametrize(("write", "field", "said"), BROKEN.values(), ids=BROKEN)
def test_a_broken_file_is_refused_and_the_place_named(
    write: Callable[[], str], field: str, said: str
) -> None:
    with pytest.raises(UnreadableFileError, match=said) as caught:
        read(write().encode())
    assert caught.value.field == field


def test_the_points_of_all_scans_count_towards_the_limit() -> None:
    with pytest.raises(TooLargeError, match="12 points; the limit is 11"):
        read(TWO.encode(), Limits(points=11))
    assert len(read(TWO.encode(), Limits(points=12)).points) == 12


def test_what_is_no_number_is_not_moved_into_a_number() -> None:
    rows = scan(np.array([[1.0, 2.0, 3.0], [np.inf, 1.0, np.nan]]), (1, 2))
    with suppress(UnreadableFileError):
        assert len(without_missing(read(rows.encode())).points) == 1


@settings(max_examples=200, deadline=None)
@given(data=st.data())
def test_mutated_files_are_read_or_refused_and_never_crash(data: st.DataObject) -> None:
    whole = bytearray(TWO.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(whole)))
        end = start + data.draw(st.integers(0, 40))
        letters = st.text("0123456789-+e. \n", max_size=20).map(str.encode)
        whole[start:end] = data.draw(st.binary(max_size=10) | letters)
    with suppress(UnreadableFileError):
        # A mutated number may be 1e999.
        cloud = without_missing(read(bytes(whole), Limits(points=1000)))
        assert np.isfinite(cloud.points).all()


def test_a_table_that_begins_with_two_counts_is_no_ptx() -> None:
    assert read(b"3\n1 2 3\n4 5 6\n7 8 9\n").format == "text"


def test_a_count_may_stand_between_any_white_space() -> None:
    """Python's `split` takes more characters for white space than its `int`."""
    head = b"\x1d2\x1e\n1\n" + b"0 0 0\n" * 4 + b"1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    np.testing.assert_array_equal(read(head + b"1 2 3 0.5\n4 5 6 0.5\n").points, [[1, 2, 3], [4, 5, 6]])
