"""PTS and ASC, and labels in text, with and without a header."""

import numpy as np
import pytest

from primfit.app.readers import UnreadableFileError, read

POINTS = np.random.default_rng(6).normal(size=(20, 3)) * 100.0 + [1e6, -2e6, 3.0]
ROWS = [" ".join(map(repr, row)) for row in POINTS.tolist()]


@pytest.mark.parametrize("tail", ["", " -1204", " -1204 10 20 30"], ids=["points", "intensity", "colour"])
@pytest.mark.parametrize("end", ["\n", "\r\n"], ids=["unix", "windows"])
def test_a_pts_file_is_read_to_the_last_digit(tail: str, end: str) -> None:
    cloud = read(end.join([str(len(ROWS)), *(row + tail for row in ROWS), ""]).encode())
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.columns == ("x", "y", "z")


def test_a_pts_file_of_several_scans_is_refused() -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read("\n".join(["10", *ROWS[:10], "10", *ROWS[10:]]).encode())
    assert caught.value.field == "line 12"


def test_an_asc_file_of_points_is_read_and_a_grid_is_not() -> None:
    np.testing.assert_array_equal(read("\n".join(ROWS).encode()).points, POINTS)
    for grid in (b"ncols 4\nnrows 6\nxllcorner 0\n1 2 3 4\n", b"NROWS 6\nNCOLS 4\n1 2 3 4\n"):
        with pytest.raises(UnreadableFileError, match="ESRI grid"):
            read(grid)


LABELLED = {
    "integers": (b"x,y,z,label\n1,2,3,7\n4,5,6,-8\n", "label", [7, -8]),
    "integers with a point": (b"x y z label\n1 2 3 7.000\n4 5 6 8.\n", "label", [7, 8]),
    "words": (b"x;y;Segment;z\n1;2;wall a;3\n4;5;;6\n", "segment", ["wall a", ""]),
    "words in quotes": (b'x,y,z,part\n1,2,3,"wall, left"\n4,5,6,"7"\n', "part", ["wall, left", "7"]),
    "numbers in quotes": (b'"x","y","z","part"\n"1","2","3","8"\n4,5,6,"7"\n', "part", [8, 7]),
    "fractions": (b"x y z label\n1 2 3 0.5\n4 5 6 1\n", "label", ["0.5", "1"]),
    "nan and integers": (b"x y z label\n1 2 3 nan\n4 5 6 1\n", "label", ["nan", "1"]),
    "more than 18 digits": (b"x,y,z,id\n1,2,3,1234567890123456789\n4,5,6,1\n", "id",
                            ["1234567890123456789", "1"]),
    "before the points": (b"part,x,y,z\nwall,1,2,3\nfloor,4,5,6\n", "part", ["wall", "floor"]),
    "a usual name": (b"x,y,z,Instance_ID\n1,2,3,4\n4,5,6,5\n", "auto", [4, 5]),
    "by number": (b"1,2,3,4\n4,5,6,7\n", "4", [4, 7]),
    "words by number": (b"1 2 3 0 wall\n4 5 6 0 floor\n", "5", ["wall", "floor"]),
    "in a comment": (b"# x y z label\n1 2 3 4\n4 5 6 5\n", "label", [4, 5]),
    "in a pts file": (b"2\n1 2 3 4\n4 5 6 5\n", "4", [4, 5]),
}  # fmt: skip


@pytest.mark.parametrize(("text", "labels", "expected"), LABELLED.values(), ids=LABELLED)
def test_labels_are_read(text: bytes, labels: str, expected: list[int] | list[str]) -> None:
    cloud = read(text, labels=labels)
    assert cloud.labels is not None
    assert cloud.labels.tolist() == expected
    assert cloud.labels.dtype == (np.int64 if isinstance(expected[0], int) else object)
    assert cloud.label_column is not None
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])
    assert read(text).labels is None


@pytest.mark.parametrize(
    ("text", "labels"),
    [
        (b"x,y,z,label\n1,2,3,4\n", "part"),
        (b"x,y,z,label\n1,2,3,4\n", "4"),
        (b"1,2,3,4\n", "5"),
        (b"1,2,3,4\n", "0"),
        (b"1,2,3,4\n", "label"),
        (b"x,y,z,label,segment\n1,2,3,4,5\n", "auto"),
        (b"x,y,z,label\n1,2,3," + b"a" * 201 + b"\n", "label"),
    ],
    ids=["other name", "number beside a header", "too far", "zero", "no header", "two of them", "long"],
)
def test_labels_that_cannot_be_are_refused(text: bytes, labels: str) -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(text, labels=labels)
    assert caught.value.field == "labels"


def test_labels_that_need_not_be_there_may_be_missing() -> None:
    assert read(b"x,y,z,height\n1,2,3,4\n", labels="auto").labels is None
    assert read(b"1,2,3,4\n", labels="auto").labels is None


def test_a_row_without_its_label_is_named() -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(b"1 2 3 wall\n4 5 6\n", labels="4")
    assert caught.value.field == "line 2"
