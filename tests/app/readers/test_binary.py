"""The binary formats give the points of the NPY array, and the normals and labels beside them."""

import io
import struct
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import laspy
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from primfit.app.readers import Limits, Pick, UnreadableFileError, las_header, read, without_missing
from primfit.app.readers import ply as ply_reader
from tests.app.readers.written import (
    CARTESIAN,
    GRID,
    OFFSET,
    POINTS,
    SPHERICAL,
    STEP,
    e57,
    las,
    laz,
    npy,
    npz,
    pcd,
    ply,
    records,
)

LABELS = np.arange(len(POINTS)) // 7
NORMALS = np.tile([0.0, 0.6, -0.8], (len(POINTS), 1))
FACES = np.array([([0, 1, 2],), ([0, 2, 3],)], dtype=[("vertex_indices", "i4", (3,))])

EXACT = {
    "npz": lambda: npz(points=POINTS),
    "npz, not compressed": lambda: npz(False, xyz=POINTS),
    "npz of one array": lambda: npz(arr_0=POINTS, radius=np.float64(3.0), order=np.arange(60)),
    "npz of records": lambda: npz(cloud=records(POINTS)),
    "npz in Fortran order": lambda: npz(points=np.asfortranarray(POINTS)),
    "ply with faces before": lambda: ply((FACES, "face"), (records(POINTS), "vertex")),
    "ply ascii with faces before": lambda: ply((FACES, "face"), (records(POINTS), "vertex"), text=True),
    "pcd": lambda: pcd(POINTS),
    "pcd compressed": lambda: pcd(POINTS, "binary_compressed"),
    "e57": lambda: e57(POINTS),
    "e57 with a shift": lambda: e57(POINTS - OFFSET, pose=(1.0, 0.0, 0.0, 0.0, *OFFSET)),
    "e57 of two scans": lambda: e57(POINTS[:20], POINTS[20:]),
}


@pytest.mark.parametrize("write", EXACT.values(), ids=EXACT)
def test_doubles_keep_every_bit_far_from_the_origin(write: Callable[[], bytes]) -> None:
    if write is EXACT["e57 with a shift"]:
        expected = (POINTS - OFFSET) + OFFSET
    else:
        expected = read(npy(POINTS)).points
    cloud = read(write())
    np.testing.assert_array_equal(cloud.points, expected)
    assert cloud.points.dtype == np.float64
    assert cloud.normals is None


STEPPED = {
    "pcd ascii": lambda: pcd(POINTS, "ascii"),
    "e57 of scaled integers": lambda: e57(POINTS, kind="scaled"),
}


@pytest.mark.parametrize("write", STEPPED.values(), ids=STEPPED)
def test_steps_of_a_tenth_of_a_millimeter_survive_offsets_of_a_million(write: Callable[[], bytes]) -> None:
    points = read(write()).points
    # Ten decimals, and scaled integers without the offset, round to other doubles.
    np.testing.assert_allclose(points, POINTS, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(np.rint((points - OFFSET) / STEP), GRID)


@pytest.mark.parametrize("format", range(11))
def test_every_point_format_of_las_is_read(format: int) -> None:
    cloud = read(las(version="1.4" if format > 3 else "1.2", format=format))
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.format == "las"
    if format in (4, 5, 9, 10):  # waveforms, which lazrs does not compress
        return
    cloud = read(laz(version="1.4" if format > 3 else "1.3", format=format))
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.format == "laz"


@pytest.mark.parametrize("name", ["point_format_1.laz", "point_format_6.laz"])
def test_files_of_laszip_are_read(name: str) -> None:
    """Written by LASzip 3.5 from the same points, with a classification and extra bytes."""
    data = Path(__file__).with_name("laszip").joinpath(name).read_bytes()
    cloud = read(data, pick=Pick("auto"))
    np.testing.assert_array_equal(cloud.points, POINTS)
    np.testing.assert_array_equal(cloud.labels, np.arange(60) // 5)
    assert cloud.label_column == "segment"
    np.testing.assert_array_equal(read(data, pick=Pick("classification")).labels, LABELS)


def test_a_las_with_extended_records_is_read() -> None:
    header = laspy.LasHeader(version="1.4", point_format=6)
    header.scales, header.offsets = np.full(3, STEP), OFFSET
    data = laspy.LasData(header)
    data.x, data.y, data.z = POINTS.T
    data.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.VLR("primfit", 7, "a test", bytes(10**5))])
    for compressed in (False, True):
        stream = io.BytesIO()
        data.write(stream, do_compress=compressed)
        np.testing.assert_array_equal(read(stream.getvalue()).points, POINTS)


def test_a_pcd_as_the_point_cloud_library_writes_it() -> None:
    """A comment first, padding, a field of several values, colors packed in a float, two rows of points."""
    head = (
        b"# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z _ rgb histogram _\n"
        b"SIZE 4 4 4 1 4 4 1\nTYPE F F F U F F U\nCOUNT 1 1 1 4 1 3 12\nWIDTH 2\nHEIGHT 2\n"
        b"VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA "
    )
    kinds = [
        ("x", "<f4"),
        ("y", "<f4"),
        ("z", "<f4"),
        ("_", "u1", 4),
        ("rgb", "<f4"),
        ("h", "<f4", 3),
        ("p", "u1", 12),
    ]
    table = np.zeros(4, kinds)
    table["x"], table["y"], table["z"], table["rgb"] = [1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12], 4.2108e06
    expected = np.column_stack([table[name] for name in "xyz"])
    np.testing.assert_array_equal(read(head + b"binary\n" + table.tobytes()).points, expected)
    rows = b"".join(
        b"%d\t%d %d 0 0 0 0 4.2108e+06 0 0 0" % tuple(row) + b" 0" * 12 + b" \r\n" for row in expected
    )
    np.testing.assert_array_equal(read(head + b"ascii\n" + rows).points, expected)


def test_single_precision_is_read_as_it_is() -> None:
    points = GRID * STEP
    for data in (pcd(points, kind="f4"), e57(points, kind="single")):
        np.testing.assert_array_equal(read(data).points, points.astype(np.float32))


def test_a_turned_scan_is_moved_by_its_pose() -> None:
    quarter = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5), 10.0, 20.0, 30.0)
    points = read(e57(np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]), pose=quarter)).points
    np.testing.assert_allclose(points, [[8.0, 21.0, 33.0], [5.0, 24.0, 36.0]], atol=1e-14)


def test_invalid_points_of_an_e57_are_left_out() -> None:
    cloud = read(e57(POINTS, cartesianInvalidState=LABELS % 3, rowIndex=LABELS), pick=Pick("rowIndex"))
    np.testing.assert_array_equal(cloud.points, POINTS[LABELS % 3 == 0])
    np.testing.assert_array_equal(cloud.labels, LABELS[LABELS % 3 == 0])
    assert cloud.dropped == {"not_finite": np.count_nonzero(LABELS % 3)}


def _spherical(points: np.ndarray) -> np.ndarray:
    x, y, z = points.T
    return np.column_stack([np.linalg.norm(points, axis=1), np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))])


def test_spherical_coordinates_of_an_e57_are_turned_into_cartesian_ones() -> None:
    points = GRID * STEP
    cloud = read(e57(_spherical(points), systems=[SPHERICAL]))
    np.testing.assert_allclose(cloud.points, points, rtol=0.0, atol=1e-12)
    assert cloud.columns == SPHERICAL
    pose = (np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5), 10.0, 20.0, 30.0)
    scans, systems = (points[:30], _spherical(points[30:])), (CARTESIAN, SPHERICAL)
    data = e57(*scans, systems=systems, pose=pose, rowIndex=LABELS[:30])
    np.testing.assert_allclose(read(data).points, read(e57(points, pose=pose)).points, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(read(data, pick=Pick("rowIndex")).labels, [*LABELS[:30], *LABELS[:30]])


def test_invalid_spherical_points_of_an_e57_are_left_out() -> None:
    points = GRID * STEP
    cloud = read(e57(_spherical(points), systems=[SPHERICAL], sphericalInvalidState=LABELS % 3))
    np.testing.assert_allclose(cloud.points, points[LABELS % 3 == 0], rtol=0.0, atol=1e-12)
    assert cloud.dropped == {"not_finite": np.count_nonzero(LABELS % 3)}


def test_cartesian_coordinates_are_taken_where_a_scan_of_an_e57_has_both() -> None:
    """The state of the spherical ones does not count then."""
    both = np.hstack([POINTS, _spherical(POINTS)])
    cloud = read(e57(both, systems=[CARTESIAN + SPHERICAL], sphericalInvalidState=LABELS % 3))
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.columns == CARTESIAN


def test_a_scan_of_an_e57_without_coordinates_is_named() -> None:
    data = e57(POINTS, POINTS, systems=[CARTESIAN, ("cartesianX", "cartesianY", "sphericalRange")])
    with pytest.raises(
        UnreadableFileError, match="scan 2 of the E57 file holds neither cartesian nor spherical"
    ):
        read(data)


def test_an_organized_pcd_is_read_without_its_empty_returns() -> None:
    holes = POINTS.copy()
    holes[::4] = np.nan
    for encoding in ("ascii", "binary", "binary_compressed"):
        cloud = without_missing(read(pcd(holes, encoding, label=LABELS), pick=Pick("auto")))
        np.testing.assert_allclose(cloud.points, np.delete(POINTS, np.s_[::4], axis=0), rtol=1e-15)
        np.testing.assert_array_equal(cloud.labels, np.delete(LABELS, np.s_[::4]))
        assert cloud.dropped == {"not_finite": 15, "zero": 0}


LABELLED = {
    "npy": lambda: npy(records(POINTS, label=LABELS)),
    "npy of whole floats": lambda: npy(records(POINTS, label=LABELS.astype("f4"))),
    "npz": lambda: npz(points=POINTS, label=LABELS),
    "npz of records": lambda: npz(points=records(POINTS, label=LABELS.astype("u8"))),
    "ply": lambda: ply((records(POINTS, label=LABELS.astype("i4")), "vertex")),
    "ply ascii": lambda: ply((records(POINTS, label=LABELS.astype("u1")), "vertex"), text=True),
    "pcd": lambda: pcd(POINTS, label=LABELS.astype("u4")),
    "pcd ascii": lambda: pcd(POINTS, "ascii", label=LABELS),
    "pcd compressed": lambda: pcd(POINTS, "binary_compressed", label=LABELS.astype("f4")),
    "las": lambda: las(label=LABELS.astype("i4")),
    "laz": lambda: laz(label=LABELS.astype("u2")),
}


@pytest.mark.parametrize("write", LABELLED.values(), ids=LABELLED)
@pytest.mark.parametrize("wanted", ["auto", "label"])
def test_labels_are_found(write: Callable[[], bytes], wanted: str) -> None:
    cloud = read(write(), pick=Pick(wanted))
    np.testing.assert_array_equal(cloud.labels, LABELS)
    assert cloud.labels is not None and cloud.labels.dtype == np.int64
    assert cloud.label_column == "label"
    np.testing.assert_allclose(cloud.points, POINTS, rtol=0.0, atol=1e-9)
    assert read(write()).labels is None


def test_the_classification_of_a_las_is_a_label_when_asked_for() -> None:
    for version, format in (("1.2", 0), ("1.4", 6)):
        data = las(version=version, format=format, classification=LABELS.astype("u1"))
        np.testing.assert_array_equal(read(data, pick=Pick("classification")).labels, LABELS)
        assert read(data, pick=Pick("auto")).labels is None


def test_labels_of_64_bits_are_exact() -> None:
    labels = LABELS + 2**62
    np.testing.assert_array_equal(read(npy(records(POINTS, label=labels)), pick=Pick("label")).labels, labels)


UNLABELLED = {
    "npy, no such field": (lambda: npy(records(POINTS, part=LABELS)), "labels"),
    "npy without names": (lambda: npy(POINTS), "labels"),
    "npz, no such array": (lambda: npz(points=POINTS, part=LABELS), "labels"),
    "npz, too few": (lambda: npz(points=POINTS, segment=LABELS[:9]), "segment"),
    "npy of fractions": (lambda: npy(records(POINTS, segment=LABELS + 0.5)), "labels[0]"),
    "npy of nan": (lambda: npy(records(POINTS, segment=np.where(LABELS, LABELS, np.nan))), "labels[0]"),
    "npy over 64 bits": (
        lambda: npy(records(POINTS, segment=LABELS.astype("u8") + np.uint64(2**63))),
        "labels[0]",
    ),
    "npy of text": (lambda: npy(records(POINTS, segment=LABELS.astype("U2"))), "labels"),
    "pcd of fractions": (lambda: pcd(POINTS, segment=LABELS / 2), "labels[7]"),
    "las, no such dimension": (las, "labels"),
    "e57, no such field": (lambda: e57(POINTS), "labels"),
}


@pytest.mark.parametrize(("write", "field"), UNLABELLED.values(), ids=UNLABELLED)
def test_labels_that_are_missing_or_no_integers_are_refused(write: Callable[[], bytes], field: str) -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(write(), pick=Pick("segment"))
    assert caught.value.field == field


BESIDE = dict(zip(("normal_x", "normal_y", "normal_z"), NORMALS.T, strict=True))
WITH_NORMALS = {
    "npy": lambda: npy(records(POINTS, **BESIDE)),
    "npz": lambda: npz(points=POINTS, normals=2.0 * NORMALS),
    "ply": lambda: ply((records(POINTS, **BESIDE), "vertex")),
    "pcd": lambda: pcd(POINTS, "binary_compressed", **BESIDE),
    "las": lambda: las(NormalX=NORMALS[:, 0], NormalY=NORMALS[:, 1], NormalZ=NORMALS[:, 2]),
    "laz": lambda: laz(NormalX=NORMALS[:, 0], NormalY=NORMALS[:, 1], NormalZ=NORMALS[:, 2]),
}


@pytest.mark.parametrize("write", WITH_NORMALS.values(), ids=WITH_NORMALS)
def test_normals_are_found(write: Callable[[], bytes]) -> None:
    cloud = read(write())
    np.testing.assert_allclose(cloud.normals, NORMALS, atol=1e-15)
    assert len(cloud.columns) == 6


def test_columns_are_those_of_the_file() -> None:
    assert read(las()).columns == ("X", "Y", "Z")
    assert read(e57(POINTS)).columns == ("cartesianX", "cartesianY", "cartesianZ")
    assert read(npz(points=POINTS, normals=NORMALS)).columns == ("x", "y", "z", "nx", "ny", "nz")


AMBIGUOUS = {
    "two arrays": npz(a=POINTS, b=POINTS),
    "points and xyz": npz(points=POINTS, xyz=POINTS),
    "no array of points": npz(a=POINTS[:, :2], b=LABELS),
    "no arrays": npz(),
    "normals of other points": npz(points=POINTS, normals=NORMALS[:5]),
    "normals of two columns": npz(points=POINTS, normals=NORMALS[:, :2]),
}


@pytest.mark.parametrize("data", AMBIGUOUS.values(), ids=AMBIGUOUS)
def test_an_npz_that_leaves_a_choice_is_refused(data: bytes) -> None:
    with pytest.raises(UnreadableFileError):
        read(data)


@pytest.mark.parametrize("lengths", [np.full(60, 2), LABELS % 4], ids=["of one length", "of any length"])
@pytest.mark.parametrize("text", [False, True])
def test_lists_may_stand_in_and_before_the_vertices_of_a_ply(lengths: np.ndarray, text: bool) -> None:
    """Views and their weights among the coordinates, as photogrammetry writes them, behind uneven faces."""
    names = [("x", "f8"), ("views", "O"), ("y", "f8"), ("weights", "O"), ("z", "f8"), ("label", "i4")]
    table, faces = np.empty(60, names), np.empty(40, [("corners", "O")])
    for name, values in zip(("x", "y", "z", "label"), (*POINTS.T, LABELS), strict=True):
        table[name] = values
    for i, length in enumerate(lengths):
        table["views"][i] = np.arange(length, dtype="i4")
        table["weights"][i] = np.ones(length + i % 2, "f4")
    for i in range(40):
        faces["corners"][i] = np.arange(3 + i % 2, dtype="i4")
    data = ply((faces, "face"), (table, "vertex"), text=text)
    cloud = read(data, pick=Pick("auto"))
    np.testing.assert_array_equal(cloud.points, POINTS)
    np.testing.assert_array_equal(cloud.labels, LABELS)
    for broken in (data[:-5], data.replace(b"element vertex 60", b"element vertex 61")):
        with pytest.raises(UnreadableFileError):
            read(broken)


LISTS = (
    b"ply\nformat %s 1.0\nelement vertex 2\nproperty char x\nproperty list char uchar v\n"
    b"property char y\nproperty char z\nend_header\n"
)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (b"1 2 9 9 2 3\n4 0 5 6\n", None),
        (b"1 2 9 9 2 3\n4 1 5 6\n", "as long as its lists"),
        (b"1 2 9 9 2 3\n4 -1 5 6\n", "start with its length"),
        (b"1 2 9 9 2 3\n4 0 5 6 7\n", "as long as its lists"),
        (b"1 2 9 9 2 3\n", "announces 2 rows"),
    ],
)
def test_rows_of_an_ascii_ply_are_as_long_as_their_lists(rows: bytes, said: str | None) -> None:
    data = LISTS % b"ascii" + rows
    if said is None:
        np.testing.assert_array_equal(read(data).points, [[1, 2, 3], [4, 5, 6]])
        return
    with pytest.raises(UnreadableFileError, match=said):
        read(data)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (b"\1\2xx\2\3\4\0\5\6", None),
        (b"\1\2xx\2\3\4\xff\5\6", "negative length"),
        (b"\1\2xx\2\3\4\1\5\6", "ends within"),
        (b"\1\x7fxx\2\3\4\0\5\6", "ends within"),
        (b"\1\2xx\2\3\4\0\5\6abcd", "4 bytes follow"),
        (b"\1\2xx\2\3", "which need 8 bytes"),
    ],
)
def test_rows_of_a_binary_ply_are_as_long_as_their_lists(rows: bytes, said: str | None) -> None:
    data = LISTS % b"binary_little_endian" + rows
    if said is None:
        np.testing.assert_array_equal(read(data).points, [[1, 2, 3], [4, 5, 6]])
        return
    with pytest.raises(UnreadableFileError, match=said):
        read(data)


def test_lists_of_a_ply_are_read_in_either_order_of_bytes() -> None:
    head = LISTS.replace(b"char x", b"double x").replace(b"list char uchar", b"list ushort float")
    for order, name in (("<", b"binary_little_endian"), (">", b"binary_big_endian")):
        rows = struct.pack(f"{order}dH300fbbdHbb", 1.5, 300, *[7.0] * 300, 2, 3, 4.5, 0, 5, 6)
        np.testing.assert_array_equal(read(head % name + rows).points, [[1.5, 2, 3], [4.5, 5, 6]])


def test_rows_of_lists_are_stepped_over_up_to_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ply_reader, "_LISTS_LIMIT", 1)
    with pytest.raises(UnreadableFileError, match="2 lists in or before the vertices; at most 1 of"):
        read(LISTS % b"binary_little_endian" + b"\1\2xx\2\3\4\0\5\6")


@pytest.mark.parametrize("end", [b"\r", b"\r\n", b"\n"], ids=["old Mac", "Windows", "Unix"])
@pytest.mark.parametrize("x", [1, 10, 13, 2570, 3338])
def test_lines_of_a_ply_end_as_its_first_one(end: bytes, x: int) -> None:
    """Behind the header of a binary one stand bytes that may be ends of lines themselves."""
    head = (
        "ply \nformat  binary_little_endian   1.0 \ncomment in \u00c5 by me\nelement vertex 2\n"
        "property short x\nproperty short y\nproperty short z\nend_header \t\n"
    ).encode()
    points = np.array([[x, 2, 3], [4, 5, 6]])
    binary = head.replace(b"\n", end) + points.astype("<i2").tobytes()
    np.testing.assert_array_equal(read(binary).points, points)
    text = head.replace(b"binary_little_endian", b"ascii") + b"%d 2 3\n4 5 6\n" % x
    np.testing.assert_array_equal(read(text.replace(b"\n", end)).points, points)


def test_a_missing_pye57_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pye57", None)
    with pytest.raises(UnreadableFileError, match="extra e57, which is missing here"):
        read(e57(POINTS))


def test_libraries_are_imported_only_for_their_formats() -> None:
    code = (
        "import sys; from primfit.app.readers import read; read(b'1 2 3\\n')\n"
        "print(sorted({'laspy', 'lazrs', 'lzf', 'pye57', 'scipy'} & sys.modules.keys()))"
    )
    command = [sys.executable, "-c", code]
    assert subprocess.run(command, capture_output=True, check=True, text=True).stdout == "[]\n"


@pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])
@pytest.mark.parametrize("above", [b"# Generated by hand\n", b"\n  # twice\n#\n"])
def test_a_pcd_file_begins_with_any_comment(encoding: str, above: bytes) -> None:
    data = pcd(POINTS, encoding)
    header = data[data.index(b"VERSION") :]
    for file in (above + header, above + header[header.index(b"FIELDS") :]):
        cloud = read(file)
        assert cloud.format == "pcd"
        np.testing.assert_array_equal(cloud.points, read(data).points)


@pytest.mark.parametrize("encoding", ["ascii", "binary"])
@pytest.mark.parametrize("end", [b"\r", b"\r\n"])
def test_lines_of_a_pcd_header_end_in_any_way(encoding: str, end: bytes) -> None:
    data = pcd(POINTS, encoding)
    start = data.index(b"DATA") + len(b"DATA " + encoding.encode() + b"\n")
    rows = data[start:].replace(b"\n", end) if encoding == "ascii" else data[start:]
    np.testing.assert_array_equal(read(data[:start].replace(b"\n", end) + rows).points, read(data).points)


def test_headers_of_old_pcd_files_are_read() -> None:
    """COLUMNS for FIELDS, and POINTS without WIDTH and HEIGHT."""
    head = b"VERSION .5\nCOLUMNS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nPOINTS 2\nDATA ascii\n"
    np.testing.assert_array_equal(read(head + b"1 2 3\n4 5 6\n").points, [[1, 2, 3], [4, 5, 6]])
    for broken in (head.replace(b"TYPE", b"FIELDS x y z\nTYPE"), head.replace(b"POINTS 2", b"WIDTH 2")):
        with pytest.raises(UnreadableFileError):
            read(broken + b"1 2 3\n4 5 6\n")


@pytest.mark.parametrize("word", [b"ply", b"PLY", b"\xef\xbb\xbfply"])
def test_a_ply_is_known_by_its_first_word(word: bytes) -> None:
    data = word + ply((records(POINTS), "vertex")).removeprefix(b"ply")
    cloud = read(data)
    assert cloud.format == "ply"
    np.testing.assert_array_equal(cloud.points, POINTS)


def test_many_variable_length_records_are_stepped_over(monkeypatch: pytest.MonkeyPatch) -> None:
    data = laspy.read(io.BytesIO(las()))
    data.header.vlrs.extend(laspy.VLR("primfit", number, "a test", bytes(60_000)) for number in range(20))
    stream = io.BytesIO()
    data.write(stream)
    np.testing.assert_array_equal(read(stream.getvalue()).points, read(las()).points)
    monkeypatch.setattr(las_header, "_RECORDS_LIMIT", 10**6)
    with pytest.raises(UnreadableFileError, match="records"):
        read(stream.getvalue())


MUTATED = [
    npz(points=POINTS),
    pcd(POINTS),
    pcd(POINTS, "binary_compressed"),
    las(),
    laz(),
    laz(version="1.2", format=3),
]


@settings(max_examples=200, deadline=None)
@given(data=st.data())
def test_mutated_files_are_read_or_refused_and_never_crash(data: st.DataObject) -> None:
    whole = bytearray(data.draw(st.sampled_from(MUTATED)))
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(whole)))
        end = start + data.draw(st.integers(0, 20))
        whole[start:end] = data.draw(st.binary(max_size=20) | st.just(b"\xff" * 8))
    with suppress(UnreadableFileError):
        assert np.isfinite(
            without_missing(read(bytes(whole), Limits(points=1000, unpacked_bytes=2**20))).points
        ).all()


@pytest.mark.parametrize("change", [("<f8", "<f4"), ("<f8", ">f8"), ("False", "True ")])
def test_a_header_that_came_before_is_not_taken_for_another_one(change: tuple[str, str]) -> None:
    """Arrays of as many bytes in the header, and of the same bytes behind it, but for the one word."""
    points = np.arange(12.0).reshape(4, 3) ** 2
    stream = io.BytesIO()
    np.save(stream, points)
    whole = stream.getvalue()
    for _ in range(2):
        np.testing.assert_array_equal(read(whole).points, points)
    other = whole.replace(change[0].encode(), change[1].encode())
    if change[1] == "<f4":
        other = other[: -points.nbytes // 2]
    for _ in range(2):
        np.testing.assert_array_equal(read(other).points, np.load(io.BytesIO(other)).astype(float))
    with pytest.raises(UnreadableFileError):
        read(whole[:-1])
