"""`primfit paper`: what is printed, how it ends, and what the answer leaves out."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from primfit.app.cli.commands import app, parts
from primfit.fitting.answer.summary import summary
from primfit.fitting.primitives.sphere import Sphere
from primfit.paper import command
from primfit.paper.answer import recognition, weights_of
from primfit.paper.method import Found
from tests.fitting.clouds import EXAMPLES, sample
from tests.paths import ROOT

PIPE = str(ROOT / "samples" / "pipe.ply")


@pytest.fixture(autouse=True)
def installed(monkeypatch):
    """The entry point, whatever the installed metadata says."""
    monkeypatch.setattr(parts, "_installed", lambda name: {"paper": command.paper}[name])


def told(*arguments):
    return CliRunner().invoke(app, ["paper", *arguments])


def test_the_answer_is_shown_as_that_of_fit():
    done = told("m1", PIPE, "--unit", "mm")
    assert done.exit_code == 0
    assert "2,000 points, ply x y z, in mm" in done.stdout
    assert "kind             cylinder" in done.stdout
    assert "cylinder            -         -" in done.stdout and "accepted" in done.stdout
    assert "noise" not in done.stdout and "95% interval" not in done.stdout


def test_json_is_a_line_a_file_with_what_is_not_known_left_out():
    done = told("m1", "--json", PIPE, PIPE)
    first, second = map(json.loads, done.stdout.splitlines())
    assert first == second and first["status"] == "fitted"
    assert first["uncertainty"] is first["noise"] is first["attempts"][0]["evidence"] is None
    assert first["error"]["inlier_share"] == 1.0 and first["error"]["rms"] == first["error"]["inlier_rms"]
    assert first["receipt"]["options"] == {"method": "m1"}
    assert first["receipt"]["versions"]["weights"] is weights_of("m1") is None
    assert [attempt["outcome"] for attempt in first["attempts"]].count("accepted") == 1


def test_the_receipt_has_the_weights_of_the_method():
    done = told("m2", "--json", PIPE)
    versions = json.loads(done.stdout)["receipt"]["versions"]
    assert versions["weights"] == weights_of("m2") and len(versions["weights"]) == 64


def test_the_worst_file_decides_and_the_others_are_answered(tmp_path):
    (tmp_path / "line.xyz").write_text("0 0 0\n0 0 0\n0 0 0\n0 0 0\n")
    done = told("m1", "--missing", "error", str(tmp_path / "line.xyz"), str(tmp_path / "none.xyz"), PIPE)
    assert done.exit_code == 2
    assert "no fit" in done.stdout and "all 4 points are the same one" in done.stdout.lower()
    assert "none.xyz: No such file" in done.stderr and "cylinder" in done.stdout
    assert told("m1", "--missing", "error", str(tmp_path / "line.xyz")).exit_code == 4


def test_a_method_that_does_not_exist_is_refused():
    done = told("m7", PIPE)
    assert done.exit_code == 2 and "m7" in done.stderr


def test_a_wheel_wants_a_checkout(monkeypatch):
    def missing(name):
        raise ModuleNotFoundError("No module named 'primfit.paper'")

    monkeypatch.setattr(parts, "_installed", missing)
    done = told("m1", PIPE)
    assert done.exit_code == 2 and done.stdout == ""
    assert done.stderr == f"primfit: paper: {parts.NOT_IN_WHEEL}\n" and "want a checkout" in done.stderr


def test_missing_weights_and_packages_are_named(monkeypatch, tmp_path):
    monkeypatch.setattr("primfit.paper.m2.DIRECTORY", tmp_path)
    done = told("m2", PIPE)
    assert done.exit_code == 2 and "'make weights-paper' trains them" in done.stderr
    monkeypatch.setitem(__import__("sys").modules, "torch", None)
    with pytest.raises(command.CannotRunError, match="brings it"):
        monkeypatch.setattr("primfit.paper.command.load", lambda name: __import__("torch"))
        command.loaded("m3")


def test_distances_are_those_of_all_points():
    points = sample(EXAMPLES["sphere"], 300)
    points[0] += 5.0
    found = Found(EXAMPLES["sphere"], attempts=("plane", "sphere"), probabilities=(("sphere", 0.75),))
    answer = recognition(found, points, "mm")
    away = EXAMPLES["sphere"].signed_distance(points)
    assert answer.error.max == pytest.approx(np.abs(away).max())
    assert answer.error.zone == pytest.approx(np.ptp(away))
    assert answer.error.relative_mean == pytest.approx(
        np.abs(away).mean() / np.linalg.norm(np.ptp(points, axis=0))
    )
    refused, accepted = answer.attempts
    assert (refused.outcome, refused.probability, refused.error) == ("refused", None, None)
    assert (accepted.outcome, accepted.probability, accepted.error) == ("accepted", 0.75, answer.error)
    assert "mm" in str(answer) and "noise" not in summary(answer.to_dict())


def test_an_answer_without_a_primitive_is_no_fit():
    answer = recognition(Found(None, "no kind gets a vote", ("plane",)), np.zeros((0, 3)))
    assert (answer.status, answer.primitive, answer.message) == ("no_fit", None, "No kind gets a vote.")
    assert [attempt.outcome for attempt in answer.attempts] == ["failed"]
    assert recognition(Found(Sphere([0, 0, 0], 1.0)), np.eye(3)).status == "fitted"
