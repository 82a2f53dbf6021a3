"""Many trimmed primitives in one file: an assembly in STEP, a scene in GLB."""

from collections.abc import Sequence

from ..fitted import NothingToExportError
from ..mesh import Said, add_node
from ..options import ExportOptions, known_unit
from ..step import shell_of
from ..step.file import File
from ..step.product import application, place, product
from .part import Part, trimmed

NAME = "primitives"


def assembly(parts: Sequence[Part], options: ExportOptions) -> bytes:
    """A product for each primitive, and one that they are parts of."""
    file, unit = File(), known_unit(options.unit)
    shared = application(file)
    products, area = [], 0.0
    for name, fitted in trimmed(parts):
        before = len(file.lines)
        try:
            shell = shell_of(file, fitted)
        except NothingToExportError:
            del file.lines[before:]
            continue
        products.append((name, product(file, shared, name, shell, fitted.extents.area, unit)))
        area = max(area, fitted.extents.area)
    if not products:
        raise NothingToExportError("STEP has no surface for any of the primitives")
    whole = product(file, shared, NAME, None, area, unit)
    for name, part in products:
        place(file, part, name, whole)
    return file.text(NAME).encode("ascii")


def scene(parts: Sequence[Part], options: ExportOptions) -> bytes:
    """A node for each primitive, with its mesh."""
    import trimesh

    made = trimesh.Scene()
    for name, fitted in trimmed(parts):
        said = Said(fitted.primitive.kind, options.unit, options.chord_error)
        add_node(made, name, fitted.shape.mesh(options.chord_error), said)
    return bytes(made.export(file_type="glb"))
