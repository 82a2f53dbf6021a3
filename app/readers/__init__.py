"""Bytes to `Cloud`, by content and never by name.

A new format is one file, one line in `_SIGNATURES` and one in `FORMATS`.
"""

from dataclasses import dataclass
from pathlib import Path

from app.readers.cloud import Cloud
from app.readers.errors import FieldError, InvalidPointsError, TooLargeError, UnreadableFileError
from app.readers.json_points import read_json
from app.readers.limits import UNLIMITED, Limits
from app.readers.npy import read_npy
from app.readers.ply import read_ply
from app.readers.text import read_text

__all__ = [
    "FORMATS",
    "Cloud",
    "FieldError",
    "Format",
    "InvalidPointsError",
    "Limits",
    "TooLargeError",
    "UnreadableFileError",
    "read",
    "read_file",
    "read_json",
]


@dataclass(frozen=True)
class Format:
    """A format as it is told to clients; files are recognised by what they hold, whatever they are called."""

    name: str
    how: str
    extensions: tuple[str, ...]
    media_types: tuple[str, ...]


FORMATS = (
    Format(
        "text",
        "one point a line, cut by comma, semicolon, tab or white space; an optional header",
        (".csv", ".txt", ".xyz"),
        ("text/csv", "text/plain", "text/tab-separated-values"),
    ),
    Format(
        "npy", "an array (N, 3) or wider, or records with fields x, y, z", (".npy",), ("application/x-npy",)
    ),
    Format("ply", "x, y, z of the vertices, ascii or binary", (".ply",), ("model/ply", "application/ply")),
    Format("json", "an object with points [[x, y, z], ...]", (".json",), ("application/json",)),
)
_SIGNATURES = {b"\x93NUMPY": read_npy, b"ply\n": read_ply, b"ply\r": read_ply}
_UNSUPPORTED = {
    b"PK\x03\x04": "a ZIP archive (NPZ?)",
    b"\x1f\x8b": "compressed by gzip",
    b"\x28\xb5\x2f\xfd": "compressed by zstd",
    b"LASF": "LAS or LAZ",
    b"ASTM-E57": "E57",
    b"# .PCD": "PCD",
    b"glTF": "GLB",
    b"\x80\x03": "a Python pickle",
    b"\x80\x04": "a Python pickle",
    b"\x80\x05": "a Python pickle",
    b"\xff\xfe": "text in UTF-16; save it as UTF-8",
    b"\xfe\xff": "text in UTF-16; save it as UTF-8",
}


def read(data: bytes | memoryview, limits: Limits = UNLIMITED, labels: str | None = None) -> Cloud:
    """Read a cloud of any known format: CSV, XYZ, TXT, NPY, PLY, or JSON with `points`.

    `labels` names the column that tells segments apart; with `AUTO_LABELS` one of the usual names is looked
    for, and may be missing; with None none is read.

    Raises `UnreadableFileError`, or of its kinds `InvalidPointsError` and `TooLargeError`.
    """
    view = memoryview(data)
    start = bytes(view[:16])
    for signature, reader in _SIGNATURES.items():
        if start.startswith(signature):
            return reader(view, limits, labels)
    for signature, name in _UNSUPPORTED.items():
        if start.startswith(signature):
            raise UnreadableFileError(
                "file", f"the file is {name}; CSV, XYZ, TXT, NPY, PLY and JSON are read"
            )
    if start.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] in (b"{", b"["):
        return read_json(view, limits)
    return read_text(view, limits, labels)


def read_file(path: str | Path, limits: Limits = UNLIMITED, labels: str | None = None) -> Cloud:
    """Read a cloud from a file; `OSError` where it cannot be opened."""
    return read(Path(path).read_bytes(), limits, labels)
