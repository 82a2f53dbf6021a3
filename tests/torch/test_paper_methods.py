"""M3 to M6 as they are committed: nothing makes them fail, and their receipts say what they are made of."""

import json
import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

torch = pytest.importorskip("torch", reason="needs torch: make test-torch")
pytestmark = pytest.mark.torch

from importlib.metadata import version

from primfit.app.cli.commands import app, parts
from primfit.fitting.primitives import values_of
from primfit.paper import command
from primfit.paper.answer import weights_of
from primfit.paper.m4 import first_near
from primfit.paper.method import Method, load
from primfit.paper.training import threshold, timing
from primfit.paper.training.clouds import drawn
from primfit.paper.training.learning import EPOCH
from primfit.paper.training.stages import Stage, stages
from tests.paper.degenerate import DEGENERATE
from tests.paths import ROOT

LEARNED = ("m3", "m4", "m5", "m6")


@pytest.fixture(scope="module", params=LEARNED)
def method(request: pytest.FixtureRequest) -> Method:
    torch.set_num_threads(1)
    return load(request.param)


def test_degenerate_clouds_are_answered_or_their_failure_named(method: Method) -> None:
    for name, points in DEGENERATE.items():
        given = points.copy()
        given.flags.writeable = False
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = method.fit(given)
        if found.primitive is None:
            assert found.note, name
        else:
            assert np.isfinite(values_of(found.primitive)).all(), name


def test_the_receipt_has_the_weights_and_the_version_of_torch(
    method: Method, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(parts, "_installed", lambda name: {"paper": command.paper}[name])
    done = CliRunner().invoke(app, ["paper", method.name, "--json", str(ROOT / "samples" / "pipe.ply")])
    used = json.loads(done.stdout)["receipt"]["versions"]
    assert used["torch"] == version("torch") and used["weights"] == weights_of(method.name)


def test_a_threshold_is_a_distance_or_a_multiple_of_the_nearest() -> None:
    distances = [0.06, 0.0205, 0.02, 0.04]
    assert threshold.below(distances, 0.05) == 1 and threshold.below(distances, 0.01) == 0
    assert first_near(distances, 1.03) == 1 and first_near(distances, 1.01) == 2


def test_thresholds_are_compared_on_the_same_clouds(capsys: pytest.CaptureFixture[str]) -> None:
    threshold.main(4)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(threshold.DISTANCES) + len(threshold.FACTORS)
    assert all(line.endswith("of 4 clouds right") for line in lines)


def test_the_time_of_all_steps_is_that_of_some(monkeypatch: pytest.MonkeyPatch) -> None:
    times = iter([10.0, 11.0, 13.0])
    monkeypatch.setattr(timing.time, "perf_counter", lambda: next(times))
    stage = Stage("m5-1", stages()[2].network, epochs=2)
    data = drawn(31, 0, 20)
    assert timing.all_steps(stage) == 2 * (EPOCH // 16)
    assert timing.minutes(stage, data, 3.0) == pytest.approx(3.0 / 2 * 2 * (EPOCH // 16) / 60.0)
