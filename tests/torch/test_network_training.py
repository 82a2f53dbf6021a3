"""A tiny network is trained in seconds, is served to the same logits, and comes out the same twice."""

import numpy as np
import pytest

pytestmark = pytest.mark.torch
torch = pytest.importorskip("torch")

from primfit.models.network import NetworkClassifier
from primfit.models.training import network as training
from primfit.models.training import pointnet
from primfit.models.training.dataset import make_dataset
from primfit.models.weights import load

FEW = {"benchmark": 15, "scanner": 10, "sensor": 5}


@pytest.fixture(scope="module")
def data():
    return make_dataset(41, 40)


def test_torch_and_served_logits_agree(data):
    arrays, curves, model = training.build(data, data, seed=1, epochs=8)
    served = NetworkClassifier(arrays).logits(data.rows)
    trained = training.predict(model, training.standardized(data.rows, arrays))
    np.testing.assert_allclose(served, trained, atol=1e-5)
    assert curves[-1]["loss"] < curves[0]["loss"]
    assert curves[-1]["validation_top1"] > 0.6


def test_one_seed_one_file(tmp_path):
    first, _ = training.train(3, FEW, 5, 5, tmp_path / "first", epochs=2)
    second, _ = training.train(3, FEW, 5, 5, tmp_path / "second", epochs=2, cache=tmp_path / "cache")
    third, _ = training.train(3, FEW, 5, 5, tmp_path / "third", epochs=2, cache=tmp_path / "cache")
    assert first == second == third
    for name in ("network.npz", "network.json"):
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes()
    arrays, card = load("network", tmp_path / "first")
    assert card.sha256 == NetworkClassifier(arrays, card.sha256).sha256
    assert set(card.metrics) == {"benchmark", "scanner", "sensor"}


def test_the_temperature_undoes_a_scale_of_the_logits():
    rng = np.random.default_rng(0)
    logits = rng.normal(0, 2, (20_000, 5))
    labels = np.array([rng.choice(5, p=p) for p in training.softmax(logits)])
    assert training.temperature(3.0 * logits, labels) == pytest.approx(3.0, rel=0.05)


def test_the_point_network_sees_what_no_motion_changes(data):
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0].astype(np.float32)
    turned = np.concatenate([data.points[..., :3] @ turn.T, data.points[..., 3:] @ turn.T], axis=2)
    keep = np.array([label in (2, 3, 4) for label in data.labels])
    before, after = pointnet.invariant(data.points[keep]), pointnet.invariant(turned[keep])
    assert float((after - before).abs().median()) < 1e-4
    logits = training.predict(pointnet.PointNet(before.shape[-1]), before)
    assert logits.shape == (keep.sum(), 5)
