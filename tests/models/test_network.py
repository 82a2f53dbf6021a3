"""The shipped network: probabilities, invariance, calibration, accuracy on fresh seeds, and refusals."""

import numpy as np
import pytest

from primfit.fitting.names import KINDS
from primfit.models import load_classifier
from primfit.models.features import N_FEATURES
from primfit.models.network import NetworkClassifier, softmax
from primfit.models.training.dataset import FAMILIES, make_dataset, seen
from primfit.models.training.metrics import calibration_error, rank_of_truth
from primfit.models.weights import DIRECTORY, load
from primfit.synthetic import BenchmarkRecipe, cloud
from primfit.synthetic.poses import rotation_about_axes

FRESH_SEED = 900_002


@pytest.fixture(scope="module")
def network():
    return load_classifier("network")


def test_the_classifier_names_its_weights(network):
    assert isinstance(network, NetworkClassifier)
    assert network.sha256 == load("network")[1].sha256
    assert (DIRECTORY / "network.npz").stat().st_size < 1_000_000


def test_probabilities_sum_to_one_and_no_kind_is_impossible(network):
    for index in range(10):
        ranking = network.rank(*seen(cloud(BenchmarkRecipe(FRESH_SEED), index), np.random.default_rng(0)))
        assert tuple(ranking) == KINDS
        assert all(isinstance(value, float) and 0.0 < value < 1.0 for value in ranking.values())
        assert sum(ranking.values()) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    "family", [FAMILIES[0], *(pytest.param(family, marks=pytest.mark.slow) for family in FAMILIES[1:])]
)
def test_right_on_fresh_seeds_as_often_as_the_card_says(network, family):
    """200 draws, of sensors 100: the margin is about three standard deviations."""
    data = make_dataset(FRESH_SEED, 100 if family == "sensor" else 200, families=(family,))
    probabilities = network.probabilities(data.rows)
    rank = rank_of_truth(probabilities, data.labels)
    card = load("network")[1].metrics[family]
    assert card["top1"] >= 0.95 and card["top2"] >= 0.99 and card["calibration_error"] <= 0.03
    assert np.mean(rank == 0) >= card["top1"] - 0.06
    assert np.mean(rank <= 1) >= card["top2"] - 0.04
    assert calibration_error(probabilities, data.labels) <= 0.08


@pytest.mark.parametrize("index", range(10))
def test_pose_scale_and_order_leave_the_probabilities(network, index):
    rng = np.random.default_rng(index)
    points, normals = seen(cloud(BenchmarkRecipe(FRESH_SEED), index), rng)
    before = network.rank(points, normals)
    order = rng.permutation(len(points))
    assert network.rank(points[order], normals[order]) == before
    rotation = rotation_about_axes(rng.uniform(0, 2 * np.pi, 3))
    after = network.rank(20.0 * (points @ rotation.T + rng.normal(0, 3, 3)), normals @ rotation.T)
    # Grid clouds have ties that rounding breaks anew, so other points may represent them.
    assert max(abs(after[kind] - before[kind]) for kind in KINDS) <= 0.2
    assert max(after, key=after.get) == max(before, key=before.get)


def test_poor_clouds_get_probabilities(network):
    for n in (3, 5, 12):
        points = np.random.default_rng(n).normal(size=(n, 3))
        ranking = network.rank(points, np.tile([0.0, 0.0, 1.0], (n, 1)))
        assert sum(ranking.values()) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("weight0", lambda values: values[:, :-1]),
        ("weight1", lambda values: values[:-1]),
        ("mean", lambda values: values[:-1]),
        ("temperature", lambda values: -values),
    ],
)
def test_wrong_arrays_are_refused(name, wrong):
    arrays = dict(load("network")[0])
    arrays[name] = wrong(arrays[name])
    with pytest.raises(ValueError, match=r"needed|positive"):
        NetworkClassifier(arrays)


def test_a_higher_temperature_is_less_sure_and_ranks_alike():
    arrays = dict(load("network")[0])
    rows = make_dataset(FRESH_SEED, 20, families=("scanner",)).rows
    cool = NetworkClassifier(arrays).probabilities(rows)
    arrays["temperature"] = 2 * arrays["temperature"]
    warm = NetworkClassifier(arrays).probabilities(rows)
    assert np.all(warm.max(axis=1) <= cool.max(axis=1))
    assert np.array_equal(warm.argmax(axis=1), cool.argmax(axis=1))


def test_logits_of_any_size_make_probabilities():
    logits = np.array([[1e4, 0, 0, 0, -1e4], [0, 0, 0, 0, 0]])
    assert softmax(logits).sum(axis=1) == pytest.approx([1.0, 1.0])
    assert len(load("network")[0]["mean"]) == N_FEATURES


def test_calibration_error_of_honest_and_of_boastful_probabilities():
    labels = np.array([0] * 8 + [1] * 2)
    honest = np.tile([0.8, 0.2, 0.0, 0.0, 0.0], (10, 1))
    boastful = np.tile([1.0, 0.0, 0.0, 0.0, 0.0], (10, 1))
    assert calibration_error(honest, labels) == pytest.approx(0.0, abs=1e-12)
    assert calibration_error(boastful, labels) == pytest.approx(0.2)
