"""What is not read, told by its first bytes: its name, and what to do instead where that is known.

Only what its bytes leave no doubt about: whatever is not here is read as text.
"""

import re

_EXPORT = "export the cloud as PLY, LAS or E57"
_MESH = "export the mesh as PLY, STL or OBJ"
_DRAWING = "a drawing ({}): export the points as CSV or XYZ"
_RASTER = "an image, or a raster of heights (TIFF): export it as XYZ"
_UNPACK = "unpack it first"
_SIGNATURES = {
    b"\x1f\x8b": "compressed twice; one level is unpacked",
    b"\x28\xb5\x2f\xfd": "compressed twice; one level is unpacked",
    b"\x80\x02": "a Python pickle",
    b"\x80\x03": "a Python pickle",
    b"\x80\x04": "a Python pickle",
    b"\x80\x05": "a Python pickle",
    b"Rar!\x1a\x07": f"a RAR archive: {_UNPACK}",
    b"7z\xbc\xaf\x27\x1c": f"a 7-Zip archive: {_UNPACK}",
    b"\xfd7zXZ\0": f"compressed by xz: {_UNPACK}",
    b"BZh91AY&SY": f"compressed by bzip2: {_UNPACK}",
    b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1": "an old Office document (XLS, DOC): save the sheet as CSV",
    b"%PDF": "a PDF document",
    b"\x89PNG\r\n\x1a\n": "an image (PNG)",
    b"\xff\xd8\xff": "an image (JPEG)",
    b"GIF8": "an image (GIF)",
    b"II*\0": _RASTER,
    b"MM\0*": _RASTER,
    b"II+\0": _RASTER,
    b"SQLite format 3\0": "an SQLite database: export the table as CSV",
    b"\x89HDF\r\n\x1a\n": "an HDF5 file: save the array of the points as NPY",
    b"PAR1": "a Parquet table: export it as CSV",
    b"ARROW1": "an Arrow table: export it as CSV",
    b"CCB2": f"a project of CloudCompare (BIN): {_EXPORT}",
    b"#ROSBAG ": "a ROS bag: export its clouds as PCD",
    b"DRACO": f"compressed by Draco: {_EXPORT}",
    b"# vtk DataFile": f"a VTK file: {_EXPORT}",
    b"<VTKFile": f"a VTK file: {_EXPORT}",
    b"AutoCAD Binary DXF": _DRAWING.format("DXF"),
    b"ISO-10303-21;": "a CAD model (STEP), which holds no points of a scan",
    b"3D Geometry File Format": f"a Rhino model (3DM): {_MESH}",
    b"Kaydara FBX Binary": f"an FBX scene: {_MESH}",
    b"BLENDER": f"a Blender scene: {_MESH}",
    b"$MeshFormat": f"a mesh of Gmsh: {_MESH}",
    b"version https://git-lfs.": "a pointer of Git LFS in place of the file: fetch it (git lfs pull)",
}
_SHAPES = (
    (rb"AC10\d\d\0", _DRAWING.format("DWG")),
    (rb"(?:[ \t]*999[ \t]*\r?\n.*\n)*[ \t]*0[ \t]*\r?\n[ \t]*SECTION\s", _DRAWING.format("DXF")),
    (rb".{72}S[ 0]*1[ \t]*[\r\n]", "a CAD model (IGES), which holds no points of a scan"),
    (rb"MATLAB \d\.\d MAT-file", "a MATLAB file: write the matrix of the points as text (writematrix)"),
    (rb"C?N?OFF\s++(?:#.*+\s++)*+\d+\s+\d+\s+\d+\s", f"a mesh (OFF): {_MESH}"),
    (rb"(?i)\s*(?:<!doctype html|<html)", "a web page (HTML): is it the file itself that was fetched?"),
    (rb"\s*<\?xml", "an XML document: export the points as CSV or PLY"),
    (rb"(?s).{257}ustar", f"a TAR archive: {_UNPACK}"),
)  # fmt: skip
_PATTERNS = tuple((re.compile(pattern), name) for pattern, name in _SHAPES)
_LOOKED_AT = 1024
# Names of members tell what a ZIP archive is; its directory is at its end.
_DIRECTORY = 64 * 1024
_MEMBERS = {
    b"xl/workbook.": "an Excel workbook (XLSX): save the sheet as CSV",
    b"word/document.": "a Word document (DOCX): save the points as plain text",
    b"3D/3dmodel.model": f"a 3MF model: {_MESH}",
    b".kml": "a map (KMZ)",
    b"/data.pkl": "a PyTorch file: save the points as NPY",
}
_ODS = b"mimetypeapplication/vnd.oasis.opendocument.spreadsheet"


def foreign_name(data: memoryview) -> str | None:
    """What a file is that begins like none that is read, or None where its first bytes do not tell."""
    head = bytes(data[:_LOOKED_AT])
    for signature, name in _SIGNATURES.items():
        if head.startswith(signature):
            return name
    return next((name for pattern, name in _PATTERNS if pattern.match(head)), None)


def name_of_zip(data: memoryview) -> str | None:
    """What a ZIP archive without arrays is, or None where its members do not tell."""
    directory = bytes(data[-_DIRECTORY:])
    if b".npy" in directory:
        return None
    if _ODS in bytes(data[:_LOOKED_AT]):
        return "a table of OpenDocument (ODS): save the sheet as CSV"
    return next((name for member, name in _MEMBERS.items() if member in directory), None)
