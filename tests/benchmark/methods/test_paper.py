"""The paper's methods as the benchmark asks them, in a child of their own interpreter."""

import sys
from pathlib import Path

import numpy as np
import pytest

from primfit.benchmark import runner
from primfit.benchmark.cases import Case
from primfit.benchmark.methods import METHODS, NETWORKS, PAPER, load
from primfit.benchmark.runner import Child, Children, interpreter
from primfit.fitting.names import KINDS
from primfit.paper.method import METHODS as MADE
from tests.fitting.clouds import EXAMPLES, sample

POINTS = sample(EXAMPLES["cylinder"], 600)


def test_each_is_there():
    assert tuple(MADE) == PAPER == tuple(name for name in METHODS if name in MADE)
    assert set(NETWORKS) == {"m3", "m4", "m5", "m6"}


@pytest.mark.parametrize("name", ["m1", "m2"])
def test_it_answers_as_the_method_does(name):
    method = load(name)
    assert (method.name, method.package, method.decides_kind, method.kinds) == (name, "primfit", True, KINDS)
    answer, found = method.fit(POINTS, None), method.method.fit(POINTS)
    assert answer.status == "fitted" and answer.primitive == found.primitive
    assert answer.attempts == found.attempts and method.settings == method.method.settings
    nothing = method.fit(np.ones((5, 3)), None)
    assert (nothing.status, nothing.primitive) == ("no_fit", None) and "same one" in nothing.note


def test_without_its_weights_it_is_not_installed(monkeypatch, tmp_path):
    monkeypatch.setattr("primfit.paper.m2.DIRECTORY", tmp_path)
    with pytest.raises(ImportError, match="the weights m2 cannot be read"):
        load("m2")


def test_networks_run_where_torch_is(monkeypatch, tmp_path):
    monkeypatch.setattr(runner, "ROOT", tmp_path)
    assert interpreter("m3") == interpreter("m1") == Path(sys.executable)
    python = tmp_path / ".venv-torch" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.touch()
    assert interpreter("m3") == python and interpreter("m1") == Path(sys.executable)


def test_each_interpreter_has_one_child(monkeypatch, tmp_path):
    monkeypatch.setattr(runner, "interpreter", lambda method: tmp_path / method[0])
    with Children(tmp_path / "log") as children:
        assert children.of("m1") is children.of("m2") is not children.of("primfit")
    with Children(tmp_path / "log", Path(sys.executable)) as children:
        assert children.of("m1") is children.of("primfit")


def test_a_child_answers_and_tells_versions(tmp_path):
    with Children(tmp_path / "log") as children:
        told = children.introduction("m1")
        outcome = children.fit("m1", Case("0", POINTS, None, {}), None, 60.0)
    assert told["decides_kind"] and "source" in told["versions"] and "torch" not in told["versions"]
    assert outcome.status == "fitted" and outcome.primitive["kind"] == "cylinder"
    assert isinstance(children.of("m1"), Child)
