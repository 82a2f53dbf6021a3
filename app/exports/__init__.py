"""The recognised primitive, its residuals and the report as files: one file a format."""

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from io import BytesIO
from typing import Any, overload
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidOptionError

from .fitted import Fitted, NothingToExportError, check_extents, fitted_points, form_errors, residuals
from .form import form_json
from .mesh import mesh_writer
from .options import ExportOptions
from .report import html_report
from .residual_files import residuals_csv, residuals_las, residuals_npy, residuals_ply
from .step import step
from .text import csv, shrec22

__all__ = [
    "FORMATS",
    "ExportOptions",
    "Fitted",
    "Format",
    "NothingToExportError",
    "Wanted",
    "bundle",
    "check_parts",
    "export",
    "form_errors",
    "residuals",
    "write",
]


@dataclass(frozen=True)
class Format:
    """How a format is written, the name of its file in a bundle, and whether it takes extents."""

    write: Callable[[Fitted, ExportOptions], bytes]
    file_name: str
    needs_extents: bool = False


FORMATS: dict[str, Format] = {
    "step": Format(step, "primitive.step", needs_extents=True),
    "glb": Format(mesh_writer("glb"), "primitive.glb", needs_extents=True),
    "obj": Format(mesh_writer("obj"), "primitive.obj", needs_extents=True),
    "stl": Format(mesh_writer("stl"), "primitive.stl", needs_extents=True),
    "ply": Format(mesh_writer("ply"), "primitive.ply", needs_extents=True),
    "csv": Format(csv, "primitive.csv"),
    "shrec22": Format(shrec22, "primitive_prediction.txt"),
    "residuals_npy": Format(residuals_npy, "residuals.npy"),
    "residuals_csv": Format(residuals_csv, "residuals.csv"),
    "residuals_ply": Format(residuals_ply, "residuals.ply"),
    "residuals_las": Format(residuals_las, "residuals.las"),
    "form": Format(form_json, "form.json"),
    "report": Format(html_report, "report.html"),
}


@dataclass(frozen=True)
class Wanted:
    """The artefacts that were asked for beside an answer."""

    formats: tuple[str, ...]
    options: ExportOptions


@overload
def export(
    recognition: Recognition,
    artifacts: str,
    points: Any = None,
    *,
    options: Mapping[str, Any] | None = None,
    unit: str = "mm",
    chord_error: float = 1e-3,
    title: str | None = None,
    operator: str | None = None,
    date: str | None = None,
) -> bytes: ...


@overload
def export(
    recognition: Recognition,
    artifacts: list[str] | tuple[str, ...],
    points: Any = None,
    *,
    options: Mapping[str, Any] | None = None,
    unit: str = "mm",
    chord_error: float = 1e-3,
    title: str | None = None,
    operator: str | None = None,
    date: str | None = None,
) -> dict[str, bytes]: ...


def export(
    recognition: Recognition,
    artifacts: str | list[str] | tuple[str, ...],
    points: Any = None,
    *,
    options: Mapping[str, Any] | None = None,
    unit: str = "mm",
    chord_error: float = 1e-3,
    title: str | None = None,
    operator: str | None = None,
    date: str | None = None,
) -> bytes | dict[str, bytes]:
    """An artefact as the bytes of a file, or several by name; of an ambiguous answer the first primitive.

    Parameters
    ----------
    artifacts : a key of `FORMATS`, or several
    points : (N, 3) that were fitted, whatever `fit` takes; `residuals_...`, `form` and `report` need them
    options : keyword arguments that `fit` had beside the points, for the receipt in the report
    unit : of the coordinates: `mm`, `m` or `inch`; said in STEP files and reports
    chord_error : largest distance of a mesh from the surface, as a share of the size, in [1e-5, 0.1]
    title, operator, date : what the report says of itself, as given, up to 200 characters each

    Raises
    ------
    InvalidOptionError
        An unknown artefact or unit, a chord error out of range, points that are missing, an option that
        `fit` would not have taken, or an artefact of extents that `fit` was not asked for (`include`).
    InvalidPointCloudError
        The points are not finite (N, 3).
    NothingToExportError
        No primitive, or no extents to trim it to.
    """
    names = [artifacts] if isinstance(artifacts, str) else list(artifacts)
    for name in names:
        if name not in FORMATS:
            known = ", ".join(FORMATS)
            raise InvalidOptionError(f"artefact {name!r:.40} is unknown; allowed are {known}", "artifacts")
    fitted = fitted_points(recognition, points, options)
    written = write(fitted, names, ExportOptions(unit, chord_error, title, operator, date))  # type: ignore[arg-type]
    return written[artifacts] if isinstance(artifacts, str) else written


def check_parts(formats: Iterable[str], include: Collection[str]) -> None:
    """Raise `InvalidOptionError` where an artefact needs a part of the answer that is left out."""
    if any(FORMATS[format].needs_extents for format in formats):
        check_extents(include)


def write(fitted: Fitted, formats: Iterable[str], options: ExportOptions) -> dict[str, bytes]:
    """The content of each artefact by its name; what several need is computed once."""
    return {format: FORMATS[format].write(fitted, options) for format in formats}


def bundle(answer: bytes, fitted: Fitted, wanted: Wanted) -> bytes:
    """A ZIP of `answer.json` and one file a format; the same input gives the same bytes."""
    stream = BytesIO()
    with ZipFile(stream, "w", ZIP_DEFLATED) as archive:
        archive.writestr(_entry("answer.json"), answer)
        for format, content in write(fitted, wanted.formats, wanted.options).items():
            archive.writestr(_entry(FORMATS[format].file_name), content)
    return stream.getvalue()


def _entry(name: str) -> ZipInfo:
    entry = ZipInfo(name)
    entry.compress_type = ZIP_DEFLATED
    return entry
