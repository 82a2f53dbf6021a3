"""Triangle meshes of the trimmed primitive: GLB, OBJ, STL and PLY."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from primfit.fitting.geometry.vectors import Array, basis
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from .fitted import Fitted
from .options import ExportOptions
from .patch import Patch, Pieces, patch_of, trimmed
from .ply import Element, ply

FEWEST = 3
"""Strips across an arc at least, so that a full turn is a surface."""

Mesh = tuple[Array, np.ndarray]
"""Vertices (K, 3) and triangles (M, 3), counter-clockwise seen from outside."""

Said = dict[str, str]
"""The `kind` and the `unit`."""


def mesh_writer(file_type: str) -> Callable[[Fitted, ExportOptions], bytes]:
    """The writer of `glb`, `obj`, `stl` or `ply`."""

    def write(fitted: Fitted, options: ExportOptions) -> bytes:
        primitive, extents = trimmed(fitted.recognition)
        patch = patch_of(primitive, extents)
        mesh = _grid(patch, options.chord_error) if isinstance(patch, Patch) else flat(patch, primitive)
        return _WRITERS[file_type](mesh, {"kind": primitive.kind, "unit": options.unit})

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
    """A mesh about the origin in a node that says where it is: vertices of a GLB are float32."""
    import trimesh

    vertices, triangles = mesh
    where = vertices.mean(axis=0)
    scene = trimesh.Scene()
    place = trimesh.transformations.translation_matrix(where)
    local = _trimesh((vertices - where, triangles), said)
    scene.add_geometry(local, said["kind"], said["kind"], transform=place)
    return bytes(scene.export(file_type="glb"))


def _trimesh(mesh: Mesh, said: Said) -> Any:
    import trimesh

    return trimesh.Trimesh(*mesh, process=False, metadata=said)


_WRITERS: dict[str, Callable[[Mesh, Said], bytes]] = {"glb": _glb, "obj": _obj, "stl": _stl, "ply": _ply}


def flat(pieces: Pieces, plane: Primitive) -> Mesh:
    """Constrained Delaunay triangles between the corners of the rings, which stay as they are."""
    import shapely

    assert isinstance(plane, Plane)
    corners = np.concatenate([ring for rings in pieces for ring in rings])
    # Of size 1, so that no area overflows.
    frame = np.array(basis(plane.normal)) / np.ptp(corners, axis=0).max()

    def seen(ring: Array) -> Array:
        return (ring - corners[0]) @ frame.T

    shape = shapely.MultiPolygon([(seen(outer), [seen(hole) for hole in holes]) for outer, *holes in pieces])
    parts = shapely.get_parts(shapely.constrained_delaunay_triangles(shape))
    triangles = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    number = cKDTree(seen(corners)).query(triangles)[1]
    first, second = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    clockwise = first[:, 0] * second[:, 1] < first[:, 1] * second[:, 0]
    number[clockwise] = number[clockwise][:, ::-1]
    return corners, number


def _grid(patch: Patch, chord_error: float) -> Mesh:
    """Quadrilaterals in two triangles each; rows that close or shrink to a point share their vertices."""
    rim = patch.at(np.linspace(*patch.u, 33)[:, None], np.linspace(*patch.v, 33)).reshape(-1, 3)
    largest = chord_error * float(np.linalg.norm(np.ptp(rim, axis=0))) / 2.0
    across = _strips(patch.u, float(patch.profile(np.linspace(*patch.v, 33))[0].max()), largest)
    along = _strips(patch.v, _profile_radius(patch), largest)
    u, v = np.linspace(*patch.u, across + 1), np.linspace(*patch.v, along + 1)
    number = np.arange((along + 1) * (across + 1)).reshape(along + 1, across + 1)
    if patch.closed_u:
        number[:, -1] = number[:, 0]
    if patch.closed_v:
        number[-1] = number[0]
    for row, is_pole in zip((0, -1), patch.has_pole, strict=True):
        if is_pole:
            number[row] = number[row, 0]
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    first, second, third = triangles.T
    triangles = triangles[(first != second) & (second != third) & (third != first)]
    used, renumbered = np.unique(triangles, return_inverse=True)
    return patch.at(u, v[:, None]).reshape(-1, 3)[used], renumbered.reshape(-1, 3)


def _profile_radius(patch: Patch) -> float:
    """Of the curve of constant u; 0 of a line."""
    match patch.primitive:
        case Sphere(radius=radius):
            return radius
        case Torus(minor_radius=radius):
            return radius
    return 0.0


def _strips(arc: tuple[float, float], radius: float, largest: float) -> int:
    """Equal parts of an arc whose chords keep within a distance of it."""
    if radius == 0.0:
        return 1
    step = 2.0 * np.arccos(max(1.0 - largest / radius, 0.5))
    return max(int(np.ceil((arc[1] - arc[0]) / step)), FEWEST)
