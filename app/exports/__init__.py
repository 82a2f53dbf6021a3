"""The recognized primitive, its residuals and the report as files: one file a format."""

import warnings
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from io import BytesIO
from typing import Any, overload
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo
from zlib import compress

import orjson

from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.names import KindName, Unit

from .fitted import (
    Fitted,
    NothingToExportError,
    check_extents,
    fitted_points,
    form_errors,
    of_kind,
    residuals,
)
from .form import form_json
from .mesh import glb_warning, mesh_writer, stl_warning
from .options import ExportOptions, known_unit, unit_of
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
    "check_unit",
    "export",
    "form_errors",
    "outcomes",
    "residuals",
    "write",
]


@dataclass(frozen=True)
class Format:
    """How a format is written, the name of its file in a bundle, whether it takes extents, and what to know.

    `warning` gives a sentence, or nothing.
    """

    write: Callable[[Fitted, ExportOptions], bytes]
    file_name: str
    needs_extents: bool = False
    warning: Callable[[Fitted, ExportOptions], str] = lambda fitted, options: ""


FORMATS: dict[str, Format] = {
    "step": Format(step, "primitive.step", needs_extents=True),
    "glb": Format(mesh_writer("glb"), "primitive.glb", needs_extents=True, warning=glb_warning),
    "obj": Format(mesh_writer("obj"), "primitive.obj", needs_extents=True),
    "stl": Format(mesh_writer("stl"), "primitive.stl", needs_extents=True, warning=stl_warning),
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
    """The artifacts that were asked for beside an answer."""

    formats: tuple[str, ...]
    options: ExportOptions


@overload
def export(
    recognition: Recognition,
    artifacts: str,
    points: Any = None,
    *,
    options: Mapping[str, Any] | None = None,
    unit: Unit | None = None,
    chord_error: float = 1e-3,
    export_kind: KindName | None = None,
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
    unit: Unit | None = None,
    chord_error: float = 1e-3,
    export_kind: KindName | None = None,
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
    unit: Unit | None = None,
    chord_error: float = 1e-3,
    export_kind: KindName | None = None,
    title: str | None = None,
    operator: str | None = None,
    date: str | None = None,
) -> bytes | dict[str, bytes]:
    """An artifact as the bytes of a file, or several by name.

    Parameters
    ----------
    artifacts : a key of `FORMATS`, or several
    points : (N, 3) that were fitted, whatever `fit` takes; `residuals_...`, `form` and `report` need them.
        None for those that the answer has kept
    options : keyword arguments that `fit` had beside the points, for the receipt in the report
    unit : of the coordinates, `mm`, `m`, ..., where the fit did not know it; None for that of the answer.
        STEP files need it
    chord_error : largest distance of a mesh from the surface, as a share of the size, in [1e-5, 0.1]
    export_kind : which kind of an ambiguous answer; None for the first
    title, operator, date : what the report says of itself, as given, up to 200 characters each

    Warns
    -----
    UserWarning
        An STL so far from the origin that its coordinates are less some of those of the points.

    Raises
    ------
    InvalidOptionError
        An unknown artifact or unit, another unit than that of the answer, a chord error out of range, points
        that are missing, an option that `fit` would not have taken, or an artifact of extents that `fit` was
        not asked for (`include`).
    InvalidPointCloudError
        The points are not finite (N, 3).
    NothingToExportError
        No primitive, or no extents to trim it to.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> recognition = primfit.fit(points)
    >>> primfit.export(recognition, "step", unit="mm")[:13]
    b'ISO-10303-21;'
    >>> list(primfit.export(recognition, ["csv", "report"], unit="mm"))
    ['csv', 'report']
    """
    names = [artifacts] if isinstance(artifacts, str) else list(artifacts)
    for name in names:
        if name not in FORMATS:
            known = ", ".join(FORMATS)
            raise InvalidOptionError(f"artifact {name!r:.40} is unknown; allowed are {known}", "artifacts")
    fitted = fitted_points(recognition, points, options)
    how = ExportOptions(unit, chord_error, export_kind, title, operator, date)
    written = write(fitted, names, how)
    return written[artifacts] if isinstance(artifacts, str) else written


def check_parts(formats: Iterable[str], include: Collection[str]) -> None:
    """Raise `InvalidOptionError` where an artifact needs a part of the answer that is left out."""
    if any(FORMATS[format].needs_extents for format in formats):
        check_extents(include)


def check_unit(formats: Collection[str], unit: Unit | None) -> None:
    """Raise `InvalidOptionError` where an artifact needs a unit, and none is known."""
    if "step" in formats:
        known_unit(unit)


def write(fitted: Fitted, formats: Iterable[str], options: ExportOptions) -> dict[str, bytes]:
    """The content of each artifact by its name; what several need is computed once. Warns of what to know."""
    fitted, options = _chosen(fitted, options)
    for format in formats:
        if warning := FORMATS[format].warning(fitted, options):
            warnings.warn(warning, stacklevel=3)
    return {format: FORMATS[format].write(fitted, options) for format in formats}


def _chosen(fitted: Fitted, options: ExportOptions) -> tuple[Fitted, ExportOptions]:
    """What is exported of the answer, and the options in its unit."""
    unit = unit_of([fitted.recognition], options.unit)
    return of_kind(fitted, options.export_kind), replace(options, unit=unit)


@dataclass(frozen=True)
class Outcome:
    """What became of an artifact: its content, or why there is none; a warning where one is due."""

    content: bytes | None
    problem: str = ""
    warning: str = ""


def outcomes(fitted: Fitted, formats: Collection[str], options: ExportOptions) -> dict[str, Outcome]:
    """What became of each artifact: one that cannot be made leaves the others alone.

    Raises `NothingToExportError` or `InvalidOptionError` where none can be made.
    """
    fitted, options = _chosen(fitted, options)
    found: dict[str, Outcome] = {}
    failures: list[Exception] = []
    for name in formats:
        format = FORMATS[name]
        try:
            found[name] = Outcome(format.write(fitted, options), warning=format.warning(fitted, options))
        except (NothingToExportError, InvalidOptionError) as error:
            failures.append(error)
            found[name] = Outcome(None, problem=str(error))
    if failures and len(failures) == len(found):
        raise failures[0]
    return found


def bundle(answer: bytes, fitted: Fitted, wanted: Wanted) -> bytes:
    """A ZIP of `answer.json` and one file a format; the same input gives the same bytes.

    `problems.json` in it says which could not be made and why, and what to know of the others, if anything.
    """
    found = outcomes(fitted, wanted.formats, wanted.options)
    said = [
        {"artifact": name, kind: text}
        for name, each in found.items()
        for kind, text in (("problem", each.problem), ("warning", each.warning))
        if text
    ]
    stream = BytesIO()
    with ZipFile(stream, "w", ZIP_DEFLATED) as archive:
        _add(archive, "answer.json", answer)
        for name, each in found.items():
            if each.content is not None:
                _add(archive, FORMATS[name].file_name, each.content)
        if said:
            _add(archive, "problems.json", orjson.dumps(said, option=orjson.OPT_INDENT_2))
    return stream.getvalue()


_SAMPLE, _SHRUNK = 64 * 1024, 0.8
"""Bytes at the beginning of a file, and the share of them that is left where packing is worth its time."""


def _add(archive: ZipFile, name: str, content: bytes) -> None:
    """Add a file; coordinates hardly shrink, and packing them takes longer than the fit."""
    entry, sample = ZipInfo(name), content[:_SAMPLE]
    entry.compress_type = ZIP_DEFLATED if len(compress(sample, 1)) < _SHRUNK * len(sample) else ZIP_STORED
    archive.writestr(entry, content)
