"""A few steps of training: the same bytes twice, and after a cut; cards that say what they stand beside."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch: make test-torch")
pytestmark = pytest.mark.torch

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.names import KINDS
from primfit.fitting.primitives.cone import Cone
from primfit.models.weights import load, save
from primfit.paper import m4, m5, method
from primfit.paper.m3 import RegressedByPointNet
from primfit.paper.m4 import ShapeNets
from primfit.paper.m5 import PointNetBundle, cone_by_tangents
from primfit.paper.m6 import AlexNetIso
from primfit.paper.method import DIRECTORY
from primfit.paper.parts.asking import numbers, ranked
from primfit.paper.parts.frames import answered
from primfit.paper.parts.normalization import unit_sphere
from primfit.paper.parts.stored import arrays_of, built, restored
from primfit.paper.training import running
from primfit.paper.training.clouds import Clouds, clouds
from primfit.paper.training.learning import EPOCH, learned
from primfit.paper.training.measuring import l2, measured
from primfit.paper.training.running import Run, finished, trained
from primfit.paper.training.stages import Stage, stages
from tests.paths import ROOT

STAGES = {stage.name: stage for stage in stages()}
MOST_BYTES = 8 * 2**20
"""Of the weights of a method."""
QUIET = [lambda text: None]


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Clouds:
    return clouds(31, 40, tmp_path_factory.mktemp("clouds"))


@pytest.fixture(scope="module")
def untrained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with weights of all networks as they are before training."""
    folder = tmp_path_factory.mktemp("weights")
    for name, stage in STAGES.items():
        torch.manual_seed(1)
        save(arrays_of(built(stage.network)), name, {"network": stage.network}, 1, {}, folder)
    return folder


def bytes_of(network: torch.nn.Module) -> dict[str, bytes]:
    return {name: values.tobytes() for name, values in arrays_of(network).items()}


@pytest.mark.parametrize("name", ["m3-kind", "m4-cone", "m5-1", "m6-kind"])
def test_one_seed_one_network_wherever_training_is_cut(name: str, few: Clouds, tmp_path: Path) -> None:
    stage = replace(STAGES[name], epochs=2, batch=8)
    data = few if stage.kind is None else few.of(stage.kind)

    def run(seed: int, file: str, most: int | None = None) -> dict[str, bytes]:
        return bytes_of(learned(stage, data, seed, tmp_path / file, *QUIET, most=most))

    through = run(3, "a.pt")
    assert run(3, "b.pt") == through
    assert run(3, "c.pt", most=1) != through
    assert run(3, "c.pt") == through
    assert run(4, "d.pt") != through


def test_a_finished_network_is_written_with_its_card_and_not_trained_again(tmp_path: Path) -> None:
    stage = replace(STAGES["m6-kind"], epochs=1, batch=8)
    runs = [Run(7, 20, 10, tmp_path / name, tmp_path / "cache") for name in ("one", "two")]
    assert not finished(stage, runs[0])
    metrics = trained(stage, runs[0])
    assert finished(stage, runs[0]) and not finished(replace(stage, rate=1.0), runs[0])
    assert not finished(stage, replace(runs[0], clouds=25))
    _, card = load(stage.name, runs[0].out)
    assert card.metrics == metrics and card.metrics["benchmark"]["clouds"] == 10
    for checkpoint in (tmp_path / "cache").glob("*.pt"):
        checkpoint.unlink()
    trained(stage, runs[1])
    for suffix in ("npz", "json"):
        assert len({(run.out / f"{stage.name}.{suffix}").read_bytes() for run in runs}) == 1


def test_a_quick_run_trains_what_is_not_finished(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    given = ["--quick", "--only", "m6-kind", "m4-sphere", "--out", str(tmp_path / "out")]
    given += ["--cache", str(tmp_path / "cache")]
    running.main(given)
    cards = {file.name: file.read_bytes() for file in (tmp_path / "out").glob("*.json")}
    assert set(cards) == {"m6-kind.json", "m4-sphere.json"}
    assert "m4-sphere: {'clouds': 10, 'l2_quartiles':" in capfd.readouterr().out
    (tmp_path / "out" / "m6-kind.json").unlink()
    running.main(given)
    told = capfd.readouterr().out
    assert "m6-kind: " in told and "m4-sphere: " not in told
    assert {file.name: file.read_bytes() for file in (tmp_path / "out").glob("*.json")} == cards


def test_a_run_that_is_told_to_end_begins_nothing_more(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "primfit.paper.training", "--quick", "--processes", "1"]
    places = ["--out", tmp_path / "out", "--cache", tmp_path / "cache"]
    names = [f"m4-{kind}" for kind in KINDS]
    with subprocess.Popen([*command, *places, "--only", *names], stdout=subprocess.PIPE, text=True) as run:
        assert run.stdout is not None and run.stdout.readline().startswith("m4-plane: ")
        run.terminate()
        assert run.wait(60) == 1
        assert "m4-torus" not in run.stdout.read()


@pytest.mark.parametrize(
    "given, said", [(["--quick"], "an --out of its own"), (["--only", "m9"], "--only: m9; there are m4-kind")]
)
def test_a_mistaken_command_is_told(given: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        running.main(given)
    assert said in capsys.readouterr().err


def test_clouds_are_the_same_however_many_processes_draw_and_what_was_kept(
    few: Clouds, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("primfit.paper.training.clouds.SHARD", 15)
    for processes in (2, 1):
        again = clouds(31, 40, tmp_path, processes)
        np.testing.assert_array_equal(again.points, few.points)
        np.testing.assert_array_equal(again.numbers, few.numbers)


@pytest.mark.parametrize("kind", KINDS)
def test_the_truth_is_no_distance_from_itself(kind: str, few: Clouds) -> None:
    mine = few.of(kind)
    assert len(mine.labels) == 8
    truth = mine.numbers.astype(float)
    assert l2(kind, truth, truth, mine.scales).max() < 1e-5
    assert l2(kind, truth + 0.01, truth, mine.scales).min() > 1e-3


def test_what_is_stored_says_what_was_measured(few: Clouds, tmp_path: Path) -> None:
    stage = STAGES["m3-kind"]
    torch.manual_seed(5)
    network = built(stage.network)
    save(arrays_of(network), stage.name, {"network": stage.network}, 1, {}, tmp_path)
    stored = restored(stage.name, tmp_path)
    shown = torch.from_numpy(few.points[:1, :512].astype(np.float32))
    np.testing.assert_allclose(numbers(stored, shown), numbers(network.eval(), shown), atol=0.01)
    assert measured(stage, stored, few)["clouds"] == 40


@pytest.mark.parametrize("name", STAGES)
def test_shipped_weights_are_those_of_their_stage(name: str) -> None:
    said = json.loads((DIRECTORY / f"{name}.json").read_text(encoding="utf-8"))
    stage: Stage = STAGES[name]
    run = Run(running.SEED, running.CLOUDS, running.VALIDATION, DIRECTORY, running.CACHE)
    assert said["seed"] == running.SEED and said["recipe"] == run.recipe(stage)
    restored(name)


@pytest.mark.parametrize("name", ["m3", "m4", "m5", "m6"])
def test_weights_of_a_method_are_small(name: str, untrained: Path) -> None:
    assert sum(file.stat().st_size for file in untrained.glob(f"{name}-*.npz")) < MOST_BYTES


def degenerate() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(8)
    line = np.outer(np.linspace(0.0, 1.0, 30), [1.0, 2.0, 3.0])
    ball = rng.normal(size=(60, 3))
    return {
        "nothing": np.empty((0, 3)),
        **{f"{count} points": ball[:count] for count in (1, 2, 3, 4, 5, 7)},
        "one point often": np.tile([[3.0, -1.0, 2.0]], (50, 1)),
        "two points often": np.repeat(ball[:2], 20, axis=0),
        "a line": line,
        "a line and a point": np.vstack([line, ball[:1]]),
        "a grid": np.stack(np.meshgrid(*[np.arange(4.0)] * 3), axis=-1).reshape(-1, 3),
        "a square": np.stack([*np.meshgrid(*[np.arange(6.0)] * 2), np.zeros((6, 6))], -1).reshape(-1, 3),
        "huge": 1e300 * ball,
        "larger than that": 1.7e308 * np.sign(ball),
        "tiny": 1e-300 * ball,
        "far": 1e12 + 1e-3 * ball,
        "one far away": np.vstack([ball, [[1e200, 0.0, 0.0]]]),
    }


METHODS = {"m3": RegressedByPointNet, "m4": ShapeNets, "m5": PointNetBundle, "m6": AlexNetIso}


@pytest.mark.parametrize("name", METHODS)
def test_degenerate_clouds_are_answered_or_told_why_not(name: str, untrained: Path) -> None:
    asked = METHODS[name](untrained)
    for points in degenerate().values():
        points.flags.writeable = False
        found = asked.fit(points)
        assert isinstance(found, method.Found)
        assert found.primitive is not None or found.note
        assert found == asked.fit(points)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_fitted_to_degenerate_clouds_without_an_error(kind: str, untrained: Path) -> None:
    asked = ShapeNets(untrained)

    def fit(points: Array) -> method.Found:
        m5.fitted(kind, points)
        primitive, _ = asked.fitted(kind, points)
        assert primitive.kind == kind
        return method.Found(primitive)

    for points in degenerate().values():
        answered(unit_sphere, fit, points)


def test_m4_takes_the_next_kind_where_another_is_nearer(untrained: Path) -> None:
    asked = ShapeNets(untrained)
    points = np.random.default_rng(2).normal(size=(300, 3))
    found = asked.fit(points)
    inside = unit_sphere(points).normalize(points)
    order = ranked(found.probabilities)
    fitted = [asked.fitted(kind, inside)[0] for kind in order]
    distances = [m4.mean_distance(primitive, inside) for primitive in fitted]
    accepted = len(found.attempts) - 1
    assert list(found.attempts) == order[: accepted + 1]
    assert distances[accepted] <= m4.NEARER * min(distances) < min([*distances[:accepted], np.inf])


@pytest.mark.parametrize(
    ("distances", "accepted"),
    [
        ([0.2, 0.1, 0.3], 1),
        ([0.102, 0.1, 0.3], 0),
        ([0.2, 0.104, 0.1], 2),
        ([3e-16, 1e-16, 0.2], 0),
        ([np.inf, 0.1, np.inf], 1),
        ([np.inf, np.inf], 0),
    ],
)
def test_the_first_surface_about_as_near_as_the_nearest(distances: list[float], accepted: int) -> None:
    assert m4.first_near(distances) == accepted


def test_the_majority_decides_and_the_mean_where_there_is_none() -> None:
    chances = tuple(zip(KINDS, (0.1, 0.2, 0.3, 0.15, 0.25), strict=True))
    assert m5.elected(["cone", "torus", "cone"], chances) == "cone"
    assert m5.elected(["cone", "torus", "plane"], chances) == "torus"


def test_tangent_planes_of_a_cone_meet_in_its_vertex() -> None:
    cone = Cone([0.3, -0.2, -0.8], [0.1, 0.2, 1.0], 0.6)
    rng = np.random.default_rng(4)
    points = cone.surface(rng.uniform(0.0, 4.0, 3000), rng.uniform(0.3, 1.2, 3000))
    found = cone_by_tangents(points)
    assert found is not None
    np.testing.assert_allclose(found.apex, cone.apex, atol=0.03)
    assert found.axis @ cone.axis > 0.999 and abs(found.half_angle - 0.6) < 0.02


def test_the_page_says_how_many_clouds_each_network_is_shown() -> None:
    lines = (ROOT / "docs" / "paper.md").read_text().splitlines()
    for stage in stages():
        row = next(line for line in lines if named_in(line, stage.name))
        assert f"| {stage.epochs} x {EPOCH:,}" in row and f"| {stage.points:,} |" in row, stage.name


def named_in(line: str, name: str) -> bool:
    """Whether a row of the table is that of a network; KIND stands for every kind."""
    kind = name.partition("-")[2]
    if kind.isdigit():
        return line.startswith("| `m5-1` to `m5-3` |")
    names = {name} if kind == "kind" else {name, name.replace(kind, "KIND")}
    return any(f"`{each}`" in line for each in names) and line.startswith("| ") and " x " in line
