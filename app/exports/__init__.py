"""The recognised primitive, trimmed to its extents, as files of other programs: one file a format."""

from collections.abc import Callable
from dataclasses import dataclass
from io import BytesIO
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from app.exports.mesh import mesh_writer
from app.exports.options import ExportOptions
from app.exports.patch import NothingToExportError
from app.exports.step import step
from app.exports.text import csv, shrec22
from fitting.errors import InvalidOptionError
from fitting.result import Recognition

__all__ = ["FORMATS", "ExportOptions", "Format", "NothingToExportError", "Wanted", "bundle", "export"]


@dataclass(frozen=True)
class Format:
    """How a format is written, and the name of its file in a bundle."""

    write: Callable[[Recognition, ExportOptions], bytes]
    file_name: str


FORMATS: dict[str, Format] = {
    "step": Format(step, "primitive.step"),
    "glb": Format(mesh_writer("glb"), "primitive.glb"),
    "obj": Format(mesh_writer("obj"), "primitive.obj"),
    "stl": Format(mesh_writer("stl"), "primitive.stl"),
    "ply": Format(mesh_writer("ply"), "primitive.ply"),
    "csv": Format(csv, "primitive.csv"),
    "shrec22": Format(shrec22, "primitive_prediction.txt"),
}


@dataclass(frozen=True)
class Wanted:
    """The artefacts that were asked for beside an answer."""

    formats: tuple[str, ...]
    options: ExportOptions


def export(recognition: Recognition, format: str, *, unit: str = "mm", chord_error: float = 1e-3) -> bytes:
    """The trimmed primitive as a file; of an ambiguous answer the first one.

    Parameters
    ----------
    format : a key of `FORMATS`
    unit : of the coordinates: `mm`, `m` or `inch`; said in STEP files
    chord_error : largest distance of a mesh from the surface, as a share of the size, in [1e-5, 0.1]

    Raises
    ------
    InvalidOptionError
        An unknown format or unit, or a chord error out of range.
    NothingToExportError
        No primitive, or no extents to trim it to.
    """
    if format not in FORMATS:
        raise InvalidOptionError(f"the format is unknown; allowed are {', '.join(FORMATS)}", "artifacts")
    return FORMATS[format].write(recognition, ExportOptions(unit, chord_error))  # type: ignore[arg-type]


def bundle(answer: bytes, recognition: Recognition, wanted: Wanted) -> bytes:
    """A ZIP of `answer.json` and one file a format; the same input gives the same bytes."""
    stream = BytesIO()
    with ZipFile(stream, "w", ZIP_DEFLATED) as archive:
        archive.writestr(_entry("answer.json"), answer)
        for format in wanted.formats:
            content = FORMATS[format].write(recognition, wanted.options)
            archive.writestr(_entry(FORMATS[format].file_name), content)
    return stream.getvalue()


def _entry(name: str) -> ZipInfo:
    entry = ZipInfo(name)
    entry.compress_type = ZIP_DEFLATED
    return entry
