"""STEP files read back by an independent CAD kernel; without it (extra `cad`) only what the text shows."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from primfit.app.exports import NothingToExportError, export
from primfit.app.exports.pictures import picture
from primfit.fitting.answer.result import Recognition
from primfit.fitting.errors import InvalidOptionError
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import Unit
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus
from primfit.fitting.recognize import recognize
from primfit.fitting.request.config import Config

TURN = 2.0 * np.pi
AXIS = [0.3, -0.5, 0.8]
HERE = [10.0, 20.0, 30.0]
CONE, TORUS = Cone(HERE, AXIS, 0.4), Torus(HERE, AXIS, 20.0, 6.0)
PIECES: dict[str, tuple[Primitive, tuple[float, float], tuple[float, float]]] = {
    "plane": (Plane(AXIS, HERE), (-4.0, 5.0), (-2.0, 3.0)),
    "sphere cap": (Sphere(HERE, 15.0), (0.0, TURN), (0.0, 1.0)),
    "large cap": (Sphere(HERE, 15.0), (0.0, TURN), (0.0, 2.2)),
    "zone": (Sphere(HERE, 15.0), (0.0, TURN), (0.4, 2.2)),
    "full sphere": (Sphere(HERE, 15.0), (0.0, TURN), (0.0, np.pi)),
    "half pipe": (Cylinder(AXIS, HERE, 8.0), (2.0, 5.0), (-7.0, 11.0)),
    "pipe": (Cylinder(AXIS, HERE, 8.0), (0.0, TURN), (-7.0, 11.0)),
    "cone": (CONE, (0.0, TURN), (8.0, 20.0)),
    "cone to its apex": (CONE, (0.0, TURN), (0.0, 20.0)),
    "slice of a cone": (CONE, (5.0, 8.0), (8.0, 20.0)),
    "slice to its apex": (CONE, (5.0, 8.0), (0.0, 20.0)),
    "full torus": (TORUS, (0.0, TURN), (0.0, TURN)),
    "bend": (TORUS, (1.0, 3.0), (0.0, TURN)),
    "gutter": (TORUS, (0.0, TURN), (-1.0, 1.0)),
    "piece of a torus": (TORUS, (1.0, 3.0), (2.0, 4.0)),
}


def recognized(name: str) -> Recognition:
    primitive, u, v = PIECES[name]
    rng = np.random.default_rng(4)
    across, along = rng.uniform(*u, 3000), rng.uniform(*v, 3000)
    if isinstance(primitive, Sphere):
        along = np.arccos(rng.uniform(np.cos(v[1]), np.cos(v[0]), 3000))
    if isinstance(primitive, Cone):
        along = np.sqrt(rng.uniform(v[0] ** 2, v[1] ** 2, 3000))
    found = recognize(primitive.surface(across, along), Config(kinds=(primitive.kind,), unit="mm"))
    assert found.status == "fitted"
    return found


def read_back(content: bytes, folder: Path) -> Any:
    """The one face of the file, in millimetres."""
    pytest.importorskip("OCP", reason="the CAD kernel is not installed (extra cad)")
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_Reader
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    file = folder / "primitive.step"
    file.write_bytes(content)
    reader = STEPControl_Reader()
    assert reader.ReadFile(str(file)) == IFSelect_ReturnStatus.IFSelect_RetDone
    assert reader.TransferRoots() == 1
    faces = TopExp_Explorer(reader.OneShape(), TopAbs_FACE)
    face = TopoDS.Face_s(faces.Current()) if hasattr(TopoDS, "Face_s") else TopoDS.Face(faces.Current())
    faces.Next()
    assert not faces.More()
    return face


def area_of(face: Any) -> float:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties, 1e-9)
    return float(properties.Mass())


def parameters_of(face: Any) -> dict[str, Any]:
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    surface = BRepAdaptor_Surface(face)
    kind = surface.GetType().name.removeprefix("GeomAbs_").lower()
    of = getattr(surface, kind.capitalize())()
    found = {"kind": kind, "at": _xyz(of.Location()), "axis": _xyz(of.Position().Direction())}
    for name in ("Radius", "MajorRadius", "MinorRadius", "SemiAngle", "RefRadius"):
        if hasattr(of, name):
            found[name] = getattr(of, name)()
    if kind == "cone":
        found["apex"] = _xyz(of.Apex())
    return found


def _xyz(of: Any) -> Array:
    return np.array([of.X(), of.Y(), of.Z()])


@pytest.mark.parametrize("name", PIECES)
def test_a_cad_kernel_reads_the_same_face(name: str, tmp_path: Path) -> None:
    recognition = recognized(name)
    face = read_back(export(recognition, "step", unit="mm"), tmp_path)
    from OCP.BRepCheck import BRepCheck_Analyzer

    assert BRepCheck_Analyzer(face).IsValid()
    assert recognition.extents
    assert area_of(face) == pytest.approx(recognition.extents.area, rel=1e-6)
    found, expected = parameters_of(face), recognition.primitive
    assert expected and found["kind"] == expected.kind
    close = {"rtol": 1e-9, "atol": 1e-9}
    match expected:
        case Plane(normal=normal, point=point):
            np.testing.assert_allclose(found["axis"], normal, **close)
            np.testing.assert_allclose((found["at"] - point) @ normal, 0.0, **close)
        case Sphere(center=center, radius=radius):
            np.testing.assert_allclose([*found["at"], found["Radius"]], [*center, radius], **close)
        case Cylinder(axis=axis, point=point, radius=radius):
            np.testing.assert_allclose([*found["axis"], found["Radius"]], [*axis, radius], **close)
            np.testing.assert_allclose(np.cross(found["at"] - point, axis), 0.0, atol=1e-8)
        case Cone(apex=apex, axis=axis, half_angle=half_angle):
            np.testing.assert_allclose(
                [*found["apex"], *found["axis"], found["SemiAngle"]], [*apex, *axis, half_angle], **close
            )
        case Torus(center=center, axis=axis, major_radius=major, minor_radius=minor):
            np.testing.assert_allclose([*found["at"], *found["axis"]], [*center, *axis], **close)
            np.testing.assert_allclose([found["MajorRadius"], found["MinorRadius"]], [major, minor], **close)


@pytest.mark.parametrize(("unit", "millimetres"), [("m", 1000.0), ("inch", 25.4)])
def test_units_are_said(unit: Unit, millimetres: float, tmp_path: Path) -> None:
    recognition = replace(recognized("pipe"), unit=unit)
    found = parameters_of(read_back(export(recognition, "step"), tmp_path))
    assert found["Radius"] == pytest.approx(8.0 * millimetres, rel=1e-9)


def test_a_known_unit_is_not_taken_for_another_one() -> None:
    recognition = replace(recognized("pipe"), unit="m")
    for write in (lambda: export(recognition, "step", unit="mm"), lambda: picture(recognition, unit="mm")):
        with pytest.raises(InvalidOptionError, match="unit is mm, but the fit was in m;"):
            write()
    unknown = replace(recognition, unit=None)
    assert export(unknown, "step", unit="m") == export(recognition, "step")


@pytest.mark.parametrize("name", PIECES)
def test_every_reference_is_there_and_the_bytes_are_the_same_again(name: str) -> None:
    import re

    recognition = recognized(name)
    content = export(recognition, "step", unit="mm")
    assert content == export(recognition, "step", unit="mm")
    text = content.decode("ascii")
    defined = re.findall(r"^#(\d+)=", text, re.M)
    assert defined == [str(i + 1) for i in range(len(defined))]
    assert set(re.findall(r"#(\d+)", text)) == set(defined)
    assert text.startswith("ISO-10303-21;\n") and text.endswith("END-ISO-10303-21;\n")
    assert text.count("=ADVANCED_FACE(") == 1


def test_the_best_try_of_no_fit_is_named_so() -> None:
    cube = np.random.default_rng(0).uniform(-1.0, 1.0, (500, 3))
    recognition = recognize(cube, Config(kinds=("sphere", "plane")))
    assert recognition.status == "no_fit" and recognition.primitive is not None
    assert f"PRODUCT('{recognition.primitive.kind} (no_fit)'".encode() in export(
        recognition, "step", unit="mm"
    )


def test_nothing_to_export_is_said() -> None:
    flat = np.random.default_rng(0).uniform(-1, 1, (200, 3)) * [1, 1, 0]
    with pytest.raises(NothingToExportError, match="no primitive"):
        export(recognize(flat, Config(kinds=("torus",))), "step")


def test_a_spindle_torus_is_refused() -> None:
    spindle = Torus([0, 0, 0], [0, 0, 1], 1.0, 2.0)
    rng = np.random.default_rng(0)
    found = recognize(
        spindle.surface(rng.uniform(0, TURN, 3000), rng.uniform(-1.5, 1.5, 3000)), Config(kinds=("torus",))
    )
    assert found.primitive and found.status == "fitted"
    with pytest.raises(NothingToExportError, match="major radius"):
        export(found, "step", unit="mm")
