"""Meshes read back by trimesh: on the surface, of the right area, and closed where the shape is."""

import io
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import trimesh

from primfit.app.exports import export
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.primitives.sphere import Sphere
from tests.app.exports.test_step import PIECES, recognized

CLOSED = ("full sphere", "full torus")


def _loaded(content: bytes, file_type: str) -> Any:
    mesh = trimesh.load(io.BytesIO(content), file_type=file_type, force="mesh", process=False)
    if file_type == "glb":
        mesh.apply_scale(1000.0)  # it is in meters, the answer in millimeters
    if file_type == "stl":
        mesh.merge_vertices()
    return mesh


@pytest.mark.parametrize("file_type", ["glb", "obj", "stl", "ply"])
@pytest.mark.parametrize("name", PIECES)
def test_meshes_are_the_trimmed_shape(name: str, file_type: str) -> None:
    recognition = recognized(name)
    content = export(recognition, file_type)
    assert content == export(recognition, file_type)
    mesh = _loaded(content, file_type)
    assert recognition.primitive and recognition.extents
    assert mesh.area == pytest.approx(recognition.extents.area, rel=0.01)
    size = np.linalg.norm(mesh.extents)
    assert np.abs(recognition.primitive.signed_distance(np.array(mesh.vertices))).max() < 1e-5 * size
    assert np.abs(recognition.primitive.signed_distance(mesh.triangles_center)).max() < 1e-3 * size
    outward = np.einsum("ij,ij->i", mesh.face_normals, recognition.primitive.gradient(mesh.triangles_center))
    assert outward.min() > 0.9
    assert mesh.is_watertight == (name in CLOSED)


def test_a_smaller_chord_error_makes_more_triangles() -> None:
    recognition = recognized("full torus")
    coarse, fine = (_loaded(export(recognition, "ply", chord_error=e), "ply") for e in (1e-2, 1e-4))
    assert len(fine.faces) > 20 * len(coarse.faces)
    assert fine.volume == pytest.approx(2 * np.pi**2 * 20 * 6**2, rel=2e-3)


@pytest.mark.parametrize("file_type", ["glb", "obj", "ply"])
@pytest.mark.parametrize(
    "frame", [Frame(np.array([6e6, 5e5, 400.0]), 1.0), Frame(np.zeros(3), 1e-9)], ids=["far", "tiny"]
)
def test_far_and_tiny_meshes_keep_their_digits(frame: Frame, file_type: str) -> None:
    here = recognized("full sphere")
    assert isinstance(here.primitive, Sphere) and here.extents
    if file_type == "glb" and frame.scale < 1.0:
        frame = Frame(np.zeros(3), 1e-3)  # micrometers, in meters; trimesh takes less than 1e-8 for none
    moved = replace(here, primitive=frame.restore(here.primitive), extents=here.extents.restored(frame))
    far = file_type == "glb" and frame.center.any()
    with pytest.warns(UserWarning, match="GLB holds float32") if far else nullcontext():
        content = export(moved, file_type)
    mesh = _loaded(content, file_type)
    assert np.abs(moved.primitive.signed_distance(np.array(mesh.vertices))).max() < 1e-5 * frame.scale
    assert mesh.is_watertight


def test_a_plane_of_any_size_is_triangulated() -> None:
    here = recognized("plane")
    assert here.primitive and here.extents
    huge = Frame(np.zeros(3), 1e90)
    moved = replace(here, primitive=huge.restore(here.primitive), extents=here.extents.restored(huge))
    n_faces = [export(each, "obj").count(b"\nf ") for each in (here, moved)]
    assert n_faces[0] == n_faces[1] > 0
