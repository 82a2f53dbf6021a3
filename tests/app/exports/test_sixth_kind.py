"""A kind that is no surface of revolution, given as the two files of a kind: exports need nothing else."""

from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.integrate import dblquad

from primfit.app.exports import export
from primfit.app.exports.drawing import DRAWINGS
from primfit.app.exports.drawing.patch import Patch, Span
from primfit.app.exports.drawing.unrolled import Unrolled
from primfit.app.exports.fitted import fitted_points
from primfit.app.exports.report.scene import Scene
from primfit.app.exports.report.unrolled import unrolled_map
from primfit.app.exports.report.views import views
from primfit.app.exports.step import SURFACES
from primfit.app.exports.step.bounds import about
from primfit.app.exports.step.file import File, real
from primfit.fitting.answer.result import Recognition
from primfit.fitting.geometry.vectors import Array
from tests.app.exports.test_step import area_of, read_back, recognized

CENTER, AXES = np.array([10.0, 20.0, 30.0]), np.array([5.0, 3.0, 2.0])
QUARTERS = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]], float)
HALF = np.array([[0, -1], [1, -1], [1, 0], [1, 1], [0, 1]], float)


@dataclass(frozen=True)
class Ellipsoid:
    kind = "ellipsoid"

    def signed_distance(self, points: Array) -> Array:
        """To first order."""
        inside = (points - CENTER) / AXES
        length = np.linalg.norm(inside, axis=1)
        return (length - 1.0) * length / np.linalg.norm(inside / AXES, axis=1)

    def gradient(self, points: Array) -> Array:
        across = (points - CENTER) / AXES**2
        return across / np.linalg.norm(across, axis=1, keepdims=True)


@dataclass(frozen=True, eq=False, kw_only=True)
class EllipsoidPatch(Patch):
    def at(self, u: Any, v: Any) -> Array:
        u, v = np.broadcast_arrays(u, v)
        unit = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], axis=-1)
        return CENTER + AXES * unit

    def axis_line(self) -> None:
        return None

    def directions(self) -> tuple[Array, Array]:
        return np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])


def trimmed(primitive: Ellipsoid, extents: Any) -> EllipsoidPatch:
    u = Span(0.0, 2.0 * np.pi, float(AXES.max()), closed=True)
    return EllipsoidPatch(u=u, v=Span(*extents.latitudes, float(AXES.max())), poles=extents.poles)


def unrolled(primitive: Ellipsoid, shape: Patch, points: Array) -> Unrolled:
    x, y, z = ((points - CENTER) / AXES).T
    angles = np.degrees(np.arctan2(y, x)), np.degrees(np.arcsin(np.clip(z, -1.0, 1.0)))
    return Unrolled(*angles, ("longitude", "latitude"), (False, False))


def faces(file: File, primitive: Ellipsoid, shape: Patch) -> tuple[str, list[list[str]]]:
    """A rational B-spline surface of degree 2 each way: the image of the sphere's."""
    shares = [np.where(np.arange(n) % 2, np.sqrt(0.5), 1.0) for n in (len(QUARTERS), len(HALF))]
    weights = np.outer(*shares)
    rows = [
        [file.point(CENTER + AXES * [along * a, along * b, height]) for along, height in HALF]
        for a, b in QUARTERS
    ]
    net = ",".join(f"({','.join(row)})" for row in rows)
    pulls = ",".join(f"({','.join(map(real, row))})" for row in weights)
    surface = file.add(
        f"(BOUNDED_SURFACE()B_SPLINE_SURFACE(2,2,({net}),.UNSPECIFIED.,.T.,.F.,.F.)"
        "B_SPLINE_SURFACE_WITH_KNOTS((3,2,2,2,3),(3,2,3),(0.,1.,2.,3.,4.),(0.,1.,2.),.UNSPECIFIED.)"
        f"GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_SURFACE(({pulls}))"
        "REPRESENTATION_ITEM('')SURFACE())"
    )

    def across(v: float) -> str:
        x, y, z = AXES
        where = file.placement(CENTER + z * np.sin(v) * np.eye(3)[2], np.eye(3)[2], np.eye(3)[0])
        return file.add(f"ELLIPSE('',{where},{real(x * np.cos(v))},{real(y * np.cos(v))})")

    def along(u: float) -> str:
        where = file.placement(CENTER, -np.eye(3)[1], np.eye(3)[0])
        return file.add(f"ELLIPSE('',{where},{real(AXES[0])},{real(AXES[2])})")

    return surface, about(file, shape, across, along)


def _area(low: float, high: float) -> float:
    a, b, c = AXES

    def element(v: float, u: float) -> float:
        side = (b * c * np.cos(u)) ** 2 + (a * c * np.sin(u)) ** 2
        return float(np.cos(v) * np.sqrt(side * np.cos(v) ** 2 + (a * b * np.sin(v)) ** 2))

    return float(dblquad(element, 0.0, 2.0 * np.pi, low, high)[0])


LATITUDES = {"whole": (-np.pi / 2.0, np.pi / 2.0), "cap": (0.4, np.pi / 2.0), "zone": (-0.7, 0.4)}


@pytest.fixture(params=LATITUDES)
def answer(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Recognition:
    """An answer that holds an ellipsoid; its extents say between which latitudes."""
    here = SimpleNamespace(POSITIVE="outside", UPRIGHT="axis", trimmed=trimmed, unrolled=unrolled)
    monkeypatch.setitem(DRAWINGS, "ellipsoid", here)  # type: ignore[misc]
    monkeypatch.setitem(SURFACES, "ellipsoid", SimpleNamespace(faces=faces))  # type: ignore[misc]
    low, high = LATITUDES[request.param]
    extents = SimpleNamespace(
        latitudes=(low, high), poles=(low == -np.pi / 2.0, high == np.pi / 2.0), area=_area(low, high)
    )
    every = SimpleNamespace(among=lambda points: np.ones(len(points), bool))
    known: Any = {"primitive": Ellipsoid(), "extents": extents, "inlier_rule": every}
    return replace(recognized("full sphere"), **known)


def test_it_is_meshed(answer: Recognition) -> None:
    mesh = trimesh.load(
        trimesh.util.wrap_as_stream(export(answer, "ply", chord_error=1e-3)), file_type="ply", process=False
    )
    assert mesh.area == pytest.approx(answer.extents.area, rel=0.01)  # type: ignore[union-attr]
    assert mesh.is_watertight == all(answer.extents.poles)  # type: ignore[union-attr]
    assert np.abs(Ellipsoid().signed_distance(mesh.triangles_center)).max() < 1e-3 * 12.4
    outward = np.einsum("ij,ij->i", mesh.face_normals, Ellipsoid().gradient(mesh.triangles_center))
    assert outward.min() > 0.9


def test_a_cad_kernel_reads_its_face(answer: Recognition, tmp_path: Path) -> None:
    face = read_back(export(answer, "step", unit="mm"), tmp_path)
    from OCP.BRepCheck import BRepCheck_Analyzer

    assert BRepCheck_Analyzer(face).IsValid()
    assert area_of(face) == pytest.approx(answer.extents.area, rel=1e-6)  # type: ignore[union-attr]


def test_it_is_drawn_in_the_report(answer: Recognition) -> None:
    rng = np.random.default_rng(0)
    patch = trimmed(Ellipsoid(), answer.extents)
    points = patch.at(rng.uniform(*patch.u.ends, 500), rng.uniform(*patch.v.ends, 500))
    fitted = fitted_points(answer, points)
    scene = Scene.of(fitted)
    assert scene.surface is not None and scene.surface.axis is None
    assert len(scene.surface.edges) == 2 - sum(patch.poles)
    assert views(scene, 0.1, "mm").count("<figure") == 3
    assert "longitude [degrees]" in unrolled_map(fitted, 0.1, "mm")
