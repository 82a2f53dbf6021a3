"""`primfit fit`: readable and JSON answers, exit statuses, and files that cannot be read."""

import io
import json
import subprocess
import sys
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner, Result

from primfit.app.cli.commands import app
from primfit.app.cli.options import Kind
from primfit.app.cli.render import render
from primfit.app.cli.status import BADNESS, EXIT
from primfit.app.wire import schemas
from primfit.fitting.names import CRITERIA, KINDS
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.search.criteria import FINISHERS

AXIS = np.array([0.0, 0.6, 0.8])


def run(*args: object, stdin: bytes | None = None) -> Result:
    return CliRunner().invoke(app, [str(arg) for arg in args], input=stdin)


@pytest.fixture(scope="module")
def clouds(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cylinder, a ball filled at random (no primitive), two points, and a file of words."""
    folder = tmp_path_factory.mktemp("clouds")
    rng = np.random.default_rng(1)
    cylinder = Cylinder(AXIS, np.array([1.0, 2.0, 3.0]), 2.5)
    points = cylinder.surface(rng.uniform(0, 5, 600), rng.uniform(-3, 3, 600))
    np.savetxt(folder / "cylinder.csv", points, delimiter=",", header="x,y,z", comments="", fmt="%.17g")
    np.save(folder / "filled.npy", rng.uniform(-1, 1, (600, 3)))
    (folder / "two.csv").write_text("0,0,0\n1,2,3\n")
    (folder / "words.txt").write_text("not a cloud\n")
    return folder


def test_readable_answer_shows_parameters_and_trail(clouds: Path) -> None:
    result = run("fit", clouds / "cylinder.csv")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert result.stdout.count("unit not given") == 1
    shown = [line for line in lines if line.startswith(("kind ", "diameter ", "radius ", "fitted "))]
    assert [line.split()[1] for line in shown] == ["cylinder,", "5", "2.5", "Every"]
    assert "tried" in result.stdout and "accepted" in result.stdout


def test_what_is_piped_has_no_trailing_blanks(clouds: Path) -> None:
    text = run("fit", clouds / "cylinder.csv", clouds / "filled.npy").stdout
    assert text and not [line for line in text.splitlines() if line != line.rstrip()]


def test_json_is_one_object_a_line_and_nothing_else(clouds: Path) -> None:
    result = run("fit", "--json", "--max-error", "1e-3", clouds / "cylinder.csv", clouds / "filled.npy")
    first, second = (json.loads(line) for line in result.stdout.splitlines())
    assert first["primitive"]["kind"] == "cylinder"
    assert first["primitive"]["radius"] == pytest.approx(2.5, rel=1e-9)
    assert second["status"] == "no_fit"
    assert result.stderr == ""
    assert result.exit_code == EXIT["no_fit"]


def test_options_arrive(clouds: Path) -> None:
    result = run(
        *("fit", "--json", "--kind", "sphere", "--kind", "plane", "--classifier", "none"),
        *("--criterion", "least_squares", "--max-error", "1e-6", "--tolerance", "0.5"),
        *("--seed", "7", clouds / "cylinder.csv"),
    )
    body = json.loads(result.stdout)
    assert body["receipt"]["options"] == {
        "kinds": ["sphere", "plane"],
        "classifier": "none",
        "criterion": "least_squares",
        "max_error": 1e-6,
        "tolerance": 0.5,
        "seed": 7,
        "constraints": None,
        "initial_guess": None,
    }
    assert body["status"] == "no_fit"
    assert result.exit_code == 4


def test_criteria_have_one_set_of_names() -> None:
    names = set(CRITERIA)
    assert set(FINISHERS) == names
    assert set(get_args(schemas.CriterionName.__value__)) == names


def test_a_request_in_json_is_answered_as_the_service_would(tmp_path: Path) -> None:
    options = {"kinds": ["cone", "cylinder"], "seed": 3}
    body = {"points": np.random.default_rng(0).normal(size=(50, 3)).tolist(), "options": options}
    file = tmp_path / "request.json"
    file.write_text(json.dumps(body))
    used = json.loads(run("fit", "--json", "--classifier", "none", file).stdout)["receipt"]["options"]
    defaults = {"criterion": "robust", "constraints": None, "initial_guess": None}
    defaults |= {"max_error": None, "tolerance": None}
    assert used == {**defaults, "classifier": "none"} | options
    twice = run("fit", "--json", "--seed", "4", file)
    assert twice.exit_code == 2 and "options.seed: given in two places; keep one" in twice.stderr
    file.write_text(json.dumps(body | {"options": {"kinds": ["cone", "cone"]}}))
    assert "kinds names the same kind twice" in run("fit", file).stderr
    file.write_text(json.dumps(body | {"options": {"kind": ["cone"]}}))
    assert "options.kind: unknown option; allowed are kinds" in run("fit", file).stderr


def test_bad_files_are_named_and_the_others_are_done(clouds: Path) -> None:
    names = [clouds / name for name in ("missing.csv", "words.txt", "two.csv", "cylinder.csv")]
    result = run("fit", "--json", *names)
    assert len(result.stdout.splitlines()) == 1
    lines = result.stderr.splitlines()
    assert len(lines) == 3
    for line, name in zip(lines, names, strict=False):
        assert line.startswith(f"primfit: {name}: ")
    assert "No such file" in lines[0]
    assert result.exit_code == 2


def test_worst_status_wins() -> None:
    assert BADNESS == (EXIT["fitted"], EXIT["ambiguous"], EXIT["no_fit"], 2, 1)


def test_a_failure_of_ours_costs_one_file_only(clouds: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*args: object, **options: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("primfit.app.engine.answer.fit_prepared", broken)
    result = run("fit", "--json", clouds / "cylinder.csv", clouds / "words.txt")
    assert "cylinder.csv: internal error, please report it: ZeroDivisionError" in result.stderr
    assert "words.txt: " in result.stderr
    assert result.exit_code == 1


def test_standard_input(clouds: Path) -> None:
    named = run("fit", "--json", clouds / "cylinder.csv")
    piped = run("fit", "--json", "-", stdin=(clouds / "cylinder.csv").read_bytes())
    assert piped.stdout == named.stdout
    assert run("fit", "-", stdin=b"").stderr.startswith("primfit: -: ")


def test_a_folder_is_for_batch(clouds: Path) -> None:
    result = run("fit", "--json", clouds, clouds / "cylinder.csv")
    assert (
        result.stderr
        == f"primfit: {clouds}: a folder; to fit the clouds in it: primfit batch FOLDER --out ANSWERS\n"
    )
    assert (result.exit_code, len(result.stdout.splitlines())) == (2, 1)


@pytest.mark.parametrize("linked", [False, True])
def test_standard_input_is_not_overwritten(clouds: Path, tmp_path: Path, linked: bool) -> None:
    read = tmp_path / "cloud.csv"
    read.write_bytes((clouds / "cylinder.csv").read_bytes())
    written = tmp_path / "link.csv" if linked else read
    if linked:
        written.symlink_to(read)
    with read.open("rb") as stdin:
        done = subprocess.run(
            [sys.executable, "-m", "primfit", "fit", "-", "--csv-row", written],
            stdin=stdin,
            capture_output=True,
        )
    assert done.returncode == 2
    assert done.stderr.decode() == f"primfit: {written}: the export csv would overwrite the input\n"
    assert read.read_bytes() == (clouds / "cylinder.csv").read_bytes()


def test_names_from_a_file_do_not_move_the_cursor(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("x,y,z,\x1b[2Jw\n" + "1,2,3,4\n" * 5)
    result = run("fit", "--labels", "nosuch", tmp_path / "a.csv", tmp_path / "b\x1b[2J.csv")
    assert result.exit_code == 2 and len(result.stderr.splitlines()) == 2
    assert "\x1b" not in result.stderr


@pytest.mark.parametrize(
    ("option", "value", "said"),
    [
        ("--max-error", "-1", "max_error"),
        ("--tolerance", "-1", "tolerance is -1"),
        ("--seed", "-1", "seed"),
        ("--kind", "cube", "cube"),
        ("--classifier", "oracle", "oracle"),
    ],
)
def test_bad_options_are_refused_before_any_file_is_read(
    clouds: Path, option: str, value: str, said: str
) -> None:
    result = run("fit", "--json", option, value, clouds / "cylinder.csv")
    assert result.exit_code == 2
    assert result.stdout == ""
    assert said in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize("command", [["fit"], ["batch", "--out", "answers"]])
def test_a_kind_that_is_named_twice_is_refused(clouds: Path, command: list[str]) -> None:
    result = run(*command, "--kind", "cone", "--kind", "cone", clouds / "missing.csv")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == "primfit: --kind: kinds names the same kind twice\n"


def test_kinds_are_those_of_the_engine() -> None:
    assert tuple(Kind) == KINDS


def test_render_covers_every_status() -> None:
    """Built by hand: an ambiguous answer, and a no_fit where every attempt failed."""
    sphere = {"kind": "sphere", "center": [0.0, 0.0, 0.0], "radius": 1.0}
    cone = {"kind": "cone", "apex": [0.0, 0.0, 0.0], "axis": [0.0, 0.0, 1.0], "half_angle": np.pi / 6}
    receipt = {"n_points": 6, "format": "csv", "columns": ["x", "y", "z"], "unit": "mm"}
    lengths = dict.fromkeys(
        ("rms", "mean", "p95", "max", "zone", "inlier_rms", "inlier_zone", "inlier_share"), 0.1
    )
    cone |= {"error": lengths, "extents": None, "uncertainty": None, "evidence": -0.5}
    failed = {"kind": "cone", "probability": None, "outcome": "failed", "reason": "too few", "error": None}
    failed |= {"evidence": None}
    body = {"primitive": sphere, "alternatives": [cone], "message": "both", "error": None, "receipt": receipt}
    body |= {"active_constraints": {"radius": "fixed at 2.0"}, "extents": None, "uncertainty": None}
    ambiguous = _text(body | {"status": "ambiguous", "attempts": []})
    assert "ambiguous        both" in ambiguous and "or" in ambiguous and "30 degrees" in ambiguous
    assert "1 of 6, rms 0.100 mm" in ambiguous and "evidence" in ambiguous and "in mm" in ambiguous
    unknown = body | {"status": "ambiguous", "attempts": [], "receipt": receipt | {"unit": None}}
    assert _text(unknown).count("unit not given") == 1 and "mm" not in _text(unknown)
    nothing = body | {"status": "no_fit", "primitive": None, "alternatives": [], "attempts": [failed]}
    assert "no fit" in _text(nothing) and "too few" in _text(nothing)


def _text(body: dict[str, object]) -> str:
    console = Console(file=io.StringIO(), width=100)
    console.print(render("cloud.csv", body))
    return console.file.getvalue()  # type: ignore[attr-defined]


def test_help_imports_neither_numpy_nor_the_service() -> None:
    script = (
        "import sys\n"
        "from primfit.app.cli.commands import app\n"
        "try:\n    app(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'scipy', 'sklearn', 'fastapi', 'torch'} & set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)


def test_version() -> None:
    result = run("--version")
    assert result.exit_code == 0
    assert result.stdout.startswith("primfit 0.")


@pytest.fixture(scope="module")
def scan(clouds: Path) -> Path:
    """A file of three segments: a cylinder twice, by the same name as above, and two points."""
    rows = np.loadtxt(clouds / "cylinder.csv", delimiter=",", skiprows=1).tolist()
    labels = [2] * 300 + [-1] * 300 + [7] * 2
    lines = [f"{x!r},{y!r},{z!r},{label}" for (x, y, z), label in zip(rows + rows[:2], labels, strict=True)]
    (clouds / "scan.csv").write_text("\n".join(["x,y,z,segment", *lines]))
    return clouds / "scan.csv"


@pytest.mark.parametrize("column", ["segment", "auto"])
def test_segments_are_answered_on_the_lines_of_the_service(scan: Path, service: Any, column: str) -> None:
    result = run(
        "fit", "--json", "--labels", column, "--kind", "cylinder", scan, scan.parent / "words.txt", scan
    )
    files = [("file", (path.name, path.read_bytes())) for path in (scan, scan.parent / "words.txt", scan)]
    reply = service.client.post("/fit/batch", files=files, params={"kinds": "cylinder", "labels": column})
    lines = [line for line in reply.text.splitlines() if '"answer":' in line]
    assert result.stdout.splitlines() == lines and len(lines) == 4
    assert [json.loads(line)["id"] for line in lines] == [
        *("scan.csv#-1", "scan.csv#2", "scan.csv~2#-1", "scan.csv~2#2")
    ]
    complaints = result.stderr.splitlines()
    assert complaints[0].startswith(f"primfit: {scan}#7: 2 points given")
    assert complaints[1].startswith(f"primfit: {scan.parent / 'words.txt'}: ")
    assert len(complaints) == 3 and result.exit_code == 2


def test_segments_are_shown_under_their_labels(scan: Path) -> None:
    result = run("fit", "--labels", "segment", "--kind", "cylinder", scan)
    assert "scan.csv#-1" in result.stdout and "scan.csv#2" in result.stdout
    whole = run("fit", "--labels", "", "--kind", "cylinder", scan)
    assert "scan.csv#" not in whole.stdout and whole.exit_code == 0
