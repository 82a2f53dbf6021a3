"""Segments of real scans from a folder: read in place, known by their kind alone, left out where absent."""

import numpy as np
import pytest

from primfit.benchmark.command import BAD_INPUT, bench
from primfit.benchmark.real import REAL, RealError, RealFolder
from primfit.benchmark.records import RecordsFile

HEADER = "file,kind,sensor\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A flat patch and a ball, as float32, and a ball whose kind is given wrong."""
    made = tmp_path_factory.mktemp("real")
    rng = np.random.default_rng(0)
    flat = np.column_stack([rng.random((300, 2)), 1e-3 * rng.standard_normal(300)]).astype(np.float32)
    ball = rng.standard_normal((300, 3))
    ball *= (1.0 + 1e-3 * rng.standard_normal((300, 1))) / np.linalg.norm(ball, axis=1, keepdims=True)
    for name, points in (("floor.npy", flat), ("ball.npy", ball), ("odd.npy", ball)):
        np.save(made / name, points)
    rows = ["floor.npy,plane,laser", "ball.npy,sphere,stereo", "odd.npy,torus,stereo"]
    (made / "manifest.csv").write_text(HEADER + "\n".join(rows) + "\n")
    return made


def test_segments_are_known_by_their_kind(folder):
    real = RealFolder(folder)
    assert real.names == ["floor.npy", "ball.npy", "odd.npy"]
    case = real.case("floor.npy")
    assert case.kind == "plane" and case.truth is None and case.points.dtype == np.float64
    assert case.groups == {"points": "up to 1,000"}


def test_a_run_and_its_report_name_the_files(folder, tmp_path, capsys):
    assert bench(["run", "--real", str(folder), "--out", str(tmp_path)]) == 0
    assert "primfit: 2 of 3 right" in capsys.readouterr().out
    records = list(RecordsFile(tmp_path).read())
    assert [(r.set, r.case, r.kind, r.right) for r in records] == [
        (REAL, "floor.npy", "plane", True),
        (REAL, "ball.npy", "sphere", True),
        (REAL, "odd.npy", "torus", False),
    ]
    assert all("surface" not in record.errors and record.errors["mfe"] is not None for record in records)
    assert bench(["report", "--records", str(tmp_path), "--out", str(tmp_path / "report")]) == 0
    text = (tmp_path / "report" / "benchmark.md").read_text()
    assert "| `floor.npy` | plane | plane | 300 |" in text
    assert "| `odd.npy` | torus | **sphere** | 300 |" in text
    assert "primfit bench run --real DIR\n" in text
    assert text.index("## Segments of real scans") < text.index("## What the estimator is held to")


def test_an_absent_folder_is_left_out_with_a_sentence(tmp_path, capsys):
    arguments = [
        "run",
        "--set",
        "foreign",
        "--n",
        "1",
        "--real",
        str(tmp_path / "no"),
        "--out",
        str(tmp_path),
    ]
    assert bench(arguments) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert "holds no manifest.csv, so there are no real segments" in shown and "1/1" in shown


def test_what_is_wrong_with_a_manifest_is_said(folder, tmp_path, capsys):
    for text, message in (
        ("name,kind\na.npy,plane\n", "has no column 'file'"),
        (HEADER + "a.npy,cube,laser\n", "names ['cube']"),
        (HEADER, "names no segments"),
    ):
        (tmp_path / "manifest.csv").write_text(text)
        with pytest.raises(RealError, match=message.replace("[", r"\[").replace("]", r"\]")):
            RealFolder(tmp_path)
        assert bench(["run", "--real", str(tmp_path), "--out", str(tmp_path)]) == BAD_INPUT
        assert message in capsys.readouterr().err


def test_files_that_hold_no_points_are_named(tmp_path):
    (tmp_path / "manifest.csv").write_text(HEADER + "gone.npy,plane,laser\nflat.npy,plane,laser\n")
    np.save(tmp_path / "flat.npy", np.zeros((4, 2)))
    real = RealFolder(tmp_path)
    with pytest.raises(RealError, match=r"gone\.npy cannot be read"):
        real.case("gone.npy")
    with pytest.raises(RealError, match=r"has the shape \(4, 2\)"):
        real.case("flat.npy")


def test_other_kinds_are_other_segments(folder, tmp_path):
    (tmp_path / "manifest.csv").write_text((folder / "manifest.csv").read_text().replace("torus", "sphere"))
    assert RealFolder(folder).fingerprint != RealFolder(tmp_path).fingerprint
