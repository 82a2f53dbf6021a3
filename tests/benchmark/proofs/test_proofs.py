"""`primfit bench proofs`: real cases of every set, records that can be made again, and the table."""

import json
from dataclasses import replace

import numpy as np
import pytest

from primfit.benchmark.command import bench
from primfit.benchmark.proofs import constraints, determinism, equivariance, least_squares, oracles, zones
from primfit.benchmark.proofs.constraint_oracle import optimum, violations
from primfit.benchmark.proofs.records import ProofRecord, ProofsFile, prove
from primfit.benchmark.records import RecordsFile
from primfit.benchmark.report import write
from primfit.benchmark.report.proof_bars import PROOF_BARS
from primfit.benchmark.report.proofs import proven
from primfit.fitting.primitives import parameters
from tests.benchmark.made import record
from tests.fitting.clouds import EXAMPLES, sample

COMMAND = ("proofs", "--set", "least-squares", "--set", "zones", "--set", "constraints", "--seed", "5")


def rows(records) -> dict[tuple[str, str], list[str]]:
    """The cells measured, cases, met?, command by case and bar."""
    lines = [line for line in proven(records) if line.startswith("|")][2:]
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]
    return {(case, bar): rest for case, bar, *rest in cells}


def made(set: str, figures: dict[str, float | None], case: int = 0, note: str = "", **groups) -> ProofRecord:
    return ProofRecord(set, 9, case, groups, "", figures, note, "")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Records of ten cases of three sets."""
    out = tmp_path_factory.mktemp("proofs")
    assert bench([*COMMAND, "--n", "10", "--out", str(out)]) == 0
    return out


def test_small_runs_meet_their_bars(folder):
    found = ProofsFile(folder).read()
    assert [each.key for each in found] == [
        (name, 5, case) for name in ("least-squares", "zones", "constraints") for case in range(10)
    ]
    table = rows(found)
    run = [cells for cells in table.values() if cells[0] != "not run"]
    assert len(run) >= 10 and {cells[2] for cells in run} == {"yes"}
    assert run[0][3] == "`primfit bench proofs --set least-squares --n 10 --seed 5`"


@pytest.mark.parametrize("key", [("least-squares", 5, 1), ("zones", 5, 4), ("constraints", 5, 2)])
def test_a_record_can_be_made_again(folder, key):
    assert prove(key) in ProofsFile(folder).read()


def test_a_run_goes_on_and_another_seed_replaces(folder, tmp_path):
    file = ProofsFile(tmp_path)
    lines = ProofsFile(folder).path.read_text().splitlines(keepends=True)
    file.path.write_text("".join(lines[:3]) + lines[3][:40])
    arguments = ["proofs", "--set", "least-squares", "--out", str(tmp_path)]
    assert bench([*arguments, "--n", "4", "--seed", "5", "--processes", "2"]) == 0
    assert file.read() == ProofsFile(folder).read()[:4]
    assert bench([*arguments, "--n", "1", "--seed", "6"]) == 0
    assert [each.key for each in file.read()] == [("least-squares", 6, 0)]
    of_another_state = [replace(each, source="else") for each in file.read()]
    file.begin([], restart=False)
    assert list(file.append(of_another_state)) == of_another_state
    assert file.begin([("least-squares", 6, 0)], restart=False) == [] and len(file.read()) == 1


def test_an_answer_beside_the_optimum_is_a_miss_and_no_answer_a_record(monkeypatch):
    true = least_squares.fitted

    def beside(kind, points, criterion):
        surface = true(kind, points, criterion)
        return surface | {"radius": surface["radius"] * (1.0 + 1e-5)}

    key = ("least-squares", 5, 1)
    monkeypatch.setattr(least_squares, "fitted", beside)
    missed = prove(key)
    assert missed.groups["kind"] == "sphere" and missed.figures["excess"] > 1e-8
    monkeypatch.setattr(least_squares, "fitted", lambda *_: 1 / 0)
    failed = prove(key)
    assert failed.note == "ZeroDivisionError: division by zero" and not failed.figures
    cells = rows([missed, failed])["`least_squares`, all kinds", PROOF_BARS[0].bar]
    assert "**2 beyond**, 1 without an answer" in cells[0] and cells[1:3] == ["2", "**no**"]


def test_clouds_are_followed():
    index = list(equivariance.CLOUDS).index("exact")
    found = prove(("equivariance", 5, index))
    assert set(found.figures) == set(equivariance.TRANSFORMATIONS) and not found.note
    assert all(value <= equivariance.MOST_ULP for value in found.figures.values())


@pytest.mark.parametrize("name", equivariance.TRANSFORMATIONS)
def test_transformations_are_undone(name):
    torus = EXAMPLES["torus"]
    points = sample(torus, 50)
    by = equivariance.TRANSFORMATIONS[name](points, np.random.default_rng(1))
    transformed = by.apply(points)
    far = torus.transformed(by.rotation, by.translation, by.scale)
    # 1,000 extents away from the origin three digits are lost
    assert np.abs(far.signed_distance(transformed)).max() / by.scale < 1e-11
    np.testing.assert_allclose(by.undo(far).row(), torus.row(), atol=1e-11)
    assert len(transformed) == (100 if name == "every point twice" else 50)


@pytest.mark.slow
def test_bodies_are_compared_byte_for_byte(monkeypatch):
    monkeypatch.setattr(determinism, "CLOUDS", 2)
    monkeypatch.setattr(determinism, "WORKERS", (1, 3))
    found = prove(("determinism", 5, 0))
    assert found.figures == {"batch": 0.0, "service": 0.0, "service beside batch": 0.0}
    assert determinism._differing([b"1", b"2", b"3"], [b"1", b"3", b"2"]) == 2


def test_violations_by_hand():
    cylinder = {
        "axis": np.array([0.0, 0.6, 0.8]),
        "point": np.array([1.0, 0.0, 0.0]),
        "radius": np.array(2.0),
    }
    asked = {
        "radius": {"min": 2.5, "max": 3.0},
        "axis": {"direction": [0.0, 0.0, -3.0], "max_angle": 0.5},
        "point": [1.0, 6.0, 3.0],
    }
    found = violations(oracles.long(cylinder), asked)
    assert found["radius"] == pytest.approx(0.2) and found["axis"] == pytest.approx(np.arccos(0.8) - 0.5)
    # (6, 3) lies 3 off the line along (0.6, 0.8)
    assert found["point"] == pytest.approx(3.0 / np.sqrt(46.0))
    assert violations(oracles.long(cylinder), {"radius": {"max": 2.0}}) == {"radius": 0.0}


def test_the_optimum_under_a_bound_by_hand():
    """Planes with a normal within an angle of z: two rows of points at heights that ask for more."""
    points = np.array([[x, y, 0.1 * x] for x in (-1.0, 1.0) for y in (-1.0, 1.0)])
    truth = oracles.long(parameters(EXAMPLES["plane"])) | {"normal": np.array([0.0, 0.0, 1.0])}
    angle = 0.04
    asked = {"normal": {"direction": [0.0, 0.0, 1.0], "max_angle": angle}}
    least = 2.0 * (0.1 * np.cos(angle) - np.sin(angle)) ** 2
    assert optimum("plane", asked, truth, points) == pytest.approx(least, rel=1e-9)
    free = {"normal": {"direction": [0.0, 0.0, 1.0], "max_angle": 0.2}}
    assert optimum("plane", free, truth, points) == pytest.approx(0.0, abs=1e-20)


def test_every_kind_criterion_and_constraint_takes_its_turn():
    drawn = [zones.draw(5, index).groups for index in range(len(zones.PAIRS))]
    assert {(groups["kind"], groups["criterion"]) for groups in drawn} == set(zones.PAIRS)
    names = {(kind, name) for kind, hows in constraints.CONSTRAINED for name in hows}
    assert {kind for kind, _ in names} == set(EXAMPLES)
    for kind, primitive in EXAMPLES.items():
        asked = set(parameters(primitive)) - {"kind"}
        assert {name for each, name in names if each == kind} == asked
    for proof in (least_squares, zones, constraints):
        assert proof.draw(5, 0).drawn == proof.draw(5, 0).drawn != proof.draw(6, 0).drawn


def test_bars_look_at_their_figures_and_levels():
    shallow = {"kind": "cone", "points": "more", "noise": "exact", "arc": 360.0, "half_angle": 0.6}
    figures = {"angle": 2e-7, "length": 1e-5, "missed": 0.5}
    table = rows([made("least-squares", figures, **shallow), made("equivariance", {"turned": None}, 7)])
    exact = next(cells for (case, _), cells in table.items() if case == "the same, exact")
    assert exact[:3] == ["angle 2e-07 (2e-07); length 1e-05 (1e-05); **1 beyond**", "1", "**no**"]
    assert table["cones of 0.6, 2, 5 degrees", "the same bars"][2] == "**no**"
    assert table["cones of 75, 85 degrees", "the same bars"][0] == "not run"
    assert table["partial features (30 to 90 degrees)", "the same bars"][0] == "not run"
    (turned,) = [cells for (case, _), cells in table.items() if case == "cloud turned"]
    assert turned[:3] == ["**1 beyond**, 1 without an answer", "1", "**no**"]
    lines = list(proven([made("equivariance", {"turned": by}, case) for by, case in ((None, 7), (2.0, 8))]))
    assert "Cases of `equivariance` that miss: 7." in lines


@pytest.fixture
def records(tmp_path) -> RecordsFile:
    file = RecordsFile(tmp_path)
    groups = {"perturbation": "A0", "points": "up to 500"}
    errors = dict.fromkeys(("surface", "l2", "relative_l2"), 1e-3)
    file.rewrite([record("plane", "plane", errors=errors, seconds=0.01, groups=groups)])
    about = {"package": "numpy", "decides_kind": True, "kinds": ["plane"], "settings": ""}
    file.describe({"primfit": about | {"versions": {"numpy": "2"}, "machine": "a machine"}})
    return file


def test_the_report_shows_the_table_with_and_without_a_file(folder, records, tmp_path):
    pytest.importorskip("matplotlib")
    heading = "### From fresh seeds, beside independent optimizers"

    def section() -> str:
        text = write(records, tmp_path / "report").read_text()
        return text.partition(heading)[2].partition("\n## ")[0]

    assert section().count("| not run |  | – | – |") == len(PROOF_BARS)
    ProofsFile(tmp_path).path.write_text(ProofsFile(folder).path.read_text())
    shown = section()
    assert 0 < shown.count("| not run |") < len(PROOF_BARS) and "| yes | `primfit bench proofs" in shown


def test_lines_are_json(folder):
    fields = {"set", "seed", "case", "groups", "drawn", "figures", "note", "source"}
    for line in ProofsFile(folder).path.read_text(encoding="utf-8").splitlines():
        assert set(json.loads(line)) == fields


def test_bad_options_are_named(capsys):
    with pytest.raises(SystemExit):
        bench(["proofs", "--set", "everything"])
    assert "everything" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        bench(["proofs", "--seed", "2022"])
    assert "the seeds 2022, 2023, 2024" in capsys.readouterr().err
