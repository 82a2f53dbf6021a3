"""STEP (ISO 10303-21, AP214): the trimmed primitive as a shell of faces on its exact surface.

One file a kind, found by its name, writes the surface and where it ends. The same answer gives the same
bytes: the time stamp is that of the epoch.
"""

from importlib import import_module
from typing import Any, Protocol, cast

from primfit.fitting.names import KINDS

from ..fitted import Fitted
from ..options import ExportOptions, known_unit
from .file import File
from .product import product

Faces = tuple[str, list[list[str]]]
"""Reference to a surface, and of each face on it those to its bounds, the outer one first."""


class Surface(Protocol):
    """What the file of a kind holds."""

    def faces(self, file: File, primitive: Any, shape: Any) -> Faces:
        """Add the surface and the bounds of its faces; `shape` is what `drawing.KIND.trimmed` made.

        Raises `NothingToExportError` where STEP has no such surface.
        """
        ...


SURFACES: dict[str, Surface] = {kind: cast(Surface, import_module(f".{kind}", __name__)) for kind in KINDS}


def step(fitted: Fitted, options: ExportOptions) -> bytes:
    """The file; raises `NothingToExportError` where there is nothing to trim."""
    kind, status, shape = fitted.primitive.kind, fitted.recognition.status, fitted.shape
    file = File()
    surface, bounds = SURFACES[kind].faces(file, fitted.primitive, shape)
    faces = [file.add(f"ADVANCED_FACE('{kind}',({','.join(of)}),{surface},.T.)") for of in bounds]
    shell = file.add(f"{'CLOSED' if shape.is_closed else 'OPEN'}_SHELL('',({','.join(faces)}))")
    name = kind if status == "fitted" else f"{kind} ({status})"
    product(file, name, shell, fitted.extents.area, known_unit(options.unit))
    return file.text(name).encode("ascii")
