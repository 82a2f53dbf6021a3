"""The answers for many clouds as one file: an assembly, a scene, a table or a report.

What cannot be written of one cloud does not sink the others: it is left out of assemblies and scenes, and
tables and reports list it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.names import Unit

from ...engine.segments import Segment
from ..fitted import check_extents
from ..options import ExportOptions, unit_of
from .geometry import assembly, scene
from .overview import overview
from .part import PICTURED, Part, pictured
from .table import table_of

__all__ = ["MANY", "PICTURED", "Part", "export_segments", "pictured", "write_many"]

MANY: dict[str, Callable[[Sequence[Part], ExportOptions], bytes]] = {
    "step": assembly,
    "glb": scene,
    "csv": table_of,
    "report": overview,
}
"""What can be written of many answers, and how."""

TRIMMED = ("step", "glb")
"""Those of them that need extents."""


def export_segments(
    segments: Sequence[Segment], artifact: str, *, unit: Unit | None = None, chord_error: float = 1e-3
) -> bytes:
    """All segments of a cloud as the bytes of one file.

    Parameters
    ----------
    segments : what `fit_segments` gave, or some of it
    artifact : `step`, an assembly of the trimmed primitives; `glb`, a scene with a node for each; `csv`, a
        table with a row for each segment; `report`, a page with a table of all segments, and the picture and
        all numbers of the first 60
    unit : of the coordinates; None for that of the answers. STEP needs one
    chord_error : largest distance of a mesh from its surface, as a share of the size, in [1e-5, 0.1]

    Returns
    -------
    The content. Segments without a fit or without extents are left out of `step` and `glb`, where parts are
    named by label and kind, as `7 cylinder`; the other two list them, and say why.

    Raises
    ------
    InvalidOptionError
        An unknown artifact or unit, a chord error out of range, or an artifact of extents that `fit_segments`
        was not asked for (`include`).
    NothingToExportError
        No segment has a primitive that can be trimmed.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> segments = primfit.fit_segments(np.vstack([points, points + 9.0]), [7] * 300 + [8] * 300)
    >>> print(primfit.export_segments(segments, "csv").decode()[:28])
    label,status,n_points,kind,c
    >>> segments.export("step", unit="mm")[:13]
    b'ISO-10303-21;'
    """
    if artifact not in MANY:
        raise InvalidOptionError(
            f"artifact {artifact!r:.40} is unknown; allowed are {', '.join(MANY)}", "artifact"
        )
    options = ExportOptions(unit, chord_error)
    parts = [
        Part({"label": segment.label}, str(segment.label), segment.recognition, segment.problem)
        for segment in segments
    ]
    if artifact == "report":
        parts[:PICTURED] = [pictured(part) for part in parts[:PICTURED]]
    return write_many(parts, artifact, options)


def write_many(parts: Sequence[Part], artifact: str, options: ExportOptions) -> bytes:
    """One of `MANY`; raises as `export_segments` does."""
    if artifact in TRIMMED:
        for part in parts:
            if part.recognition is not None:
                check_extents(part.recognition.include)
    answers = [part.recognition for part in parts if part.recognition is not None]
    return MANY[artifact](parts, replace(options, unit=unit_of(answers, options.unit)))
