"""Raw records: what they hold, and that nothing is lost or doubled when a run is cut off."""

import json
from dataclasses import replace

import numpy as np
import pytest

from primfit.benchmark.cases import Case
from primfit.benchmark.records import Outcome, RecordsFile, Scored, to_primitive
from primfit.fitting.primitives import parameters
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.plane import Plane

PLANE = Plane([0, 0, 1], [0, 0, 0])
POINTS = np.array([[0, 0, 1], [4, 0, -1], [4, 3, 1], [0, 3, -1], [0, 0, 40]], float)
CASE = Case("7", POINTS, PLANE, {"level": 3}, np.array([False] * 4 + [True]))


def record(primitive=PLANE, status="fitted", case=CASE):
    outcome = Outcome(status, parameters(primitive) if primitive else None, "note", ("plane",), 0.25, 0.5)
    return Scored("outliers", 1, case).record("primfit", outcome, {"numpy": "2"})


def test_what_a_record_holds():
    made = record(Plane([0, 0, -1], [9, 9, 2]))
    assert made.key == ("outliers", 1, "7", "primfit") and made.right and not made.failed
    assert made.points == 5 and made.extent == pytest.approx(np.sqrt(16 + 9 + 4))
    # The outlier counts where points are measured, not where surfaces are compared.
    assert made.truth_errors["hausdorff"] == pytest.approx(40.0)
    assert made.errors["hausdorff"] == pytest.approx(38.0)
    assert made.truth_errors["mfe"] == pytest.approx(44 / 5 / np.sqrt(16 + 9 + 41**2))
    assert made.errors["position"] == pytest.approx(2.0)
    assert made.errors["surface"] == pytest.approx(2.0 / made.extent)
    assert made.errors["l2"] == pytest.approx(0.0)


def test_a_reference_is_fitted_where_answers_are_held_against_it():
    """The four points on the surface, at heights +-1, are a saddle: least squares finds the truth."""
    outcome = Outcome("fitted", parameters(Plane([0, 0, 1], [0, 0, 1])))
    noisy = replace(CASE, noise=2.0)
    made = Scored("outliers", 1, noisy).record("primfit", outcome, {})
    extent = np.sqrt(16 + 9 + 4)
    assert made.reference_errors["surface"] == pytest.approx(0.0, abs=1e-12)
    assert made.reference_errors["expected"] == pytest.approx(2.0 * np.sqrt(3 / 4) / extent)
    assert made.errors["surface"] == pytest.approx(1.0 / extent)
    for set_, case in (("arcs", noisy), ("outliers", CASE), ("outliers", replace(noisy, noise=0.0))):
        assert Scored(set_, 1, case).record("primfit", outcome, {}).reference_errors == {}


def test_records_of_older_versions_are_read(tmp_path):
    file = RecordsFile(tmp_path)
    file.append(record())
    values = json.loads(file.path.read_text())
    del values["reference_errors"], values["alternatives"]
    file.path.write_text(json.dumps(values) + "\n")
    assert list(file.read()) == [record()]


def test_far_coordinates_cost_no_digits():
    shift = np.array([1e7, -1e7, 1e7])
    far = Case("7", POINTS + shift, Plane([0, 0, 1], shift), {}, CASE.outliers)
    errors = record(Plane([0, 0, 1], shift + np.array([5, 5, 1])), case=far).errors
    assert errors["position"] == pytest.approx(1.0, abs=1e-8)
    assert errors["hausdorff"] == pytest.approx(39.0, abs=1e-8)


def test_answers_that_overflow_are_null():
    errors = record(Plane([0, 0, 1], [0, 0, 1e200])).errors
    assert errors["l2"] == 0.0 and errors["hausdorff"] == 1e200
    assert errors["surface"] is None  # 1e200 squared


def test_without_an_answer_only_the_truth_is_measured():
    made = record(None, "timeout")
    assert made.failed and not made.right and made.errors == {} and made.truth_errors["mfe"] > 0.0
    foreign = record(PLANE, case=Case("0", POINTS, None, {}))
    assert foreign.kind == "foreign" and foreign.truth is None and foreign.truth_errors == {}
    assert set(foreign.errors) == {"mfe", "hausdorff"}


def test_surfaces_are_sampled_where_the_paper_stands_beside():
    outcome = Outcome("fitted", parameters(PLANE))
    made = Scored("shrec", 1, CASE).record("primfit", outcome, {})
    assert made.errors["hausdorff_sampled"] >= made.errors["hausdorff"] == pytest.approx(40.0)
    assert set(made.truth_errors) == {"mfe", "hausdorff", "mfe_sampled", "hausdorff_sampled"}


def test_primitives_are_read_back_to_the_last_bit():
    cone = Cone([0.1, 0.2, 0.3], [1, 2, 3], 0.7)
    again = to_primitive(parameters(cone))
    assert np.array_equal(again.axis, cone.axis) and again.half_angle == cone.half_angle


def test_lines_are_read_back_and_a_torn_one_is_left_out(tmp_path):
    file = RecordsFile(tmp_path)
    assert list(file.read()) == []
    made = [record(), replace(record(), case="8", note="größer", seconds=None)]
    for one in made:
        file.append(one)
    assert list(file.read()) == made
    with file.path.open("a") as stream:
        stream.write('{"set": "outl')
    assert list(file.read()) == made
    file.rewrite(made[:1])
    file.append(made[1])
    assert list(file.read()) == made


def test_methods_are_added_and_renewed(tmp_path):
    file = RecordsFile(tmp_path)
    assert file.methods() == {}
    file.describe({"a": {"kinds": ["plane"]}, "b": {}})
    file.describe({"a": {"kinds": []}})
    assert file.methods() == {"a": {"kinds": []}, "b": {}}
