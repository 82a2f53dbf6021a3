"""Files of other programs are told what they are, and what to export in their place."""

import io
import sqlite3
import tarfile
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
import pytest

from primfit.app.readers import UnreadableFileError, read
from tests.app.readers.written import POINTS, npz


def zipped(*names: str, content: bytes = b"content") -> bytes:
    stream = io.BytesIO()
    with ZipFile(stream, "w", ZIP_DEFLATED) as archive:
        for name in names:
            archive.writestr(name, content)
    return stream.getvalue()


def ods() -> bytes:
    stream = io.BytesIO()
    with ZipFile(stream, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", "<?xml version='1.0'?>")
    return stream.getvalue()


def tar() -> bytes:
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w") as archive:
        archive.addfile(tarfile.TarInfo("cloud.csv"), io.BytesIO(b""))
    return stream.getvalue()


def sqlite() -> bytes:
    with sqlite3.connect(":memory:") as connection:
        connection.execute("create table points (x, y, z)")
        return connection.serialize()


FOREIGN = {
    "xlsx": (zipped("[Content_Types].xml", "xl/workbook.xml"), "Excel workbook .* save the sheet as CSV"),
    "xlsx of many sheets": (zipped(*(f"xl/{k}.xml" for k in range(150)), "xl/workbook.xml"), "Excel"),
    "docx": (zipped("[Content_Types].xml", "word/document.xml"), "Word document"),
    "3mf": (zipped("[Content_Types].xml", "3D/3dmodel.model"), "3MF .* export the mesh"),
    "kmz": (zipped("doc.kml"), "KMZ"),
    "torch": (zipped("points/data.pkl", "points/version"), "PyTorch"),
    "ods": (ods(), "ODS.* save the sheet as CSV"),
    "zip": (zipped("scan.csv"), "ZIP archive without arrays; unpack it"),
    "tar": (tar(), "TAR archive"),
    "sqlite": (sqlite(), "SQLite database"),
    "xls": (bytes.fromhex("d0cf11e0a1b11ae1") + bytes(504), "XLS.* save the sheet as CSV"),
    "pdf": (b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n", "PDF"),
    "png": (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "PNG"),
    "jpeg": (b"\xff\xd8\xff\xe0\0\x10JFIF", "JPEG"),
    "tiff": (b"II*\0\x08\0\0\0", "raster of heights"),
    "hdf5": (b"\x89HDF\r\n\x1a\n\0", "HDF5"),
    "matlab": (b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + b" " * 86, "MATLAB"),
    "dwg": (b"AC1032\0\0\0\0\0", "DWG"),
    "dxf": (b"  0\r\nSECTION\r\n  2\r\nHEADER\r\n", "DXF"),
    "dxf with a comment": (b"999\nby hand\n0\nSECTION\n2\nENTITIES\n", "DXF"),
    "step": (b"ISO-10303-21;\nHEADER;\n", "STEP"),
    "iges": (b"a part".ljust(72) + b"S      1\n" + b"1H,,1H;".ljust(72) + b"G      1\n", "IGES"),
    "off": (b"OFF\n8 6 12\n0 0 0\n0 0 1\n", "OFF.* export the mesh"),
    "off with a comment": (b"COFF\n# a box\n8 6 12\n0 0 0 9 9 9\n", "OFF"),
    "vtk": (b"# vtk DataFile Version 3.0\ncloud\nASCII\nDATASET POLYDATA\nPOINTS 2 float\n1 2 3\n", "VTK"),
    "html": (b"\n<!DOCTYPE html>\n<html>", "web page"),
    "xml": (b"\xef\xbb\xbf<?xml version='1.0'?><kml/>", "XML"),
    "xml in utf-16": ("<?xml version='1.0' encoding='utf-16'?>".encode("utf-16"), "XML"),
    "git lfs": (b"version https://git-lfs.example/spec/v1\noid sha256:0\nsize 12\n", "git lfs pull"),
    "cloudcompare": (b"CCB2\0\0\0\1", "export the cloud as PLY"),
}  # fmt: skip


@pytest.mark.parametrize(("data", "said"), FOREIGN.values(), ids=FOREIGN)
def test_a_file_that_is_not_read_is_named(data: bytes, said: str) -> None:
    with pytest.raises(UnreadableFileError, match=said) as caught:
        read(data)
    assert caught.value.field == "file"


@pytest.mark.parametrize("title", ["OFF axis", "MATLAB export", "AC10 x", "0"])
def test_a_title_does_not_make_a_text_foreign(title: str) -> None:
    np.testing.assert_array_equal(read(f"{title}\n1 2 3\n4 5 6\n".encode()).points, [[1, 2, 3], [4, 5, 6]])


def test_an_npz_is_read_whatever_else_its_members_are_called() -> None:
    np.testing.assert_array_equal(read(npz(points=POINTS, **{"a.kml": np.zeros(3)})).points, POINTS)
