"""Answers that stand beside the clouds of a folder become records, once, and again where they change."""

import re

import numpy as np
import pytest

from primfit.benchmark.command import bench
from primfit.benchmark.records import RecordsFile
from primfit.benchmark.report.data import Data, of_the_paper

SPHERE = "3,2,0,0,0"


@pytest.fixture
def track(tmp_path):
    """Two spheres of radius 2, of which the published answers call one a plane."""
    folder = tmp_path / "track"
    folder.mkdir()
    directions = np.random.default_rng(3).standard_normal((2, 60, 3))
    spheres = 2.0 * directions / np.linalg.norm(directions, axis=2, keepdims=True)
    for number, points in enumerate(spheres, 1):
        np.savetxt(folder / f"pointCloud{number}.txt", points, delimiter=",")
    (folder / "ground_truth.csv").write_text(f"1,{SPHERE}\n2,{SPHERE}\n")
    (folder / "m4_predictions.csv").write_text("1,3,2.5,0,0,0\n2,1,0,0,1,0,0,0\n")
    return folder


def run(track, out, *more):
    assert bench(["run", "--shrec22", str(track), "--out", str(out), *more]) == 0
    file = RecordsFile(out)
    return file, {r.case: r for r in file.read() if r.method == "m4-published"}


def test_they_are_records_beside_those_of_methods(track, tmp_path, capsys):
    file, published = run(track, tmp_path / "out", "--show-wrong")
    shown = capsys.readouterr().out
    assert re.search(r"m4-published +1/2", shown)
    assert "wrong: shrec22 2, sphere (perturbation unknown, points up to 500): m4-published: plane" in shown
    assert (published["1"].right, published["2"].right) == (True, False)
    assert published["1"].errors["l2"] == pytest.approx(0.5)
    assert published["1"].errors["mfe_sampled"] == pytest.approx(0.5 / (2 * 2 * np.sqrt(3)), rel=0.15)
    assert published["1"].seconds is None and published["1"].status == "fitted"

    data = Data.of(file)
    assert data.methods == ["primfit", "m4-published"] and of_the_paper(data.methods) == ["m4-published"]
    assert data.decides("m4-published") and data.commands(["shrec22"]) == ["primfit bench run --shrec22 DIR"]


def test_they_are_added_once_and_again_where_the_file_changes(track, tmp_path, capsys):
    _, first = run(track, tmp_path / "out")
    _, again = run(track, tmp_path / "out")
    assert again == first and "are dropped" not in capsys.readouterr().out
    (track / "m4_predictions.csv").write_text("1,3,2.25,0,0,0\n")
    file, changed = run(track, tmp_path / "out")
    assert list(changed) == ["1"] and changed["1"].errors["l2"] == pytest.approx(0.25)
    assert "2 records are dropped" in capsys.readouterr().out
    assert [r.case for r in file.read() if r.method == "primfit"] == ["1", "2"]


def test_a_folder_without_them_has_none(track, tmp_path):
    (track / "m4_predictions.csv").unlink()
    file, published = run(track, tmp_path / "out")
    assert not published and "m4-published" not in file.methods()
