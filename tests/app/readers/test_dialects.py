"""PTS and ASC, and labels in text, with and without a header."""

import numpy as np
import pytest

from primfit.app.readers import Limits, Pick, UnreadableFileError, read
from primfit.app.readers.lines import plain_numbers

POINTS = np.random.default_rng(6).normal(size=(20, 3)) * 100.0 + [1e6, -2e6, 3.0]
ROWS = [" ".join(map(repr, row)) for row in POINTS.tolist()]


@pytest.mark.parametrize("tail", ["", " -1204", " -1204 10 20 30"], ids=["points", "intensity", "color"])
@pytest.mark.parametrize("end", ["\n", "\r\n"], ids=["unix", "windows"])
def test_a_pts_file_is_read_to_the_last_digit(tail: str, end: str) -> None:
    cloud = read(end.join([str(len(ROWS)), *(row + tail for row in ROWS), ""]).encode())
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.columns == ("x", "y", "z")


SCANS = {
    "one": ("20", None, None),
    "one, too few announced": ("19", None, "The first line announces 19 points, 20 follow; all are read."),
    "one, too many announced": (
        "1000000000000",
        None,
        "The first line announces 1000000000000 points, 20 follow",
    ),
    "several": ("7", "13", None),
    "several, the first wrong": ("6", "13", "1 of 2 counts are wrong: one announces 6 points, 7 follow"),
    "several, the last wrong": ("7", "0", "1 of 2 counts are wrong: one announces 0 points, 13 follow"),
}


@pytest.mark.parametrize(("first", "second", "said"), SCANS.values(), ids=SCANS)
def test_all_points_of_a_pts_file_are_read_whatever_it_announces(
    first: str, second: str | None, said: str | None
) -> None:
    rows = [first, *ROWS[:7], *([] if second is None else [second]), *ROWS[7:]]
    cloud = read("\n".join(rows).encode(), Limits(points=20))
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert len(cloud.warnings) == (said is not None)
    assert all(warning.startswith(str(said)) for warning in cloud.warnings)


def test_labels_of_a_pts_file_of_several_scans_are_those_of_its_points() -> None:
    cloud = read(b"2\n1 2 3 4\n4 5 6 5\n1\n7 8 9 6\n", pick=Pick("4"))
    np.testing.assert_array_equal(cloud.labels, [4, 5, 6])


def test_a_bad_row_of_a_pts_file_is_named_and_its_counts_are_none() -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(b"2\n1 2 3\n4 5 6\n2\n7 8 9\n1 x 2\n")
    assert [error.field for error in caught.value.errors] == ["line 6, column 2"]


WHOLE = (
    b"x,y,z\n1,2,3\n4,5,6\n7,8,9\n",
    b"v 1 2 3\nv 4 5 6\nv 7 8 9\nf 1 2 3\n",
    b"4\n1 2 3\n4 5 6\n7 8 9\n1 1 2\n",
)


@pytest.mark.parametrize("text", WHOLE)
def test_a_text_whose_line_ends_were_taken_away_is_told_so(text: bytes) -> None:
    read(text)
    with pytest.raises(UnreadableFileError, match="one line; curl -d takes the line ends") as caught:
        read(text.replace(b"\n", b"") * 2)
    assert caught.value.field == "line 1"


def test_one_point_needs_no_line_end() -> None:
    np.testing.assert_array_equal(read(b"1 2 3 0 0 1 10 20 30").points, [[1, 2, 3]])


def test_rows_of_a_pts_file_may_be_cut_by_commas() -> None:
    cloud = read(b"2\n1,2,3,7\n4,5,6,7\n")
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])
    assert cloud.warnings == ()


FORTRAN = "x y z id\n  0.1234D+02 -1.5d-3 .25D0 A1D2\n  1.D+00  2D+00  3 12D4\n"


def test_exponents_of_fortran_are_numbers_and_no_part_of_words() -> None:
    cloud = read(FORTRAN.encode(), pick=Pick("id"))
    np.testing.assert_array_equal(cloud.points, [[12.34, -1.5e-3, 0.25], [1.0, 2.0, 3.0]])
    assert cloud.labels is not None and cloud.labels.tolist() == ["A1D2", "12D4"]
    for delimiter in ";,\t":
        cut = "\n".join(delimiter.join(line.split()) for line in FORTRAN.splitlines())
        np.testing.assert_array_equal(read(cut.encode()).points, cloud.points)


SPELT = ("1.#QNAN", "1.#QNAN0", "-1.#IND", "-1.#IND00", "1.#SNAN", "nan(ind)", "-nan(snan)", "-NAN(IND)")
INFINITE = (("1.#INF", np.inf), ("-1.#INF00", -np.inf))


@pytest.mark.parametrize(
    ("word", "value"), [*((word, np.nan) for word in SPELT), *INFINITE], ids=[*SPELT, *dict(INFINITE)]
)
def test_what_is_no_number_is_read_as_any_compiler_writes_it(word: str, value: float) -> None:
    assert np.array_equal(np.array([float(plain_numbers(word.encode()))]), [value], equal_nan=True)
    ply = (
        "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n"
        "property float nx\nproperty float ny\nproperty float nz\nend_header\n1 2 3 1 0 %s\n4 5 6 0 0 1\n"
    )
    pcd = (
        "VERSION 0.7\nFIELDS x y z i\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 2\nHEIGHT 1\n"
        "DATA ascii\n1 2 3 %s\n4 5 6 1\n"
    )
    obj = "v 1 2 3\nv 4 5 6\nvn 0 0 %s\nvn 0 0 1\nf 1//1 2//2 1//1\n"
    text = "x y z nx ny nz\n1 2 3 0 0 %s\n4 5 6 0 0 1\n"
    for file in (ply, pcd, obj, text):
        cloud = read((file % word).encode())
        np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])
        assert cloud.normals is None


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
    cloud = read(text, pick=Pick(labels))
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
        read(text, pick=Pick(labels))
    assert caught.value.field == "labels"


def test_labels_that_need_not_be_there_may_be_missing() -> None:
    assert read(b"x,y,z,height\n1,2,3,4\n", pick=Pick("auto")).labels is None
    assert read(b"1,2,3,4\n", pick=Pick("auto")).labels is None


def test_a_row_without_its_label_is_named() -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(b"1 2 3 wall\n4 5 6\n", pick=Pick("4"))
    assert caught.value.field == "line 2"


@pytest.mark.parametrize("text", [b'x,y,z,part\n1,2,3,"\n4,5,6,a\n', b'1 2 3 4\n1 2 3 "5\n4 5 6 7\n'])
def test_a_quote_that_does_not_end_takes_no_other_row_in(text: bytes) -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(text)
    assert "a quote that does not end" in caught.value.errors[0].message


def test_inches_are_no_quotes() -> None:
    cloud = read(b'x,y,z,part\n1,2,3,2"\n4,5,6,"wall,"\n', pick=Pick("part"))
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])
    assert cloud.labels is not None and cloud.labels.tolist() == ['2"', "wall,"]
    for text in (b'1 2 3 2"\n4 5 6 "7a"\n', b'1;2;3;2"\n4;5;6;"7a"\n', b'1,2,3,"2"""\n4,5,6,7a\n'):
        assert read(text, pick=Pick("4")).labels.tolist() == ['2"', "7a"]  # type: ignore[union-attr]


WRITTEN = {
    "an index": "1,1.5,2,3\n2,4,5,6\n3,7,8,9\n",
    "point numbers and words": "1000 1.5 2 3 STM\n1001 4 5 6 STM\n1002 7 8 9 WALL\n",
    "a comment that names an index": "# id x y z\n# units: mm\n7 1.5 2 3\n3 4 5 6\n5 7 8 9\n",
    "a comment in another order, of more words": "// Y X Z Scalar field\n2 1.5 3 0\n5 4 6 0\n8 7 9 0\n",
    "a comment cut by commas": "# POINT_ID, X, Y, Z, R\n9 1.5 2 3 0\n3 4 5 6 0\n5 7 8 9 0\n",
    "a comment that names the first columns": "# x y z\n1.5 2 3 70\n4 5 6 80\n7 8 9 90\n",
    "numbered columns": "0,1,2\n1.5,2,3\n4,5,6\n7,8,9\n",
    "numbered columns and decimal commas": "0;1;2\n1,5;2;3\n4;5;6\n7;8;9\n",
    "decimal commas between semicolons": "X;Y;Z\n1,5;2;3,0\n4;5;6\n7;8;9\n",
    "decimal commas between spaces": "1,5 2,0 3,0\n4,0 5,0 6,0\n7,0 8,0 9,0\n",
    "decimal commas between tabs": "1,5\t2\t3\n4\t5\t6\n7\t8\t9\n",
    "tabs and spaces": "1.5\t 2  3\n4\t 5  6\n7\t 8  9\n",
    "units below the header": "x,y,z\n[mm],(mm),mm\n1.5,2,3\n4,5,6\n7,8,9\n",
    "titles above the header": "Scan 12 of hall 3\nJuly\nx,y,z\n1.5,2,3\n4,5,6\n7,8,9\n",
    "a title alone": "Hall 3\n1.5 2 3\n4 5 6\n7 8 9\n",
    "what a spreadsheet says first": 'sep=;\n"X";"Y";"Z"\n1.5;2;3\n4;5;6\n7;8;9\n',
    "the end of an old file": "1.5 2 3\n4 5 6\n7 8 9\n\x1a",
    "a line behind the end of an old file": "1.5 2 3\r\n4 5 6\r\n7 8 9\r\n\x1a\r\n",
    "a comment of MATLAB": "%% Scan 12, 3 layers\n% y x z\n2 1.5 3\n5 4 6\n% second scan\n8 7 9\n",
    "a comment of Fortran": "! 12 3 0\n! y  x  z\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment behind a title": "Hall 3\n# y x z\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment with a colon": "# columns: y, x, z\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment with more words": "# y, x, z in mm, of hall 3\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment in brackets": "# (y, x, z)\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment with prose": "# points as y x z\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment with units": "# Y [mm] X [mm] Z [mm]\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment of surveyors": "# Northing Easting Height\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a header with units between spaces": "Y [mm] X [mm] Z [mm]\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a comment without the index": "# y x z\n1 2 1.5 3\n2 5 4 6\n3 8 7 9\n",
    "a comment without the index, in floats": "# x y z\n0e0 1.5 2 3\n1e0 4 5 6\n2e0 7 8 9\n",
    "a header of R": '"y" "x" "z" "i"\n"1" 2 1.5 3 0\n"2" 5 4 6 0\n"3" 8 7 9 1\n',
    "initials of surveyors": "P,N,E,Z,D\n31,2,1.5,3,STM\n30,5,4,6,STM\n7,8,7,9,STM\n",
    "initials in a comment": "# N E H\n2 1.5 3\n5 4 6\n8 7 9\n",
    "another name of the height": "Y;X;H\n2;1.5;3\n5;4;6\n8;7;9\n",
    "names of surveyors in Spanish": "# Norte Este Cota\n2 1.5 3\n5 4 6\n8 7 9\n",
    "words with the names": "# y_coord x_coord z_coord\n2 1.5 3\n5 4 6\n8 7 9\n",
    "words before the names": "CoordY,CoordX,CoordZ\n2,1.5,3\n5,4,6\n8,7,9\n",
    "fields of a structure": "# pos.y, pos.x, pos.z\n2 1.5 3\n5 4 6\n8 7 9\n",
    "names with units behind": "Ymm\tXmm\tZmm\n2\t1.5\t3\n5\t4\t6\n8\t7\t9\n",
    "a header of surveyors": "Hochwert;Rechtswert;H\u00f6he\n2;1.5;3\n5;4;6\n8;7;9\n",
    "a header cut by commas over spaces": "y,x,z\n2 1.5 3\n5 4 6\n8 7 9\n",
    "a header cut by spaces over commas": "y x z\n2,1.5,3\n5,4,6\n8,7,9\n",
    "tabs before the first cell": "\tX\tY\tZ\n\t1.5\t2\t3\n\t4\t5\t6\n\t7\t8\t9\n",
    "decimal commas between spaces, and whole numbers": "1,5 2,0 3 217\n4,0 5,0 6 80\n7,0 8,0 9 12\n",
}
NINE = [[1.5, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("name", WRITTEN)
def test_texts_are_read_as_programs_write_them(name: str, encoding: str) -> None:
    np.testing.assert_array_equal(read(WRITTEN[name].encode(encoding)).points, NINE)


NARROW = {
    "words above an identifier": "# x y z\n{0} {1} {2} {3}\n",
    "a header above an identifier": "x y z\n{0} {1} {2} {3}\n",
    "an index that breaks off": "# x y z\n{4} {1} {2} {3}\n",
}


@pytest.mark.parametrize("text", NARROW.values(), ids=NARROW)
@pytest.mark.parametrize("columns", [None, ("x", "y", "z")], ids=["found", "by name"])
def test_names_of_fewer_columns_are_not_given_to_an_identifier(
    text: str, columns: tuple[str, ...] | None
) -> None:
    head, row = text.split("\n")[:2]
    points = POINTS.round(3)
    rows = [row.format(i * 7 % 20, *map(repr, p), i if i < 19 else 0) for i, p in enumerate(points.tolist())]
    data = "\n".join([head, *rows, row.format(99, 1.5, 2.5, 3.5, 5)]).encode()
    if "{4}" in text:
        data = "\n".join([head, *rows[:19], *rows]).encode()
    with pytest.raises(UnreadableFileError, match=r"1,2,3 or 2,3,4; say which: columns=2,3,4"):
        read(data, pick=Pick(columns=columns))
    np.testing.assert_array_equal(read(data, pick=Pick(columns=(2, 3, 4))).points[:19], points[:19])


def test_columns_behind_an_index_that_has_no_name_are_picked_by_name() -> None:
    text = WRITTEN["a header of R"].encode()
    np.testing.assert_array_equal(read(text, pick=Pick(columns=("x", "y", "z"))).points, NINE)
    np.testing.assert_array_equal(read(text, pick=Pick(columns=("3", "2", "4"))).points, NINE)
    assert read(text, pick=Pick("i")).labels.tolist() == [0, 0, 1]  # type: ignore[union-attr]


def test_names_of_two_coordinates_in_another_order_are_not_passed_over() -> None:
    for text in (b"# y x\n2 1.5 3\n5 4 6\n", b"y x\n2\t1.5\t3\n5\t4\t6\n"):
        with pytest.raises(UnreadableFileError, match="names y, x in this order") as caught:
            read(text)
        assert caught.value.field == "columns"
        np.testing.assert_array_equal(
            read(text, pick=Pick(columns=(2, 1, 3))).points, [[1.5, 2, 3], [4, 5, 6]]
        )
    np.testing.assert_array_equal(
        read(b"# z up, y forward\n1.5 2 3\n4 5 6\n").points, [[1.5, 2, 3], [4, 5, 6]]
    )


def test_a_header_of_three_names_above_decimal_commas_between_commas_says_so() -> None:
    with pytest.raises(UnreadableFileError, match="if commas are decimal, separate the cells by semicolons"):
        read(b"x,y,z\n1,5,2,25,3,5\n4,5,5,5,6,5\n")


def test_numbered_columns_above_whole_numbers_are_no_point_if_they_lie_apart() -> None:
    far = b"0,1,2\n4120,-870,310\n4133,-861,305\n4101,-855,322\n"
    np.testing.assert_array_equal(read(far).points[:, 0], [4120, 4133, 4101])
    near = b"0,1,2\n0,1,3\n0,2,2\n1,2,3\n"
    np.testing.assert_array_equal(read(near).points[:, 0], [0, 0, 0, 1])


def test_utf_16_is_read_in_either_order_of_bytes() -> None:
    for codec, mark in (("utf-16-le", b"\xff\xfe"), ("utf-16-be", b"\xfe\xff")):
        np.testing.assert_array_equal(read(mark + WRITTEN["an index"].encode(codec)).points, NINE)


def test_the_receipt_tells_the_columns_behind_an_index_by_number() -> None:
    assert read(WRITTEN["an index"].encode()).columns == ("2", "3", "4")
    assert read(WRITTEN["an index"].encode(), pick=Pick("1")).labels.tolist() == [1, 2, 3]  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "text",
    ["1 2 3 0\n3 4 5 0\n4 5 6 0\n", "1 2 3\n2 3 4\n3 4 5\n", "1 2 3 4\n2 3 4 5\n"],
    ids=["a gap", "no column to spare", "two rows"],
)
def test_what_does_not_count_up_is_no_index(text: str) -> None:
    assert read(text.encode()).columns == ("x", "y", "z")


def test_words_in_a_comment_are_no_names_of_columns() -> None:
    """ "in" would stand for x."""
    text = b"# units: x y z in mm\n1.5 2 3 70\n4 5 6 80\n7 8 9 90\n"
    np.testing.assert_array_equal(read(text).points, NINE)


def test_a_comment_that_does_not_tell_its_columns_asks_for_them() -> None:
    text = b"# r g b y x z some other words\n1 2 3 5.5 1.5 2 0 0\n4 5 6 8 4 5 1 1\n"
    with pytest.raises(UnreadableFileError, match="a comment names x, y and z, but not which") as caught:
        read(text)
    assert caught.value.field == "columns"
    np.testing.assert_array_equal(read(text, pick=Pick(columns=(5, 4, 6))).points[0], [1.5, 5.5, 2])


def test_a_line_of_white_space_above_the_rows_costs_little() -> None:
    """A pattern that starts anew at each blank would take minutes."""
    text = (b"a" + b" " * 60_000 + b"b\n") * 15 + b"1.5 2 3\n4 5 6\n7 8 9\n"
    np.testing.assert_array_equal(read(text).points, NINE)


@pytest.mark.parametrize("cut", [" ", ",", ";"])
@pytest.mark.parametrize("head", ["", "# y x z\n", "y{0}x{0}z\n"], ids=["no names", "comment", "header"])
def test_points_that_are_missing_may_stand_before_all_others(cut: str, head: str) -> None:
    """An organized cloud begins with its border, where nothing was measured."""
    missing = f"nan{cut}-inf{cut}nan\n" * 150
    text = head.format(cut) + missing + "\n".join(cut.join(map(str, row)) for row in NINE)
    cloud = read(text.encode())
    assert len(cloud.points) == 153 and np.isnan(cloud.points[:150, 0 if not head else 1]).all()
    points = np.array(NINE)[:, [1, 0, 2]] if head else NINE
    np.testing.assert_array_equal(cloud.points[150:], points)


def test_a_text_of_missing_points_alone_is_a_cloud_without_points() -> None:
    for text in (b"nan nan nan\n" * 30, b"x,y,z\n" + b"nan,nan,nan\n" * 30):
        assert np.isnan(read(text).points).all() and len(read(text).points) == 30


CUT_TWICE = {
    "an index": "{i},{x},{y},{z}",
    "an identifier": "{k},{x},{y},{z}",
    "words behind": "{x},{y},{z},STM",
    "an index and words": "{i},{x},{y},{z},STM",
    "exponents": "{x}E+01,{y}E+01,{z}E+01",
}


@pytest.mark.parametrize("row", CUT_TWICE.values(), ids=CUT_TWICE)
def test_commas_that_cut_and_are_decimal_are_refused_whatever_stands_beside_them(row: str) -> None:
    numbers = [{"x": f"18,{i}21", "y": f"-{i},703", "z": f"56,15{i}"} for i in range(10)]
    rows = [row.format(i=i + 1, k=i * 37 % 101, **cells) for i, cells in enumerate(numbers)]
    with pytest.raises(UnreadableFileError, match="three numbers with decimal commas"):
        read("\n".join(rows).encode())


def test_a_point_among_decimal_commas_is_no_decimal_point() -> None:
    """`1.018` is a thousand and more there; the first rows need not show it."""
    text = "x;y;z\n" + "1,5;2,25;3,5\n" * 30 + "1.018;2,5;3,5\n"
    with pytest.raises(UnreadableFileError) as caught:
        read(text.encode())
    assert [error.field for error in caught.value.errors] == ["line 32, column 1"]


def test_a_row_of_words_below_the_header_is_no_row_of_units() -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(b"x,y,z\nwest,north,up\n1,2,3\n")
    assert caught.value.field == "line 2, column 1"


def test_whole_numbers_whose_second_ones_have_signs_are_columns() -> None:
    text = b"1,-5,2,5,3,5\n1,6,2,-6,3,6\n"
    np.testing.assert_array_equal(read(text).points, [[1, -5, 2], [1, 6, 2]])


def test_labels_with_decimal_commas_stay_as_they_are() -> None:
    cloud = read(b"x;y;z;part\n1,5;2;3;a,b\n4;5;6;7,5\n", pick=Pick("part"))
    assert cloud.labels is not None and cloud.labels.tolist() == ["a,b", "7,5"]
    np.testing.assert_array_equal(cloud.points, NINE[:2])


def test_points_of_colmap_are_read_by_their_commented_header() -> None:
    """Each row ends with the images that a point was seen in, as many as there are."""
    text = (
        "# 3D point list with one line of data per point:\n"
        "#   POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n"
        "# Number of points: 3, mean track length: 2.3\n"
        "90 1.5 2 3 115 121 122 1.33 16 6542 15 7345\n"
        "76 4 5 6 102 209 250 1.73 16 6519 15 7322 14 7212\n"
        "71 7 8 9 245 251 249 0.61 118 4140\n"
    )
    cloud = read(text.encode())
    np.testing.assert_array_equal(cloud.points, NINE)
    assert cloud.columns == ("X", "Y", "Z")
    short = text.replace(" 15 7345", "")  # a row of as many cells as there are words between commas
    np.testing.assert_array_equal(read(short.encode()).points, NINE)
    with pytest.raises(UnreadableFileError, match="1 rows are not"):
        read((text + "72 7 8\n").encode())
