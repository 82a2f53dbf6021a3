"""Triangle meshes of the trimmed primitive: GLB, OBJ, STL and PLY."""

from collections.abc import Callable
from typing import Any

import numpy as np

from .drawing import Mesh
from .fitted import Fitted
from .options import ExportOptions
from .ply import Element, ply

Said = dict[str, str]
"""The `kind` and the `unit`."""


def mesh_writer(file_type: str) -> Callable[[Fitted, ExportOptions], bytes]:
    """The writer of `glb`, `obj`, `stl` or `ply`."""

    def write(fitted: Fitted, options: ExportOptions) -> bytes:
        mesh = fitted.shape.mesh(options.chord_error)
        return _WRITERS[file_type](mesh, {"kind": fitted.primitive.kind, "unit": options.unit})

    return write


def _obj(mesh: Mesh, said: Said) -> bytes:
    """By ourselves, since trimesh rounds to eight decimals: small shapes would lose their digits."""
    vertices, triangles = mesh
    rows = [f"# a {said['kind']} [{said['unit']}]"]
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
        f"a {said['kind']} [{said['unit']}]",
        Element("vertex", ["double x", "double y", "double z"], corners),
        Element("face", ["list uchar int vertex_indices"], faces),
    )


def _stl(mesh: Mesh, said: Said) -> bytes:
    return bytes(_trimesh(mesh, said).export(file_type="stl"))


def _glb(mesh: Mesh, said: Said) -> bytes:
    import trimesh

    scene = trimesh.Scene()
    add_node(scene, said["kind"], mesh, said)
    return bytes(scene.export(file_type="glb"))


def add_node(scene: Any, name: str, mesh: Mesh, said: Said) -> None:
    """A mesh about the origin in a node that says where it is: vertices of a GLB are float32."""
    import trimesh

    vertices, triangles = mesh
    where = vertices.mean(axis=0)
    place = trimesh.transformations.translation_matrix(where)
    scene.add_geometry(_trimesh((vertices - where, triangles), said), name, name, transform=place)


def _trimesh(mesh: Mesh, said: Said) -> Any:
    import trimesh

    return trimesh.Trimesh(*mesh, process=False, metadata=said)


_WRITERS: dict[str, Callable[[Mesh, Said], bytes]] = {"glb": _glb, "obj": _obj, "stl": _stl, "ply": _ply}
