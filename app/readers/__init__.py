"""Bytes to `Cloud`, by content and never by name.

A new format is one file, one entry of `FORMATS`, and one line in `_SIGNATURES`, or in `_SHAPES` where it has
no signature.
"""

from os import PathLike
from pathlib import Path

from .cloud import Cloud
from .columns import FOUND, Pick
from .e57 import read_e57
from .errors import FieldError, InvalidPointsError, TooLargeError, UnreadableFileError
from .foreign import foreign_name
from .formats import FORMATS, NAMES
from .glb import read_glb
from .json_points import read_json
from .las import read_las
from .limits import UNLIMITED, Limits
from .lines import BOM, check_line_ends
from .missing import without_missing
from .npy import read_npy
from .npz import read_npz
from .obj import is_obj, read_obj
from .packed import CODINGS, coding_of, unpack
from .pcd import is_pcd, read_pcd
from .ply import read_ply
from .ptx import is_ptx, read_ptx
from .stl import is_stl, read_stl
from .text import read_text

__all__ = [
    "CODINGS",
    "FORMATS",
    "Cloud",
    "FieldError",
    "InvalidPointsError",
    "Limits",
    "Pick",
    "TooLargeError",
    "UnreadableFileError",
    "read",
    "read_file",
    "read_json",
    "read_unpacked",
    "unpack",
    "without_missing",
]

_SIGNATURES = {
    b"\x93NUMPY": read_npy,
    b"PK\x03\x04": read_npz,
    b"PK\x05\x06": read_npz,
    b"ply\n": read_ply,
    b"PLY\n": read_ply,
    b"ply\r": read_ply,
    b"ply ": read_ply,
    b"# .PCD": read_pcd,
    b"LASF": read_las,
    b"ASTM-E57": read_e57,
    b"glTF": read_glb,
}
_UTF_16 = (b"\xff\xfe", b"\xfe\xff")
_SHAPES = ((is_stl, read_stl), (is_pcd, read_pcd), (is_ptx, read_ptx), (is_obj, read_obj))


def read(data: bytes | memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read a cloud of any of the `FORMATS`, be it packed by gzip or zstd, or not.

    Points may be missing in it, which `app.readers.missing` drops.

    Raises `UnreadableFileError`, or of its kinds `InvalidPointsError` and `TooLargeError`.
    """
    view = memoryview(data)
    coding = coding_of(view)
    return read_unpacked(view if coding is None else unpack(view, coding, limits), limits, pick)


def read_unpacked(data: memoryview, limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """`read` of what has been unpacked, or must not be packed."""
    data = data[len(BOM) :] if data[: len(BOM)] == BOM else data
    start = bytes(data[:16])
    for signature, reader in _SIGNATURES.items():
        if start.startswith(signature):
            return reader(data, limits, pick)
    if start.startswith(_UTF_16):
        return read_unpacked(_in_utf_8(data), limits, pick)
    if (name := foreign_name(data)) is not None:
        raise UnreadableFileError("file", f"the file is {name}; what is read: {NAMES}")
    if start.lstrip()[:1] in (b"{", b"["):
        return read_json(data, limits, pick)
    check_line_ends(data)
    for is_one, reader in _SHAPES:
        if is_one(data):
            return reader(data, limits, pick)
    return read_text(data, limits, pick)


def _in_utf_8(data: memoryview) -> memoryview:
    """Text in UTF-16, which begins with a byte order mark."""
    try:
        return memoryview(str(data, "utf-16").encode())
    except UnicodeDecodeError:
        raise UnreadableFileError("file", "the file begins as text in UTF-16, but is none") from None


def read_file(path: str | PathLike[str], limits: Limits = UNLIMITED, pick: Pick = FOUND) -> Cloud:
    """Read a cloud from a file; `OSError` where it cannot be opened."""
    return read(Path(path).read_bytes(), limits, pick)
