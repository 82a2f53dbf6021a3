"""All segments of a cloud as one file; what one of them lacks does not sink the others."""

import csv
import io
import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
import trimesh

import primfit
from primfit.app.exports.many import PICTURED
from primfit.app.exports.many.part import Part, trimmed
from primfit.app.exports.step.file import quoted
from tests.app.exports.test_step import area_of
from tests.fitting.clouds import EXAMPLES, noisy

CLOUDS = {f"{kind} 'ß'": noisy(shape, 300, 0.005) for kind, shape in EXAMPLES.items()}
CLOUDS |= {"noise": np.random.default_rng(0).uniform(size=(400, 3)), "stray": np.ones((2, 3))}
LABELS = np.concatenate([[name] * len(points) for name, points in CLOUDS.items()])
SEGMENTS = primfit.fit_segments(np.vstack(list(CLOUDS.values())), LABELS)
FITTED = [segment for segment in SEGMENTS if segment.recognition and segment.recognition.status == "fitted"]


def test_segments_are_a_list_that_knows_its_points_whoever_fitted_them() -> None:
    assert len(FITTED) == 5
    assert isinstance(SEGMENTS, list) and [segment.label for segment in SEGMENTS] == sorted(CLOUDS)
    shared = primfit.fit_segments(np.vstack(list(CLOUDS.values())), LABELS, workers=2)
    assert shared == SEGMENTS
    for segment in shared:
        if segment.recognition is not None:
            np.testing.assert_array_equal(segment.recognition.points, CLOUDS[str(segment.label)])
            assert len(segment.recognition.residuals) == len(segment.rows)


def test_a_step_file_has_a_product_for_each_that_is_fitted_in_an_assembly() -> None:
    text = SEGMENTS.export("step", unit="m").decode("ascii")
    products = [line for line in text.splitlines() if "=PRODUCT(" in line]
    assert len(products) == 6 and "PRODUCT('primitives'" in products[-1]
    assert r"PRODUCT('cone ''\X2\00DF\X0\'' cone'" in products[0]
    assert text.count("NEXT_ASSEMBLY_USAGE_OCCURRENCE(") == 5
    assert text.count("APPLICATION_PROTOCOL_DEFINITION(") == 1
    assert "SI_UNIT($,.METRE.)" in text and "noise" not in text and "stray" not in text
    assert text == SEGMENTS.export("step", unit="m").decode("ascii")


def test_a_cad_kernel_reads_all_faces_of_the_assembly_at_their_places(tmp_path: Path) -> None:
    pytest.importorskip("OCP", reason="the CAD kernel is not installed (extra cad)")
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.STEPControl import STEPControl_Reader

    file = tmp_path / "all.step"
    file.write_bytes(SEGMENTS.export("step", unit="mm"))
    reader = STEPControl_Reader()
    reader.ReadFile(str(file))
    assert reader.TransferRoots() == 1
    shape = reader.OneShape()
    areas = [segment.recognition.extents.area for segment in FITTED]  # type: ignore[union-attr]
    assert area_of(shape) == pytest.approx(sum(areas), rel=1e-6)
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box)
    mesh = trimesh.load(io.BytesIO(SEGMENTS.export("glb")), file_type="glb")
    corners = [[of.X(), of.Y(), of.Z()] for of in (box.CornerMin(), box.CornerMax())]
    np.testing.assert_allclose(corners, mesh.bounds, atol=0.02)


def test_a_glb_has_a_named_node_for_each_that_is_fitted_where_it_is() -> None:
    scene: Any = trimesh.load(io.BytesIO(SEGMENTS.export("glb", chord_error=1e-4)), file_type="glb")
    named = {f"{segment.label} {segment.recognition.primitive.kind}": segment for segment in FITTED}  # type: ignore[union-attr]
    assert set(scene.graph.nodes_geometry) == set(named)
    for name, segment in named.items():
        place, geometry = scene.graph[name]
        corners = trimesh.transform_points(scene.geometry[geometry].vertices, place)
        primitive = segment.recognition.primitive  # type: ignore[union-attr]
        assert np.abs(primitive.signed_distance(corners)).max() < 1e-5  # type: ignore[union-attr]


def test_a_table_has_a_row_for_each_and_the_columns_of_all_kinds() -> None:
    rows = list(csv.DictReader(io.StringIO(SEGMENTS.export("csv").decode())))
    assert [row["label"] for row in rows] == [segment.label for segment in SEGMENTS]
    names = list(rows[0])
    assert names[:4] == ["label", "status", "n_points", "kind"] and names[-1] == "message"
    assert set(names) > {"normal_x", "radius", "half_angle", "major_radius", "inlier_rms", "noise_scale"}
    for row, segment in zip(rows, SEGMENTS, strict=True):
        if segment.recognition is None:
            assert row["status"] == "problem" and row["message"] == segment.problem and not row["kind"]
            continue
        found = segment.recognition
        assert found.primitive is not None and found.error is not None
        assert (row["status"], row["kind"]) == (found.status, found.primitive.kind)
        assert float(row["inlier_rms"]) == found.error.inlier_rms
        radius = getattr(found.primitive, "radius", None)
        assert row["radius"] == ("" if radius is None else repr(radius))


def test_a_report_lists_all_and_shows_the_fits_with_their_pictures() -> None:
    page = SEGMENTS.export("report", unit="m").decode()
    root = ElementTree.fromstring(
        page.removeprefix("<!doctype html>\n")
        .replace('initial-scale=1">', 'initial-scale=1"/>')
        .replace('"utf-8">', '"utf-8"/>')
    )
    rows = root.findall(".//tbody/tr")
    assert [row[0].findtext("a") or row[0].text for row in rows] == sorted(CLOUDS)
    assert page.count("<svg") == 6 and page.count("<section") == 6
    assert "2 points given" in page and "5 fitted, 1 no fit, 1 problem" in page
    assert re.search(r"<td>radius [\d.]+ m</td>", page) and re.search(r'class="number">[\d.e-]+ m</td>', page)
    assert "Unit of lengths: m." in page
    for link in root.iter("a"):
        assert root.find(f".//*[@id='{link.get('href', '').lstrip('#')}']") is not None
    assert len(page) < 40_000 * 6


def test_a_report_of_many_shows_the_first_of_them_and_says_so() -> None:
    many = primfit.Segments([FITTED[0]] * 500)
    page = many.export("report").decode()
    assert page.count("<svg") == page.count("<section") == PICTURED
    assert page.count("<tr>") == 501 and f"The first {PICTURED}" in page


def test_answers_that_were_pickled_have_no_pictures_in_the_report() -> None:
    import pickle

    page = pickle.loads(pickle.dumps(SEGMENTS)).export("report").decode()
    assert "<svg" not in page and page.count("<section") == 6


def test_what_cannot_be_written_at_all_is_refused() -> None:
    with pytest.raises(primfit.InvalidOptionError, match="allowed are step, glb, csv, report"):
        SEGMENTS.export("stl")
    bad = primfit.Segments(segment for segment in SEGMENTS if segment not in FITTED)
    for name in ("step", "glb"):
        with pytest.raises(primfit.NothingToExportError, match="no answer has"):
            bad.export(name, unit="mm")
    assert b"problem" in bad.export("csv")
    points = CLOUDS["noise"]
    bare = primfit.fit_segments(points, np.zeros(400, int), include=["uncertainty"])
    with pytest.raises(primfit.InvalidOptionError, match="extents"):
        bare.export("step")
    assert bare.export("csv")


def test_no_two_parts_have_one_name() -> None:
    found = FITTED[0].recognition
    names = [name for name, _ in trimmed([Part({}, "A", found), Part({}, "a", found), Part({}, "b", found)])]
    assert len({name.casefold() for name in names}) == 3


@pytest.mark.parametrize(
    ("text", "written"),
    [("a'b\\c", r"'a''b\\c'"), ("é\n", r"'\X2\00E9\X0\\X2\000A\X0\'"), ("\U0001f600", r"'\X4\0001F600\X0\'")],
)
def test_texts_of_step_are_ascii(text: str, written: str) -> None:
    assert quoted(text) == written
