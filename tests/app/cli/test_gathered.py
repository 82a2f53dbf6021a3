"""The files about all clouds of a batch: an assembly, a table and a report of them."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from primfit.app.cli.commands import app
from tests.fitting.clouds import EXAMPLES, noisy


def run(*args: object) -> Result:
    return CliRunner().invoke(app, [str(arg) for arg in args])


@pytest.fixture(scope="module")
def clouds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sphere, a cylinder, noise, two points, and a table of something else."""
    folder = tmp_path_factory.mktemp("clouds")
    for kind in ("sphere", "cylinder"):
        np.savetxt(folder / f"{kind}.xyz", noisy(EXAMPLES[kind], 300, 0.005), fmt="%.17g")
    np.save(folder / "noise.npy", np.random.default_rng(0).uniform(size=(400, 3)))
    (folder / "few.csv").write_text("x,y,z\n1,2,3\n4,5,6\n")
    (folder / "attributes.csv").write_text("i,kind,noise\n1,sphere,0.1\n")
    return folder


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two segments in one file."""
    folder = tmp_path_factory.mktemp("scan")
    rows = [
        f"{x!r},{y!r},{z!r},{label}\n"
        for label, kind in ((3, "sphere"), (4, "plane"))
        for x, y, z in noisy(EXAMPLES[kind], 300, 0.005).tolist()
    ]
    (folder / "scan.csv").write_text("x,y,z,label\n" + "".join(rows))
    return folder


def files_of(folder: Path) -> list[object]:
    return ["--step", folder / "all.step", "--table", folder / "all.csv", "--report", folder / "all.html"]


def test_they_are_the_same_whatever_the_number_of_workers(clouds: Path, tmp_path: Path) -> None:
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        folder.mkdir()
        files = [*files_of(folder), "--unit", "m", "--workers", workers]
        result = run("batch", clouds, "--out", folder / "out", *files)
        assert result.exit_code == 2
        assert result.stdout.startswith(
            "4 clouds: 2 fitted, 0 ambiguous, 1 no_fit, 1 with a problem, 1 skipped; "
        )
    for name in ("all.step", "all.csv", "all.html"):
        assert (tmp_path / "1" / name).read_bytes() == (tmp_path / "2" / name).read_bytes()


def test_they_say_what_the_answers_say(clouds: Path, tmp_path: Path) -> None:
    run("batch", clouds, "--out", tmp_path / "out", *files_of(tmp_path), "--unit", "m", "--workers", 1)
    with (tmp_path / "all.csv").open(newline="") as stream:
        rows = {Path(row["file"]).name: row for row in csv.DictReader(stream)}
    assert list(rows) == ["cylinder.xyz", "few.csv", "noise.npy", "sphere.xyz"]
    assert [row["status"] for row in rows.values()] == ["fitted", "problem", "no_fit", "fitted"]
    answer = json.loads((tmp_path / "out" / "sphere.json").read_bytes())
    assert float(rows["sphere.xyz"]["radius"]) == answer["primitive"]["radius"]
    assert "2 points given" in rows["few.csv"]["message"] and not rows["few.csv"]["kind"]
    text = (tmp_path / "all.step").read_text("ascii")
    products = [line.split("'")[1] for line in text.splitlines() if "=PRODUCT(" in line]
    assert products == [
        "cylinder.xyz cylinder",
        "sphere.xyz sphere",
        "primitives",
    ]
    assert "SI_UNIT($,.METRE.)" in text
    page = (tmp_path / "all.html").read_text("utf-8")
    assert page.count("<svg") == 3 and "few.csv" in page and "attributes.csv" not in page


@pytest.mark.parametrize("workers", [1, 2])
def test_segments_have_their_labels(scan: Path, tmp_path: Path, workers: int) -> None:
    words = ["--labels", "auto", *files_of(tmp_path), "--unit", "mm", "--workers", workers]
    result = run("batch", scan, "--out", tmp_path / "out", *words)
    assert result.exit_code == 0
    with (tmp_path / "all.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["label"], row["kind"]) for row in rows] == [("3", "sphere"), ("4", "plane")]
    text = (tmp_path / "all.step").read_text("ascii")
    assert "PRODUCT('scan.csv#3 sphere'" in text and "PRODUCT('scan.csv#4 plane'" in text
    assert (tmp_path / "all.html").read_text("utf-8").count("<svg") == 2


def test_what_cannot_be_written_is_refused_before_anything_is_fitted(clouds: Path, tmp_path: Path) -> None:
    sphere, out = clouds / "sphere.xyz", tmp_path / "out"
    before = sphere.read_bytes()
    for words, said in (
        (["--step", tmp_path / "x.step", "--include", "none"], "--include: include names nothing"),
        (["--table", sphere], "--table: it would overwrite the input"),
        (["--table", out / "sphere.json"], "--table: something else is written to"),
        (["--table", tmp_path / "x", "--report", tmp_path / "x"], "--report: something else is written to"),
    ):
        result = run("batch", sphere, "--out", out, "--workers", 1, *words)
        assert result.exit_code == 2 and said in result.stderr
        assert not out.exists() and not (tmp_path / "x").exists()
    assert sphere.read_bytes() == before


def test_a_file_that_cannot_be_made_leaves_the_answers_and_the_other_files(
    clouds: Path, tmp_path: Path
) -> None:
    words = [*files_of(tmp_path), "--unit", "mm", "--workers", 1]
    result = run("batch", clouds / "noise.npy", "--out", tmp_path / "out", *words)
    assert result.exit_code == 2
    assert result.stderr == (
        f"primfit: {tmp_path / 'all.step'}: not written: no answer has a primitive that can be trimmed\n"
    )
    assert (tmp_path / "out" / "noise.json").exists() and (tmp_path / "all.html").exists()
    (tmp_path / "folder").mkdir()
    words = ["--table", tmp_path / "gone" / "all.csv", "--workers", 1]
    lost = run("batch", clouds / "sphere.xyz", "--out", tmp_path / "out", *words)
    assert lost.exit_code == 2 and "all.csv: cannot be written: No such file" in lost.stderr
