"""The report's tables, from records that are made up; `tests/benchmark/test_command.py` has the files."""

from dataclasses import replace

import numpy as np
import pytest

from primfit.benchmark.records import Record, RecordsFile
from primfit.benchmark.report import paper, pictures
from primfit.benchmark.report.beside_paper import beside_the_paper
from primfit.benchmark.report.data import Data, NoRecordsError
from primfit.benchmark.report.details import details
from primfit.benchmark.report.markdown import milliseconds, percent, scientific, table
from primfit.benchmark.report.sections import at_a_glance, behind, methods, of_set
from primfit.fitting.names import KINDS
from tests.benchmark.made import record

ABOUT = {
    "package": "numpy",
    "decides_kind": True,
    "kinds": list(KINDS),
    "settings": "as shipped",
    "versions": {"numpy": "2"},
    "machine": "a machine",
}


def cases(method: str, set_: str, answers: list[str], seconds: float, error: float, **fields) -> list[Record]:
    """Planes and spheres in turns, one for each answer ("right" is the true kind)."""
    made = []
    for case, answer in enumerate(answers):
        kind = KINDS[case % 2]
        one = record(kind, kind if answer == "right" else answer, surface=error)
        errors = dict.fromkeys(
            ("l2", "relative_l2", "surface", "mfe", "mfe_sampled", "hausdorff", "hausdorff_sampled"), error
        )
        own = dict.fromkeys(("mfe", "mfe_sampled", "hausdorff", "hausdorff_sampled"), 0.25)
        groups = {"perturbation": f"A{case}", "points": "up to 500", "noise": "none", "outliers": "none"}
        given = {"set": set_, "case": str(case), "method": method, "seconds": seconds, "cpu_seconds": seconds}
        made.append(replace(one, groups=groups, errors=errors, truth_errors=own, **given, **fields))
    return made


@pytest.fixture(scope="module")
def data():
    records = []
    for set_ in ("shrec", "scanner"):
        records += cases("primfit", set_, ["right", "right", "ambiguous", "right"], 0.040, 1e-3)
        records += cases("cgal", set_, ["right", "torus", "no_fit", "failed"], 0.100, 1e-2)
        records += [r for r in cases("open3d", set_, ["right"] * 4, 0.002, 1e-4) if r.kind == "plane"]
    told = {
        "primfit": ABOUT,
        "cgal": ABOUT,
        "open3d": ABOUT | {"decides_kind": False, "kinds": ["plane"]},
    }
    return Data(records, told)


def rows(lines, start: str) -> list[list[str]]:
    """The cells of the table rows that begin with a text."""
    split = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("|")]
    return [cells for cells in split if cells[0] == start]


def test_at_a_glance(data):
    lines = list(at_a_glance(data, {"overview"}))
    assert rows(lines, "**primfit**") == [
        ["**primfit**", "found", *["75.0%", "75.0%", "1.0e-03", "40"] * 2],
    ]
    assert rows(lines, "cgal") == [["cgal", "found", *["25.0%", "25.0%", "wrong", "100"] * 2]]
    assert rows(lines, "open3d") == [["open3d", "given, 1 of 5", *["–", "100%", "1.0e-04", "2"] * 2]]


def test_where_primfit_is_not_ahead_is_said_on_common_clouds(data):
    lines = list(behind(data))
    assert rows(lines, "cgal") == [["cgal", "–", "–", "–"]]
    # open3d saw the planes alone, of which primfit has one in two.
    assert rows(lines, "open3d (kind given)") == [
        [
            "open3d (kind given)",
            "shrec 100% / 50.0%<br>scanner 100% / 50.0%",
            "shrec 1.0e-04 / 1.0e-03<br>scanner 1.0e-04 / 1.0e-03",
            "shrec 2 / 40<br>scanner 2 / 40",
        ]
    ]
    weak = rows(lines, "shrec")
    assert ["shrec", "perturbation: A2", "0%", "", "1", "", "1"] in weak
    assert ["shrec", "points: up to 500", "75.0%", "", "1", "", "4"] in weak


def test_rejections_and_failures_are_shown_apart(data):
    (cells,) = rows(of_set(data, "shrec", ()), "cgal")[:1]
    assert cells[:8] == ["cgal", "4", "25.0%", "1", "", "1", "1", "25.0%"]
    lines = list(of_set(data, "shrec", {"errors"}))
    assert ["**primfit**", "100%", "100%", "0%", "100%"] in rows(lines, "**primfit**")
    assert ["**primfit**", "1.0e-03", "1.0e-03", "wrong", "1.0e-03"] in rows(lines, "**primfit**")
    assert [line for line in lines if line.startswith("![")] == [
        "![How the errors are spread, on the benchmark and on scans](images/benchmark-errors.png)"
    ]
    commands = [line for line in lines if line.startswith("primfit bench run")]
    assert commands == ["primfit bench run --set shrec --n 4 --seed 1 --peers"]


def test_the_papers_numbers_stand_beside_and_are_marked(data):
    lines = list(beside_the_paper(data, "shrec"))
    assert rows(lines, "M4 (paper)")[0] == ["M4 (paper)", "0.9838", "0.9960", "0.9838", "0.9959", "0.9935"]
    assert rows(lines, "M4 (paper)")[1][1:] == ["2.4e-07", "1.5e-02", "4.4e-02", "5.2e-02", "1.8e-01"]
    assert len(rows(lines, "M4 (paper)")) == 4  # table 1, L2, sampled MFE and Hausdorff distance
    assert rows(lines, "*truth*")[0] == ["*truth*", "2.5e-01", "2.5e-01", "2.5e-01", "2.5e-01", "0.0e+00"]
    assert rows(lines, "**primfit**")[1] == [
        "**primfit**",
        "1.0e-03",
        "1.0e-03",
        "1.0e-03",
        "1.0e-03",
        "0.0e+00",
    ]


def test_the_papers_tables_are_whole():
    for rate in paper.CLASSIFICATION.values():
        assert list(rate) == [f"M{i}" for i in range(1, 7)]
        for *classes, average in rate.values():
            assert np.mean(classes) == pytest.approx(average, abs=1.1e-4)
    for measure in paper.ERRORS.values():
        assert all(q1 <= q2 <= q3 for q1, q2, q3, _, _ in measure.values())


def test_details_hold_every_level_and_class(data):
    lines = list(details(data, "benchmark.md"))
    outcomes, errors = rows(lines, "A2"), rows(lines, "A2")[3:]
    assert [cells[1] for cells in outcomes] == ["**primfit**", "cgal", "open3d"] * 2
    # No position is known here; the truth's own errors stand beside MFE and Hausdorff distance.
    assert errors[2][2:12] == ["1.0e-04", "1.0e-04", "1.0e-04", "1.0e-04", "0.0e+00"] * 2
    assert errors[2][17:23] == ["1.0e-04", "1.0e-04", "1.0e-04", "1.0e-04", "0.0e+00", "2.5e-01"]
    assert [cells[1] for cells in rows(lines, "A3")] == ["**primfit**", "cgal"] * 2
    assert ["PPV", "**primfit**", "1.0000", "–", "1.0000", "–", "–", "1.0000"] in rows(lines, "PPV")
    assert ["cgal", "sphere", "", "", "", "", "1", "", "", "1"] in rows(lines, "cgal")


def test_failures_are_counted(data):
    (cells,) = rows(methods(data), "cgal")
    assert cells[-5:] == ["8", "", "", "2", "1.0"]


def test_methods_that_saw_other_clouds_are_refused(tmp_path):
    file = RecordsFile(tmp_path)
    for one in (record("plane", "plane"), record("plane", "plane", method="cgal", cloud="other")):
        file.append(one)
    with pytest.raises(NoRecordsError, match="saw different clouds as shrec 0 of seed 1"):
        Data.of(file)


def test_pictures_need_no_set(data):
    """What there are no records for is left out."""
    few = Data([one for one in data.records if one.set == "scanner"], data.about)
    drawn = {name for name, picture in pictures.PICTURES.items() if picture(few) is not None}
    assert drawn == {"overview", "errors", "confusion"}
    assert list(at_a_glance(Data([record("plane", "plane", set="arcs")], data.about), drawn)) == []


def test_numbers_in_cells():
    assert [percent(share) for share in (0.0, 1.0, 0.5, 0.9999, 0.0001, np.nan)] == [
        "0%",
        "100%",
        "50.0%",
        "over 99%",
        "0.01%",
        "–",
    ]
    assert [scientific(value) for value in (1.5e-16, np.inf, np.nan)] == ["1.5e-16", "wrong", "–"]
    assert [milliseconds(value) for value in (0.00052, 0.031, 0.145, 2.5)] == ["0.52", "31", "145", "2,500"]
    assert table(["a", "b"], [["x", "1"]]) == ["| a | b |", "| --- | --: |", "| x | 1 |"]
