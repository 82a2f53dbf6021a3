"""Folders in the track's layout: ours, the public one, and what is none."""

import numpy as np
import pytest

from primfit.benchmark.track import TrackError, TrackFolder, read_points, shrec22_cases
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere

CLOUD = "1,2,3\n4.5,5,6\n7,8,9e-1\n"


def write(folder, **texts):
    for name, text in texts.items():
        path = folder / name.replace("__", "/").replace("_csv", ".csv").replace("_txt", ".txt")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_one_file_of_truths(tmp_path):
    write(
        tmp_path,
        clouds__pointCloud10_txt=CLOUD,
        clouds__pointCloud9_txt=CLOUD,
        clouds__pointCloud7_txt=CLOUD,
        ground_truth_csv="10,1,0,0,1,4,5,6\n9,3,2.5,1,2,3\n",
        perturbation_csv="10,0,0,0,1,553,5,1,2557,0,0,0,0,0\n",
    )
    cases = list(shrec22_cases(tmp_path))
    assert [case.name for case in cases] == ["9", "10"]  # cloud 7 has no truth
    assert isinstance(cases[0].truth, Sphere) and cases[0].truth.radius == 2.5
    assert isinstance(cases[1].truth, Plane)
    assert [case.groups["perturbation"] for case in cases] == ["A0", "A6"]
    assert cases[0].groups["points"] == "up to 500"
    number = TrackFolder(tmp_path).fingerprint
    assert number == TrackFolder(tmp_path).fingerprint
    write(tmp_path, ground_truth_csv="10,1,0,0,1,4,5,6\n9,3,2.25,1,2,3\n")
    assert number != TrackFolder(tmp_path).fingerprint
    assert np.array_equal(cases[1].points, [[1, 2, 3], [4.5, 5, 6], [7, 8, 0.9]])


def test_a_file_for_each_truth(tmp_path):
    write(
        tmp_path,
        test__pointCloud__pointCloud1_txt=CLOUD.replace(",", " "),
        test__GTpointCloud__GTpointCloud1_txt="3\n2.5\n1\n2\n3\n",
    )
    (case,) = shrec22_cases(tmp_path)
    assert case.truth.radius == 2.5 and case.points.shape == (3, 3)
    assert case.groups["perturbation"] == "unknown"


def test_published_answers_may_stand_beside(tmp_path):
    texts = {"pointCloud1_txt": CLOUD, "pointCloud2_txt": CLOUD, "ground_truth_csv": "1,3,1,0,0,0\n"}
    write(tmp_path, **texts)
    number = TrackFolder(tmp_path).fingerprint
    assert TrackFolder(tmp_path).published == {}
    (tmp_path / "m4_predictions.csv").write_text("1,3,2.5,1,2,3\n2,1,0,0,1,4,5,6\n")
    (tmp_path / "m6_predictions.csv").write_text("1,1,0,0,1,4,5,6\n")
    folder = TrackFolder(tmp_path)
    assert {name: list(answers) for name, answers in folder.published.items()} == {
        "m4-published": ["1", "2"],
        "m6-published": ["1"],
    }
    assert folder.published["m4-published"]["1"].radius == 2.5
    assert folder.fingerprint == number
    (tmp_path / "m4_predictions.csv").write_text("1,3,2.5\n")
    with pytest.raises(TrackError, match=r"answer of m4 on cloud 1 .* sphere has 4 parameters, not 1"):
        TrackFolder(tmp_path)


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        ({"notes_txt": "1,2,3"}, r"holds no pointCloud1.txt"),
        (
            {"pointCloud1_txt": CLOUD, "ground_truth_csv": "1,3,2.5,1\n"},
            r"truth of cloud 1 .* sphere has 4 parameters, not 2",
        ),
        ({"pointCloud1_txt": CLOUD}, r"holds 1 clouds, but no ground_truth.csv"),
        ({"a__pointCloud1_txt": CLOUD, "b__pointCloud1_txt": CLOUD}, r"a/pointCloud1.txt and .* same number"),
    ],
)
def test_other_folders_are_refused(tmp_path, texts, message):
    write(tmp_path, **texts)
    with pytest.raises(TrackError, match=message):
        TrackFolder(tmp_path)


@pytest.mark.parametrize("text", ["1,2\n3,4\n", "1,2,three\n", ""])
def test_files_without_points_are_named(tmp_path, text):
    path = tmp_path / "pointCloud1.txt"
    path.write_text(text)
    with pytest.raises(TrackError, match=r"pointCloud1.txt does not hold three numbers a line"):
        read_points(path)


@pytest.mark.parametrize(
    ("flags", "perturbation"),
    [
        ((), "A0"),
        ((0,), "A1"),
        ((3,), "A2"),
        ((6,), "A3"),
        ((8,), "A4"),
        ((0, 6), "A5"),
        ((3, 6), "A6"),
        ((0, 8), "A7"),
        ((3, 8), "A8"),
        ((10,), "A9"),
        ((0, 10), "unknown"),
    ],
)
def test_the_tracks_flags_are_its_types(tmp_path, flags, perturbation):
    numbers = ["1" if place in flags else "0" for place in range(13)]
    write(
        tmp_path,
        pointCloud1_txt=CLOUD,
        ground_truth_csv="1,3,1,0,0,0\n",
        perturbation_csv=f"1,{','.join(numbers)}\n",
    )
    assert TrackFolder(tmp_path).case("1").groups["perturbation"] == perturbation
