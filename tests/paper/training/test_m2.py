"""The references of M2 are built, repeat, and answer."""

import numpy as np
import pytest

from primfit.models.rough import KINDS
from primfit.models.weights import load
from primfit.paper import m2
from primfit.paper.method import DIRECTORY
from primfit.paper.training.m2 import CLOUDS, SEED, build, references, row
from tests.fitting.clouds import EXAMPLES, sample

FEW = 60


def test_two_builds_agree_and_answer(tmp_path, monkeypatch):
    first, second = (build(SEED, FEW, tmp_path / name, processes) for name, processes in (("a", 1), ("b", 2)))
    assert first == second
    written = (tmp_path / "a" / "m2.npz").stat().st_mtime_ns
    assert build(SEED, FEW, tmp_path / "a") == first
    assert (tmp_path / "a" / "m2.npz").stat().st_mtime_ns == written
    assert build(SEED, FEW // 2, tmp_path / "b").sha256 != first.sha256
    monkeypatch.setattr(m2, "DIRECTORY", tmp_path / "a")
    assert m2.LocalHistograms().fit(sample(EXAMPLES["plane"], 500)).primitive.kind == "plane"


def test_what_is_stored():
    arrays = references([row(SEED, index) for index in range(10)])
    assert (
        arrays["labels"].tolist()
        == [KINDS.index(kind) for kind in ("plane", "sphere", "cylinder", "cone", "torus")] * 2
    )
    assert len(arrays["normals"]) == 10 and len(arrays["surflets"]) == 4
    assert {arrays[name].dtype for name in ("labels", "normals", "surflets")} == {np.dtype(np.uint8)}


def test_the_committed_weights_are_those_of_the_command_on_their_card():
    arrays, card = load("m2", DIRECTORY)
    assert card.recipe["command"] == f"python -m primfit.paper.training.m2 --seed {SEED} --clouds {CLOUDS}"
    assert len(arrays["labels"]) == CLOUDS
    assert (DIRECTORY / "m2.npz").stat().st_size <= 8e6
    made = [row(SEED, index) for index in range(3)]
    for index, (label, normals, _, _) in enumerate(made):
        assert arrays["labels"][index] == label
        np.testing.assert_array_equal(arrays["normals"][index], normals)


def test_flatness_is_a_share_of_planes():
    arrays, _ = load("m2", DIRECTORY)
    assert 0.1 < arrays["flatness"][0] < 0.6
    assert arrays["flatness"][0] == pytest.approx(m2.LocalHistograms().flattest)
