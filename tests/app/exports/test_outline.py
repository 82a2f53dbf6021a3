"""Planes with notches, holes and several pieces, as STEP files and as meshes."""

import io
from pathlib import Path

import numpy as np
import pytest
import trimesh

from primfit.app.exports import export
from primfit.fitting.answer.result import Recognition
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config
from tests.app.exports.test_step import area_of, read_back
from tests.fitting.outlines import patch

PLANE = Plane([0.3, -0.5, 0.8], [10.0, 20.0, 30.0])


def _pieces() -> Array:
    at = patch("square", 5000)
    return at[(at[:, 0] < 0.3) | (at[:, 0] > 0.5)]


def _points(name: str) -> Array:
    at = _pieces() if name == "two pieces" else patch(name, 5000)
    return PLANE.surface(40.0 * at[:, 0], 40.0 * at[:, 1])


def recognized(name: str) -> Recognition:
    found = recognize(_points(name), Config(kinds=("plane",), unit="mm"))
    assert found.status == "fitted" and found.extents
    return found


@pytest.mark.parametrize("name", ["L", "U", "ring"])
def test_a_cad_kernel_reads_the_concave_face(name: str, tmp_path: Path) -> None:
    recognition = recognized(name)
    face = read_back(export(recognition, "step"), tmp_path)
    from OCP.BRepCheck import BRepCheck_Analyzer

    assert BRepCheck_Analyzer(face).IsValid()
    assert recognition.extents and recognition.extents.kind == "plane"
    assert area_of(face) == pytest.approx(recognition.extents.concave_area, rel=1e-6)
    assert recognition.extents.concave_area < 0.9 * recognition.extents.area


@pytest.mark.parametrize(("name", "faces", "bounds"), [("ring", 1, 2), ("two pieces", 2, 2)])
def test_a_face_for_each_piece_and_a_bound_for_each_ring(name: str, faces: int, bounds: int) -> None:
    text = export(recognized(name), "step").decode("ascii")
    assert text.count("=ADVANCED_FACE(") == text.count("=FACE_OUTER_BOUND(") == faces
    assert text.count("=FACE_OUTER_BOUND(") + text.count("=FACE_BOUND(") == bounds


@pytest.mark.parametrize("name", ["L", "ring", "two pieces"])
def test_meshes_keep_the_corners_of_the_outline(name: str) -> None:
    recognition = recognized(name)
    mesh = trimesh.load(io.BytesIO(export(recognition, "ply")), file_type="ply", force="mesh", process=False)
    assert recognition.extents and recognition.extents.kind == "plane"
    assert mesh.area == pytest.approx(recognition.extents.concave_area, rel=1e-5)
    corners = np.concatenate([ring for rings in recognition.extents.concave_outline for ring in rings])
    np.testing.assert_allclose(mesh.vertices, corners, atol=1e-5)
    assert (mesh.face_normals @ recognition.primitive.gradient(corners[:1])[0]).min() > 0.999


@pytest.mark.parametrize(("name", "said"), [("ring", "1 piece, 1 hole"), ("two pieces", "2 pieces, 0 holes")])
def test_reports_say_the_pieces_and_the_holes(name: str, said: str) -> None:
    assert said in export(recognized(name), "report", _points(name)).decode()
