"""Every format gives the same points; columns are found; what is ambiguous or broken is named."""

import gzip
import io
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
import plyfile
import pytest
import trimesh
import zstandard
from hypothesis import given, settings
from hypothesis import strategies as st

from primfit.app.readers import (
    InvalidPointsError,
    Limits,
    TooLargeError,
    UnreadableFileError,
    read,
    without_missing,
)

POINTS = np.random.default_rng(3).normal(size=(50, 3)) * 100.0 + [1e6, -2e6, 3.0]


def _text(delimiter: str, header: str = "", end: str = "\n") -> bytes:
    rows = [delimiter.join(repr(float(value)) for value in row) for row in POINTS]
    return end.join([header, *rows] if header else rows).encode()


def _npy(array: np.ndarray, **options: Any) -> bytes:
    stream = io.BytesIO()
    np.save(stream, array, **options)
    return stream.getvalue()


def _npy_claiming(shape: tuple[int, ...]) -> bytes:
    stream = io.BytesIO()
    header = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(stream, header)
    return stream.getvalue() + bytes(240)


def _ply(text: bool, order: str = "<", faces: bool = False) -> bytes:
    names = [("x", "f8"), ("y", "f8"), ("z", "f8"), ("red", "u1")]
    vertices = np.array([(*row, 7) for row in POINTS], dtype=names)
    elements = [plyfile.PlyElement.describe(vertices, "vertex")]
    if faces:
        faces_of = np.array([([0, 1, 2],)], dtype=[("vertex_indices", "i4", (3,))])
        elements.append(plyfile.PlyElement.describe(faces_of, "face"))
    stream = io.BytesIO()
    plyfile.PlyData(elements, text=text, byte_order="=" if text else order).write(stream)
    return stream.getvalue()


SAME = {
    "csv": lambda: _text(","),
    "csv with header": lambda: _text(",", "x,y,z"),
    "csv with a delimiter at the end": lambda: _text(",").replace(b"\n", b",\n"),
    "csv with quotes": lambda: _text(",", '"X [mm]","Y [mm]","Z [mm]"'),
    "csv with a byte order mark": lambda: b"\xef\xbb\xbf" + _text(",", "x,y,z"),
    "csv of Windows": lambda: _text(",", "x,y,z", "\r\n"),
    "csv of an old Mac": lambda: _text(",", "x,y,z", "\r"),
    "comma and space": lambda: _text(", "),
    "semicolon": lambda: _text(";", "x;y;z"),
    "tab": lambda: _text("\t"),
    "spaces": lambda: _text("   "),
    "comments": lambda: b"# a scan\n// of a part\n" + _text(" ").replace(b"\n", b" # hit\n\n// next\n", 1),
    "header in a comment": lambda: _text(" ", "//X Y Z"),
    "npy": lambda: _npy(POINTS),
    "npy in Fortran order": lambda: _npy(np.asfortranarray(POINTS)),
    "npy big-endian": lambda: _npy(POINTS.astype(">f8")),
    "npy of four columns": lambda: _npy(np.column_stack([POINTS, POINTS[:, 0]])),
    "ply ascii": lambda: _ply(True),
    "ply little-endian": lambda: _ply(False),
    "ply big-endian": lambda: _ply(False, ">"),
    "ply with faces": lambda: _ply(False, faces=True),
    "ply ascii with faces": lambda: _ply(True, faces=True),
    "json": lambda: b'{"points": ' + str(POINTS.tolist()).encode() + b"}",
}


@pytest.mark.parametrize("write", SAME.values(), ids=SAME)
def test_formats_give_the_same_points_to_the_last_digit(write: Callable[[], bytes]) -> None:
    cloud = read(write())
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.points.dtype == np.float64
    assert cloud.normals is None


def test_records_are_read_by_name() -> None:
    names = [("id", "S3"), ("Z", "f8"), ("x", "f4"), ("y", "i4")]
    cloud = read(_npy(np.array([(b"a", 3.5, 1.5, 2), (b"b", 6.5, 4.5, 5)], dtype=names)))
    np.testing.assert_array_equal(cloud.points, [[1.5, 2, 3.5], [4.5, 5, 6.5]])
    assert cloud.columns == ("x", "y", "Z")


def test_columns_are_found_in_any_place_and_normals_are_picked_up() -> None:
    cloud = read(b"label;nz;X;ny;Z;nx;Y\nwall a;2;1;0;3;0;2\nwall b;0;4;0;6;-3;5\n")
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3], [4, 5, 6]])
    np.testing.assert_array_equal(cloud.normals, [[0, 0, 1], [-1, 0, 0]])
    assert cloud.columns == ("X", "Y", "Z", "nx", "ny", "nz")


def test_normals_without_direction_are_left_alone() -> None:
    cloud = read(b"x y z nx ny nz\n1 2 3 0 0 1\n4 5 6 0 0 0\n")
    assert cloud.normals is None
    assert cloud.columns == ("x", "y", "z")


def test_normals_of_a_ply_are_picked_up() -> None:
    names = [(name, "f4") for name in ("nx", "ny", "nz", "x", "y", "z")]
    stream = io.BytesIO()
    vertices = np.array([(0, 0, 2, 1, 2, 3)], dtype=names)
    plyfile.PlyData([plyfile.PlyElement.describe(vertices, "vertex")]).write(stream)
    cloud = read(stream.getvalue())
    np.testing.assert_array_equal(cloud.points, [[1, 2, 3]])
    np.testing.assert_array_equal(cloud.normals, [[0, 0, 1]])


PLY = (
    b"ply\nformat ascii 1.0\nelement vertex %s\n"
    b"property float x\nproperty float y\nproperty float z\nend_header\n"
)
PLY_BINARY = PLY.replace(b"ascii", b"binary_little_endian")
NPY = _npy(POINTS)
BROKEN = {
    "empty": (b"", "file"),
    "only a header": (b"x,y,z\n", "file"),
    "only comments": (b"# nothing\n", "file"),
    "binary garbage": (bytes(range(256)), "file"),
    "half a character of utf-16": ("1 2 3\n".encode("utf-16")[:-1], "file"),
    "las": (b"LASF" + bytes(400), "header"),
    "npz": (b"PK\x03\x04" + bytes(400), "file"),
    "pickle": (b"\x80\x04\x95" + bytes(40), "file"),
    "two columns": (b"1,2\n3,4\n", "file"),
    "header without z": (b"x,y,depth\n1,2,3\n", "header"),
    "header with two x": (b"x,X,y,z\n1,2,3,4\n", "header"),
    "header shorter than rows": (b"x,y,z\n1,2,3,4\n", "header"),
    "decimal comma and point": (b"x;y;z\n1,5;2,5;3.5\n", "file"),
    "decimal comma and thousands": (b"x;y;z\n1.000,5;2,5;3,5\n", "line 2, column 1"),
    "decimal comma or six columns": (b"1,5,2,5,3,5\n1,6,2,6,3,6\n", "file"),
    "decimal comma or seven columns": (b"1,5,-2,5,3,5,217\n1,6,2,6,3,6,69\n", "file"),
    "short row": (b"1,2,3\n4,5\n", "line 2"),
    "long row": (b"# hm\n1 2 3\n4 5 6 7\n", "line 3"),
    "word": (b"1,2,3\n4,five,6\n", "line 2, column 2"),
    "underscore in a number": (b"1,2,3\n1_000,5,6\n", "line 2, column 1"),
    "endless line": (b"1 " * 100_000, "line 1"),
    "npy one byte short": (NPY[:-1], "file"),
    "npy one byte long": (NPY + b"\0", "file"),
    "npy cut in the header": (NPY[:40], "file"),
    "npy of objects": (_npy(np.array([[1, 2, None]]), allow_pickle=True), "dtype"),
    "npy of booleans": (_npy(np.ones((4, 3), bool)), "dtype"),
    "npy of complex numbers": (_npy(np.ones((4, 3), complex)), "dtype"),
    "npy of text": (_npy(np.full((4, 3), "one")), "dtype"),
    "npy of one dimension": (_npy(np.ones(9)), "shape"),
    "npy of two columns": (_npy(np.ones((9, 2))), "shape"),
    "npy transposed": (_npy(np.ones((3, 50))), "shape"),
    "npy of four long rows": (_npy(np.ones((4, 50))), "shape"),
    "npy of channels": (_npy(np.ones((3, 20, 30))), "shape"),
    "npy of four dimensions": (_npy(np.ones((3, 3, 3, 3))), "shape"),
    "npy claiming 10^12 points": (_npy_claiming((10**12, 3)), "file"),
    "npy claiming 10^30 points": (_npy_claiming((10**30, 3)), "file"),
    "npy with a negative length": (_npy_claiming((-50, 3)), "shape"),
    "npy with a header of 1 MB": (b"\x93NUMPY\x02\x00\x40\x42\x0f\x00" + b" " * 10**6, "file"),
    "npy with a nested header": (b"\x93NUMPY\x01\x00\xff\xff" + b"(" * 65535, "file"),
    "ply without end": (b"ply\n" + b"comment x\n" * 10_000, "header"),
    "ply without vertices": (b"ply\nformat ascii 1.0\nend_header\n", "header"),
    "ply without format": (b"ply\nelement vertex 1\nproperty float x\nend_header\n", "header"),
    "ply without z": (PLY.replace(b"property float z\n", b"") % b"1" + b"1 2\n", "header"),
    "ply of unknown type": (PLY.replace(b"float z", b"quad z") % b"1" + b"1 2 3\n", "header"),
    "ply claiming 10^12 vertices": (PLY_BINARY % b"1000000000000" + bytes(120), "file"),
    "ply ascii claiming 10^12 vertices": (PLY % b"1000000000000" + b"1 2 3\n" * 9, "file"),
    "ply claiming -1 vertices": (PLY_BINARY % b"-1" + bytes(120), "header"),
    "ply one byte short": (PLY_BINARY % b"10" + bytes(119), "file"),
    "ply ascii one row short": (PLY % b"3" + b"1000 2000 3000\n4000 5000 6000\n", "vertex"),
    "ply ascii with a word": (PLY % b"1" + b"1 two 3\n", "vertex"),
    "ply ascii with a ragged row": (PLY % b"2" + b"1 2 3\n1 2 3 4\n", "vertex"),
}


@pytest.mark.parametrize(("data", "field"), BROKEN.values(), ids=BROKEN)
def test_broken_input_is_refused_and_the_place_named(data: bytes, field: str) -> None:
    with pytest.raises(UnreadableFileError) as caught:
        read(data, limits=Limits(points=10**31))
    assert caught.value.field == field


@pytest.mark.parametrize(
    "data",
    [_text(","), NPY, _ply(False), _ply(True), PLY_BINARY % b"99999999999" + bytes(120)],
    ids=["text", "npy", "ply", "ply ascii", "lying ply"],
)
def test_too_many_points_are_refused(data: bytes) -> None:
    with pytest.raises(TooLargeError, match="limit is 49"):
        read(data, limits=Limits(points=49))


def test_at_most_twenty_errors_are_kept_and_all_are_counted() -> None:
    with pytest.raises(InvalidPointsError, match="1000 rows") as caught:
        read(b"1,2,3\n" + b"4,x,6\n" * 1000)
    assert len(caught.value.errors) == 20


def test_an_unpickled_array_never_runs_code() -> None:
    class Canary:
        def __reduce__(self) -> tuple[Any, ...]:
            return pytest.fail, ("the pickle was loaded",)

    with pytest.raises(UnreadableFileError):
        read(_npy(np.array([[Canary(), 2, 3]], dtype=object), allow_pickle=True))


BALL = trimesh.creation.icosphere(subdivisions=1)
WHOLE = [_text(","), _text(" ", "x y z"), b"50\n" + _text(" "), NPY, _ply(False), _ply(True)]
WHOLE += [BALL.export(file_type=kind) for kind in ("stl", "glb")]
WHOLE += [BALL.export(file_type=kind).encode() for kind in ("stl_ascii", "obj")]
WHOLE += [b'{"points": ' + str(POINTS.tolist()).encode() + b', "options": {"seed": 1}}']
WHOLE += [gzip.compress(NPY), zstandard.compress(NPY)]


@settings(max_examples=300, deadline=None)
@given(data=st.data())
def test_mutated_files_are_read_or_refused_and_never_crash(data: st.DataObject) -> None:
    whole = bytearray(data.draw(st.sampled_from(WHOLE)))
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, min(len(whole), 400)))
        end = start + data.draw(st.integers(0, 20))
        letters = st.text('0123456789-+e., \n#ply[]{}:"', max_size=20).map(str.encode)
        whole[start:end] = data.draw(st.binary(max_size=20) | letters)
    with suppress(UnreadableFileError):
        assert np.isfinite(without_missing(read(bytes(whole), limits=Limits(points=1000))).points).all()


def test_npy_of_python_2_is_read_without_a_warning() -> None:
    data = _npy(np.arange(12.0).reshape(4, 3)).replace(b"(4, 3), }  ", b"(4L, 3L), }")
    assert read(data).points.shape == (4, 3)
