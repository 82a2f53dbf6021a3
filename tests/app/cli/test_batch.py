"""`primfit batch`: which files, the same answers whatever the number of workers, and nothing overwritten."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from primfit.app.cli.commands import app
from primfit.app.cli.plan import CollisionError, plan
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.sphere import Sphere
from tests.app.processes import children, needs_proc


def run(*args: object) -> Result:
    return CliRunner().invoke(app, [str(arg) for arg in args])


@pytest.fixture(scope="module")
def clouds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sphere and a plane in inner folders, a file that is no cloud, and one that is none of ours."""
    folder = tmp_path_factory.mktemp("clouds")
    rng = np.random.default_rng(3)
    for inner, primitive in {
        "a": Sphere(np.array([1.0, 2.0, 3.0]), 0.5),
        "b": Plane(np.array([0.0, 0.0, 1.0]), np.zeros(3)),
    }.items():
        (folder / inner).mkdir()
        points = primitive.surface(rng.uniform(0, 3, 300), rng.uniform(0, 3, 300))
        np.savetxt(folder / inner / "cloud.txt", points, delimiter=",", fmt="%.17g")
    (folder / "words.txt").write_text("not a cloud\n")
    (folder / "readme.md").write_text("not looked at\n")
    return folder


def test_answers_problems_and_counts(clouds: Path, tmp_path: Path) -> None:
    result = run("batch", clouds, "--out", tmp_path, "--workers", 1)
    assert sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*.*")) == [
        "a/cloud.json",
        "b/cloud.json",
    ]
    assert json.loads((tmp_path / "a" / "cloud.json").read_bytes())["primitive"]["kind"] == "sphere"
    words, suffixes = result.stderr.splitlines()
    assert words.startswith(f"primfit: {clouds / 'words.txt'}: skipped, since it is no cloud: ")
    assert suffixes == "primfit: batch: skipped by their suffixes: 1 .md"
    assert result.stdout.startswith(
        "2 clouds: 2 fitted, 0 ambiguous, 0 no_fit, 0 with a problem, 2 skipped; answers in "
    )
    assert result.exit_code == 0


def test_what_is_named_or_holds_points_is_not_skipped(clouds: Path, tmp_path: Path) -> None:
    named = run("batch", clouds / "words.txt", "--out", tmp_path, "--workers", 1)
    assert named.exit_code == 2 and "skipped" not in named.stderr + named.stdout
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "bad.txt").write_text("1 2 3\n4 5 6\n7 8 words\n")
    (tmp_path / "in" / "few.csv").write_text("x,y,z\n1,2,3\n4,5,6\n")
    result = run("batch", tmp_path / "in", "--out", tmp_path / "out", "--workers", 1)
    assert result.exit_code == 2
    assert result.stdout.startswith("2 clouds: 0 fitted, 0 ambiguous, 0 no_fit, 2 with a problem; ")


@pytest.mark.parametrize("workers", [1, 2])
def test_tables_of_something_else_and_texts_without_points_are_skipped(
    clouds: Path, tmp_path: Path, workers: int
) -> None:
    (tmp_path / "cloud.txt").write_bytes((clouds / "a" / "cloud.txt").read_bytes())
    (tmp_path / "attributes.csv").write_text("i,n_points,kind,noise\n1,300,sphere,0.1\n2,400,plane,0.2\n")
    (tmp_path / "header.csv").write_text("x,y,z\n")
    (tmp_path / "empty.xyz").write_text("")
    (tmp_path / "pairs.txt").write_text("1 2\n3 4\n5 6\n")
    out = tmp_path / "out"
    result = run("batch", tmp_path, "--out", out, "--workers", workers)
    assert result.exit_code == 0
    skipped = [line.split(": ")[1] for line in result.stderr.splitlines()]
    assert skipped == [
        str(tmp_path / name) for name in ("attributes.csv", "empty.xyz", "header.csv", "pairs.txt")
    ]
    assert [file.name for file in out.iterdir()] == ["cloud.json"]
    (tmp_path / "cloud.txt").unlink()
    alone = run("batch", tmp_path, "--out", out, "--workers", workers)
    assert alone.exit_code == 2 and alone.stdout.startswith("0 clouds")


def test_answer_is_that_of_fit_and_does_not_depend_on_the_workers(clouds: Path, tmp_path: Path) -> None:
    for workers in (1, 2):
        run(
            "batch",
            clouds / "a",
            clouds / "b" / "cloud.txt",
            "--out",
            tmp_path / "same",
            "--workers",
            workers,
        )
        done = run("batch", clouds, "--out", tmp_path / str(workers), "--workers", workers)
        assert "Traceback" not in done.stderr
    for name in ("a/cloud.json", "b/cloud.json"):
        one = (tmp_path / "1" / name).read_bytes()
        assert one == (tmp_path / "2" / name).read_bytes()
        assert one.decode() == run("fit", "--json", (clouds / name).with_suffix(".txt")).stdout


def test_track_format(clouds: Path, tmp_path: Path) -> None:
    result = run("batch", clouds / "a" / "cloud.txt", "--out", tmp_path, "--format", "shrec22")
    assert result.exit_code == 0
    label, *numbers = (tmp_path / "cloud_prediction.txt").read_text().splitlines()
    fitted = json.loads(run("fit", "--json", clouds / "a" / "cloud.txt").stdout)["primitive"]
    assert label == "3"
    assert [float(n) for n in numbers] == [fitted["radius"], *fitted["center"]]


def test_predictions_of_an_earlier_run_are_no_clouds(clouds: Path, tmp_path: Path) -> None:
    (tmp_path / "cloud.txt").write_bytes((clouds / "a" / "cloud.txt").read_bytes())
    for _ in range(2):
        result = run("batch", tmp_path, "--out", tmp_path, "--format", "shrec22", "--workers", 1)
        assert result.stdout.startswith("1 clouds: 1 fitted")


def test_two_inputs_with_one_stem_are_refused(clouds: Path, tmp_path: Path) -> None:
    result = run("batch", clouds / "a" / "cloud.txt", clouds / "b" / "cloud.txt", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "would both write" in result.stderr
    assert not (tmp_path / "out").exists()


def test_an_input_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "cloud.json").write_text("{}")
    with pytest.raises(CollisionError, match="overwrite the input"):
        plan([str(tmp_path / "cloud.json")], tmp_path, "json")


def test_an_input_named_like_half_an_answer_is_kept(clouds: Path, tmp_path: Path) -> None:
    cloud = (clouds / "a" / "cloud.txt").read_bytes()
    (tmp_path / "x.csv").write_bytes(cloud)
    (tmp_path / "x.json.part").write_bytes(cloud)
    result = run("batch", tmp_path / "x.csv", tmp_path / "x.json.part", "--out", tmp_path, "--workers", 1)
    assert result.exit_code == 0
    assert (tmp_path / "x.json.part").read_bytes() == cloud
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["x.csv", "x.json", "x.json.json", "x.json.part"]


def test_an_answer_that_cannot_be_written_leaves_nothing(clouds: Path, tmp_path: Path) -> None:
    (tmp_path / "cloud.json").mkdir()
    result = run("batch", clouds / "a" / "cloud.txt", "--out", tmp_path, "--workers", 1)
    assert result.exit_code == 2
    assert result.stderr == f"primfit: {tmp_path / 'cloud.json'}: cannot be written: Is a directory\n"
    assert [path.name for path in tmp_path.iterdir()] == ["cloud.json"]


def test_two_inputs_that_write_one_file_through_a_link_are_refused(tmp_path: Path) -> None:
    for inner in ("p", "q"):
        (tmp_path / "tree" / inner).mkdir(parents=True)
        (tmp_path / "tree" / inner / "x.csv").write_text("")
    out, inputs = tmp_path / "out", [str(tmp_path / "tree")]
    assert len(plan(inputs, out, "json").targets) == 2
    (out / "p").mkdir(parents=True)
    (out / "q").symlink_to("p")
    with pytest.raises(CollisionError, match="would both write"):
        plan(inputs, out, "json")


def test_two_inputs_whose_segments_go_into_one_folder_through_a_link_are_refused(tmp_path: Path) -> None:
    (tmp_path / "tree").mkdir()
    for name in ("x.csv", "y.csv"):
        (tmp_path / "tree" / name).write_text("")
    out, inputs = tmp_path / "out", [str(tmp_path / "tree")]
    assert len(plan(inputs, out, "json", "label").targets) == 2
    (out / "x").mkdir(parents=True)
    (out / "y").symlink_to("x")
    assert len(plan(inputs, out, "json").targets) == 2
    with pytest.raises(CollisionError, match="would both write into"):
        plan(inputs, out, "json", "label")


def test_the_same_file_twice_is_done_once(tmp_path: Path) -> None:
    (tmp_path / "cloud.csv").write_text("")
    assert len(plan([str(tmp_path), str(tmp_path / "cloud.csv")], tmp_path / "out", "json").targets) == 1


def test_an_empty_folder_is_said(tmp_path: Path) -> None:
    result = run("batch", tmp_path, "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert "no .asc .csv" in result.stderr


def test_a_folder_that_cannot_be_written_is_said_plainly(clouds: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way\n")
    result = run("batch", clouds / "a", "--out", tmp_path / "file" / "inner", "--workers", 1)
    assert result.exit_code == 2
    assert "cannot be written" in result.stderr and len(result.stderr.splitlines()) == 1


def test_a_url_is_no_folder(clouds: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run("batch", clouds, "--out", "s3://bucket/answers")
    assert result.exit_code == 2
    assert "not to a URL" in " ".join(result.stderr.replace("│", " ").split())
    assert list(tmp_path.iterdir()) == []


def test_what_stands_in_the_way_of_a_folder_is_no_folder(clouds: Path, tmp_path: Path) -> None:
    (tmp_path / "a").write_text("in the way\n")
    (tmp_path / "gone").symlink_to("missing")
    for source, out, named in (
        (clouds, tmp_path, tmp_path / "a"),
        (clouds, tmp_path / "gone", tmp_path / "gone"),
        (clouds / "a" / "cloud.txt", os.devnull, os.devnull),
    ):
        result = run("batch", source, "--out", out, "--workers", 1)
        assert result.exit_code == 2
        assert result.stderr == f"primfit: {named}: cannot be written: it is no folder\n"


@needs_proc
def test_a_process_that_is_killed_ends_the_run_with_a_sentence(tmp_path: Path) -> None:
    process = _under_way(tmp_path, workers=2)
    workers = [worker for child in children(process.pid) for worker in children(child)]
    assert len(workers) == 2
    os.kill(workers[0], signal.SIGKILL)
    said = process.communicate(timeout=60)[1]
    assert process.returncode == 1
    assert said.startswith("primfit: batch: a process was ended from outside") and len(said.splitlines()) == 1


@pytest.mark.parametrize("workers", [1, 2])
def test_an_interrupted_run_says_how_many_are_done_and_where(tmp_path: Path, workers: int) -> None:
    process = _under_way(tmp_path, workers)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=60)[1]
    written = list((tmp_path / "out").iterdir())
    assert said == f"primfit: batch: {len(written)} of 3000 done; answers are in {tmp_path / 'out'}\n"
    assert process.returncode == 130
    assert {file.suffix for file in written} == {".json"}


def _under_way(folder: Path, workers: int) -> "subprocess.Popen[str]":
    """A long run that has written its first answer, into `out`."""
    (folder / "in").mkdir()
    points = np.random.default_rng(0).normal(size=(500, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    for index in range(3000):
        np.save(folder / "in" / f"{index:04}.npy", points)
    # It listens to an interrupt also where a shell has its background jobs ignore it.
    script = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from primfit.app.cli.commands import main; main()"
    )
    words = ["batch", str(folder / "in"), "--out", str(folder / "out"), "--workers", str(workers)]
    process = subprocess.Popen([sys.executable, "-c", script, *words], stderr=subprocess.PIPE, text=True)
    while not list((folder / "out").glob("*.json")):
        assert process.poll() is None
        time.sleep(0.01)
    return process


@pytest.fixture(scope="module")
def scan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a labeled scan, of which one segment is too small, and a cloud without labels."""
    folder = tmp_path_factory.mktemp("scan")
    rng = np.random.default_rng(5)
    sphere = Sphere(np.array([1.0, 2.0, 3.0]), 0.5).surface(rng.uniform(0, 3, 300), rng.uniform(0, 3, 300))
    plane = Plane(np.array([0.0, 0.0, 1.0]), np.zeros(3)).surface(*rng.uniform(0, 3, (2, 300)))
    labels = ["a/b"] * 300 + ["a_B"] * 300 + ["crumb"] * 2
    rows = zip(np.vstack([sphere, plane, plane[:2]]).tolist(), labels, strict=True)
    text = "".join(f"{x!r},{y!r},{z!r},{label}\n" for (x, y, z), label in rows)
    (folder / "scan.csv").write_text("x,y,z,part\n" + text)
    np.savetxt(folder / "single.csv", sphere, delimiter=",", header="x,y,z", comments="", fmt="%.17g")
    return folder


def test_segments_go_into_files_of_their_own(scan: Path, tmp_path: Path) -> None:
    for workers in (1, 2):
        out = tmp_path / str(workers)
        result = run("batch", scan / "scan.csv", "--out", out, "--labels", "part", "--workers", workers)
        assert result.exit_code == 2
        assert result.stdout.startswith("3 clouds: 2 fitted, 0 ambiguous, 0 no_fit, 1 with a problem")
        assert result.stderr == f"primfit: {scan / 'scan.csv'}#crumb: 2 points given; at least 3 are needed\n"
        assert sorted(str(p.relative_to(out)) for p in out.rglob("*.*")) == [
            "scan/a_B~2.json",
            "scan/a_b.json",
        ]
    kinds = {
        p.name: json.loads(p.read_bytes())["primitive"]["kind"] for p in (tmp_path / "1" / "scan").iterdir()
    }
    assert kinds == {"a_b.json": "sphere", "a_B~2.json": "plane"}
    for file in (tmp_path / "1" / "scan").iterdir():
        assert file.read_bytes() == (tmp_path / "2" / "scan" / file.name).read_bytes()


def test_segments_in_the_format_of_the_track(scan: Path, tmp_path: Path) -> None:
    run("batch", scan, "--out", tmp_path, "--labels", "part", "--format", "shrec22", "--workers", 1)
    assert (tmp_path / "scan" / "a_b_prediction.txt").read_text().splitlines()[0] == "3"


def test_a_file_without_labels_keeps_its_place_where_they_are_looked_for(scan: Path, tmp_path: Path) -> None:
    result = run("batch", scan / "single.csv", "--out", tmp_path, "--labels", "auto", "--workers", 1)
    assert result.exit_code == 0
    assert [p.name for p in tmp_path.iterdir()] == ["single.json"]
    named = run("batch", scan / "single.csv", "--out", tmp_path, "--labels", "part", "--workers", 1)
    assert named.exit_code == 2 and "labels: there is no such column" in named.stderr


def test_folders_of_segments_never_mix(tmp_path: Path) -> None:
    (tmp_path / "in" / "scan").mkdir(parents=True)
    (tmp_path / "in" / "scan.csv").write_text("")
    (tmp_path / "in" / "scan" / "3.csv").write_text("")
    inputs = [str(tmp_path / "in")]
    assert len(plan(inputs, tmp_path / "out", "json").targets) == 2
    with pytest.raises(CollisionError, match="both write into"):
        plan(inputs, tmp_path / "out", "json", "label")
    (tmp_path / "in" / "scan" / "3.csv").unlink()
    request = tmp_path / "in" / "scan" / "3.json"
    request.write_text("{}")
    with pytest.raises(CollisionError, match="beside the input"):
        plan([*inputs, str(request)], tmp_path / "in", "json", "label")
