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
from .product import application, product

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
    file = File()
    kind, status = fitted.primitive.kind, fitted.recognition.status
    name = kind if status == "fitted" else f"{kind} ({status})"
    extents, unit = fitted.extents, known_unit(options.unit)
    product(file, application(file), name, shell_of(file, fitted), extents.area, unit)
    return file.text(name).encode("ascii")


def shell_of(file: File, fitted: Fitted) -> str:
    """Add the shell of the trimmed primitive, and give the reference to it.

    Raises `NothingToExportError` where there is nothing to trim; the file holds parts of it then.
    """
    kind, shape = fitted.primitive.kind, fitted.shape
    surface, bounds = SURFACES[kind].faces(file, fitted.primitive, shape)
    faces = [file.add(f"ADVANCED_FACE('{kind}',({','.join(of)}),{surface},.T.)") for of in bounds]
    return file.add(f"{'CLOSED' if shape.is_closed else 'OPEN'}_SHELL('',({','.join(faces)}))")
