"""Triangle meshes of the trimmed primitive: GLB, OBJ, STL and PLY."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import Unit

from ..readers.units import METERS
from .drawing import Mesh
from .fitted import Fitted
from .options import ExportOptions
from .ply import Element, ply

ROUNDING = 0.01
"""Share of the chord error that the float32 of an STL may round off; else the mesh is about an origin."""

_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


@dataclass(frozen=True)
class Said:
    """What a mesh file says of itself, and how fine the mesh is [length]."""

    kind: str
    unit: Unit | None
    chord_error: float

    @property
    def words(self) -> str:
        return f"a {self.kind} [{self.unit or 'unit not given'}]"


_COARSE = "{} holds float32, too coarse so far from the origin"


def mesh_writer(file_type: str) -> Callable[[Fitted, ExportOptions], bytes]:
    """The writer of `glb`, `obj`, `stl` or `ply`."""

    def write(fitted: Fitted, options: ExportOptions) -> bytes:
        mesh = fitted.shape.mesh(options.chord_error)
        return _WRITERS[file_type](mesh, _said(fitted, mesh, options))

    return write


def _said(fitted: Fitted, mesh: Mesh, options: ExportOptions) -> Said:
    size = float(np.ptp(mesh[0], axis=0).max(initial=0.0))
    return Said(fitted.primitive.kind, options.unit, options.chord_error * size)


def stl_warning(fitted: Fitted, options: ExportOptions) -> str:
    """A sentence where the STL is written about an origin of its own; empty where it is not."""
    where = _where(fitted, options)
    return f"{_COARSE.format('STL')}: its coordinates are those less ({where})." if where else ""


def glb_warning(fitted: Fitted, options: ExportOptions) -> str:
    """A sentence where programs that keep the place of a GLB as float32 would round it; empty elsewhere."""
    where = _where(fitted, options)
    about = f"its mesh is about ({where}), where its node places it; some programs round that place"
    return f"{_COARSE.format('GLB')}: {about}." if where else ""


def _where(fitted: Fitted, options: ExportOptions) -> str:
    """The origin that is taken off, in the unit of the input; empty where float32 is fine enough."""
    mesh = fitted.shape.mesh(options.chord_error)
    origin = _origin(mesh[0], _said(fitted, mesh, options).chord_error)
    unit = f" {options.unit}" if options.unit else ""
    return ", ".join(f"{each:.0f}" for each in origin) + unit if origin.any() else ""


def _origin(vertices: Array, chord_error: float) -> Array:
    """What is taken off the vertices of an STL, whole numbers: zero where float32 is fine enough."""
    step = float(np.spacing(np.float32(np.abs(vertices).max(initial=0.0))))
    return np.zeros(3) if step <= ROUNDING * chord_error else np.rint(vertices.mean(axis=0))


def _obj(mesh: Mesh, said: Said) -> bytes:
    """By ourselves, since trimesh rounds to eight decimals: small shapes would lose their digits."""
    vertices, triangles = mesh
    rows = [f"# {said.words}"]
    rows += [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
    rows += [f"f {a} {b} {c}" for a, b, c in (triangles + 1).tolist()]
    return "\n".join((*rows, "")).encode("ascii")


def _ply(mesh: Mesh, said: Said) -> bytes:
    """By ourselves, since trimesh writes float32: shapes far from the origin would lose their digits."""
    vertices, triangles = mesh
    corners = np.ascontiguousarray(vertices, "<f8")
    faces = np.empty(len(triangles), [("n", "u1"), ("numbers", "<i4", 3)])
    faces["n"], faces["numbers"] = 3, triangles
    return ply(
        said.words,
        Element("vertex", ["double x", "double y", "double z"], corners),
        Element("face", ["list uchar int vertex_indices"], faces),
    )


def _stl(mesh: Mesh, said: Said) -> bytes:
    """By ourselves: its 80 bytes of header say the unit, and what was taken off the coordinates."""
    vertices, triangles = mesh
    origin = _origin(vertices, said.chord_error)
    corners = (vertices - origin)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    rows = np.zeros(len(triangles), _TRIANGLE)
    rows["normal"] = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    rows["corners"] = corners
    about = " about " + " ".join(f"{each:.0f}" for each in origin) if origin.any() else ""
    header = f"{said.words}{about}"[:80].ljust(80).encode("ascii")
    return header + len(triangles).to_bytes(4, "little") + rows.tobytes()


def _glb(mesh: Mesh, said: Said) -> bytes:
    import trimesh

    scene = trimesh.Scene()
    add_node(scene, said.kind, mesh, said)
    return bytes(scene.export(file_type="glb"))


def add_node(scene: Any, name: str, mesh: Mesh, said: Said) -> None:
    """A mesh about the origin in a node that says where it is: vertices of a GLB are float32.

    In meters, as glTF has it, where the unit is known.
    """
    import trimesh

    vertices, triangles = mesh
    if said.unit is not None:
        vertices = vertices * METERS[said.unit]
    where = vertices.mean(axis=0)
    place = trimesh.transformations.translation_matrix(where)
    metadata = {"kind": said.kind, "unit": "m" if said.unit else "not given"}
    local = trimesh.Trimesh(vertices - where, triangles, process=False, metadata=metadata)
    scene.add_geometry(local, name, name, transform=place)


_WRITERS: dict[str, Callable[[Mesh, Said], bytes]] = {"glb": _glb, "obj": _obj, "stl": _stl, "ply": _ply}
