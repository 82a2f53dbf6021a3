"""Triangle meshes of the trimmed primitive: GLB, OBJ, STL and PLY."""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from app.exports.fitted import Fitted
from app.exports.options import ExportOptions
from app.exports.patch import Patch, Pieces, patch_of, trimmed
from fitting.geometry import Array, basis
from fitting.primitives import Plane, Primitive, Sphere, Torus

FEWEST = 3
"""Strips across an arc at least, so that a full turn is a surface."""

Mesh = tuple[Array, np.ndarray]
"""Vertices (K, 3) and triangles (M, 3), counter-clockwise seen from outside."""


def mesh_writer(file_type: str) -> Callable[[Fitted, ExportOptions], bytes]:
    """The writer of a format: PLY with every digit, and what trimesh knows."""

    def write(fitted: Fitted, options: ExportOptions) -> bytes:
        primitive, extents = trimmed(fitted.recognition)
        patch = patch_of(primitive, extents)
        mesh = _grid(patch, options.chord_error) if isinstance(patch, Patch) else flat(patch, primitive)
        if file_type == "ply":
            return ply(*mesh)
        said = {"kind": primitive.kind, "unit": options.unit}
        made = _scene(mesh, said) if file_type == "glb" else _trimesh(mesh, said)
        content = made.export(file_type=file_type)
        return content.encode() if isinstance(content, str) else bytes(content)

    return write


def ply(vertices: Array, triangles: np.ndarray) -> bytes:
    """Binary PLY with vertices in float64; trimesh would write float32."""
    faces = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, triangles
    header = [
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property double {name}" for name in "xyz"),
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    return "\n".join((*header, "")).encode("ascii") + vertices.astype("<f8").tobytes() + faces.tobytes()


def _trimesh(mesh: Mesh, said: dict[str, str]) -> Any:
    import trimesh

    return trimesh.Trimesh(*mesh, process=False, metadata=said)


def _scene(mesh: Mesh, said: dict[str, str]) -> Any:
    """A mesh about the origin in a node that says where it is: vertices of a GLB are float32."""
    import trimesh

    vertices, triangles = mesh
    where = vertices.mean(axis=0)
    scene = trimesh.Scene()
    place = trimesh.transformations.translation_matrix(where)
    local = _trimesh((vertices - where, triangles), said)
    scene.add_geometry(local, said["kind"], said["kind"], transform=place)
    return scene


def flat(pieces: Pieces, plane: Primitive) -> Mesh:
    """Constrained Delaunay triangles between the corners of the rings, which stay as they are."""
    import shapely

    assert isinstance(plane, Plane)
    corners = np.concatenate([ring for rings in pieces for ring in rings])
    frame = np.array(basis(plane.normal))

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
