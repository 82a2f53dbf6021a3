"""STL, OBJ and GLB as trimesh writes them; their points are the distinct vertices."""

import io
from typing import Any

import numpy as np
import pytest
import trimesh
from trimesh.transformations import random_rotation_matrix

from primfit.app.readers import Cloud, Pick, UnreadableFileError, read
from primfit.app.readers.obj import is_obj
from primfit.app.readers.stl import is_stl

BALL = trimesh.creation.icosphere(subdivisions=3, radius=2.5)
FAR = np.array([1e6, -2e6, 3.0])


def _npy(points: np.ndarray) -> Cloud:
    stream = io.BytesIO()
    np.save(stream, points)
    return read(stream.getvalue())


def _export(mesh: Any, kind: str, **options: Any) -> bytes:
    exported = mesh.export(file_type=kind, **options)
    return exported.encode() if isinstance(exported, str) else exported


def _sorted(points: np.ndarray) -> np.ndarray:
    return points[np.lexsort(points.T)]


@pytest.mark.parametrize("kind", ["stl", "glb"])
def test_binary_meshes_give_the_points_that_npy_gives_in_float32(kind: str) -> None:
    expected = _npy(BALL.vertices.astype(np.float32)).points
    points = read(_export(BALL, kind)).points
    np.testing.assert_array_equal(_sorted(points), _sorted(expected))


def test_an_obj_gives_the_points_that_npy_gives() -> None:
    cloud = read(_export(BALL, "obj", digits=17))
    np.testing.assert_array_equal(cloud.points, _npy(BALL.vertices).points)
    assert cloud.format == "obj"


def test_an_ascii_stl_gives_the_points_that_npy_gives() -> None:
    rows = "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join("vertex {!r} {!r} {!r}\n".format(*corner) for corner in triangle.tolist())
        + "endloop\nendfacet\n"
        for triangle in BALL.triangles
    )
    points = read(f"solid ball\n{rows}endsolid ball\n".encode()).points
    _, first = np.unique(BALL.faces, return_index=True)
    np.testing.assert_array_equal(points, _npy(BALL.vertices[BALL.faces.ravel()[np.sort(first)]]).points)
    written = read(_export(BALL, "stl_ascii")).points
    np.testing.assert_allclose(_sorted(written.round(6)), _sorted(points.round(6)), atol=2e-6)


def test_text_keeps_the_digits_of_far_coordinates_and_float32_does_not() -> None:
    far = BALL.copy()
    far.apply_translation(FAR)
    np.testing.assert_array_equal(read(_export(far, "obj", digits=17)).points, far.vertices)
    assert np.abs(_sorted(read(_export(far, "stl")).points) - _sorted(far.vertices)).max() > 1e-3


def test_a_glb_keeps_them_in_the_transform_of_a_node() -> None:
    scene = trimesh.Scene()
    moved = random_rotation_matrix(np.array([0.3, 0.6, 0.9]))
    moved[:3, 3] = FAR
    outer = scene.graph
    outer.update(frame_from="world", frame_to="outer", matrix=moved)
    scene.add_geometry(BALL, parent_node_name="outer", transform=np.diag([1.0, 2.0, 3.0, 1.0]))
    scene.add_geometry(BALL)
    vertices = BALL.vertices.astype(np.float32).astype(float)
    expected = np.vstack([(vertices * [1, 2, 3]) @ moved[:3, :3].T + FAR, vertices])
    np.testing.assert_allclose(_sorted(read(_export(scene, "glb")).points), _sorted(expected), atol=1e-9)


def test_a_cloud_of_points_in_a_glb_is_read() -> None:
    points = np.random.default_rng(1).normal(size=(50, 3))
    cloud = read(_export(trimesh.Scene([trimesh.PointCloud(points)]), "glb"))
    np.testing.assert_array_equal(cloud.points, points.astype(np.float32))


@pytest.mark.parametrize("kind", ["obj", "glb"])
def test_normals_of_vertices_are_read_where_each_has_one(kind: str) -> None:
    cloud = read(_export(BALL, kind, include_normals=True))
    np.testing.assert_allclose(cloud.normals, BALL.vertex_normals, atol=1e-6)
    assert cloud.columns == ("x", "y", "z", "nx", "ny", "nz")
    assert read(_export(BALL, kind, include_normals=False)).normals is None


def test_normals_that_differ_at_one_vertex_are_left_alone() -> None:
    box = trimesh.creation.box()
    box.unmerge_vertices()
    cloud = read(_export(box, "glb", include_normals=True))
    assert cloud.points.shape == (8, 3)
    assert cloud.normals is None
    crossed = b"v 1 2 3\nv 4 5 6\nv 7 8 10\nvn 0 0 1\nvn 0 1 0\nvn 1 0 0\nf 1//2 2//1 3//3\n"
    assert read(crossed).normals is None
    np.testing.assert_array_equal(read(crossed.replace(b"1//2 2//1", b"1//1 2//2")).normals[0], [0, 0, 1])


def test_repeats_are_merged_in_the_order_of_their_first_appearance() -> None:
    cloud = read(b"# part\no part\nv 7 8 9 1.0\nv 1 2 3\nv 7 8 9\nv -0.0 0 0\nv 0 0 -0.0\nl 1 2\n")
    np.testing.assert_array_equal(cloud.points, [[7, 8, 9], [1, 2, 3], [0, 0, 0]])


def test_a_mesh_has_no_labels() -> None:
    with pytest.raises(UnreadableFileError, match="a mesh has no labels"):
        read(_export(BALL, "stl"), pick=Pick("segment"))
    assert read(_export(BALL, "stl"), pick=Pick("auto")).labels is None


TABLES = [
    b"1 2 3\n4 5 6\n7 8 9\n",
    b"v x y z\n1 1 2 3\n2 4 5 6\n",
    b"g x y z\n1 1 2 3\n2 4 5 6\n",
    b"s,x,y,z\nv,1,2,3\nv,4,5,6\n",
    b"l x y z\nv 1 2 3\nv 4 5 6\n",
    b"solid,x,y,z\n1,1,2,3\nfacet,4,5,6\n",
    b"1,2,3\n" * 1000,
]


@pytest.mark.parametrize("table", TABLES)
def test_tables_are_not_taken_for_meshes(table: bytes) -> None:
    assert not is_obj(memoryview(table))
    assert not is_stl(memoryview(table))
    assert read(table).format == "text"


def test_meshes_are_recognized() -> None:
    assert is_obj(memoryview(b"\xef\xbb\xbf# part\r\n\r\nmtllib a.mtl\r\nv  1 -2.5e-3 .5\r\n"))
    assert is_stl(memoryview(_export(BALL, "stl")))
    named = b"solid of which nobody said that it is binary".ljust(80) + _export(BALL, "stl")[80:]
    np.testing.assert_array_equal(read(named).points, read(_export(BALL, "stl")).points)
