"""The shipped k-NN: probabilities, invariance, accuracy on fresh seeds, and what it costs to import."""

import subprocess
import sys

import numpy as np
import pytest
from sklearn.neighbors import KDTree

from primfit.fitting.names import KINDS
from primfit.models import CLASSIFIERS, load_classifier
from primfit.models.knn import SMOOTHING, KnnClassifier
from primfit.models.training.dataset import make_dataset, seen
from primfit.models.training.metrics import rank_of_truth
from primfit.models.weights import DIRECTORY, load
from primfit.synthetic import BenchmarkRecipe, cloud
from primfit.synthetic.poses import rotation_about_axes

FRESH_SEED = 900_001
"""Neither the training clouds nor those that the card's figures come from."""


@pytest.fixture(scope="module")
def knn():
    return load_classifier("knn")


@pytest.fixture(scope="module")
def fresh():
    return make_dataset(FRESH_SEED, 300, families=("benchmark",))


def test_names():
    assert CLASSIFIERS == ("network", "knn", "none")
    assert load_classifier("none") is None
    assert load_classifier("knn") is load_classifier("knn")
    with pytest.raises(ValueError, match="network, knn, none"):
        load_classifier("oracle")


def test_the_classifier_names_its_weights(knn):
    assert isinstance(knn, KnnClassifier)
    assert knn.sha256 == load("knn")[1].sha256


def test_probabilities_are_smooth_and_sum_to_one(knn):
    for index in range(10):
        ranking = knn.rank(*seen(cloud(BenchmarkRecipe(FRESH_SEED), index), np.random.default_rng(0)))
        assert tuple(ranking) == KINDS
        assert all(isinstance(value, float) and 0.0 < value < 1.0 for value in ranking.values())
        assert sum(ranking.values()) == pytest.approx(1.0, abs=1e-12)


def test_right_on_fresh_seeds(knn, fresh):
    """Held-back clouds reach 98.5%; the floors leave about three standard deviations to 300 draws."""
    rank = rank_of_truth(knn.probabilities(fresh.rows), fresh.labels)
    assert np.mean(rank == 0) >= 0.96
    assert np.mean(rank <= 1) >= 0.97
    for kind in range(len(KINDS)):
        assert np.mean(rank[fresh.labels == kind] == 0) >= 0.85


def test_the_card_agrees_with_fresh_seeds(knn, fresh):
    card = load("knn")[1]
    rank = rank_of_truth(knn.probabilities(fresh.rows), fresh.labels)
    assert card.metrics["benchmark"]["top1"] == pytest.approx(np.mean(rank == 0), abs=0.03)
    assert card.metrics["benchmark"]["top1"] >= 0.88
    assert card.metrics["scanner"]["top1"] >= 0.85


@pytest.mark.parametrize("index", range(10))
def test_pose_scale_and_order_leave_the_probabilities(knn, index):
    rng = np.random.default_rng(index)
    points, normals = seen(cloud(BenchmarkRecipe(FRESH_SEED), index), rng)
    before = knn.rank(points, normals)
    order = rng.permutation(len(points))
    assert knn.rank(points[order], normals[order]) == before
    rotation = rotation_about_axes(rng.uniform(0, 2 * np.pi, 3))
    after = knn.rank(20.0 * (points @ rotation.T + rng.normal(0, 3, 3)), normals @ rotation.T)
    # Grid clouds have ties that rounding breaks anew, so a few neighbors of 25 may change.
    assert max(abs(after[kind] - before[kind]) for kind in KINDS) <= 0.2
    assert max(after, key=after.get) == max(before, key=before.get)


def test_the_votes_are_those_of_the_nearest_references(knn, fresh):
    arrays = load("knn")[0]
    tree = KDTree(arrays["references"].astype(float))
    nearest = tree.query(knn.embedding(fresh.rows), k=knn.neighbors, return_distance=False)
    votes = np.array([np.bincount(knn.labels[each], minlength=len(KINDS)) for each in nearest]) + SMOOTHING
    assert knn.probabilities(fresh.rows) == pytest.approx(votes / votes.sum(axis=1, keepdims=True), abs=1e-15)


def test_poor_clouds_get_probabilities(knn):
    for n in (3, 5, 12):
        points = np.random.default_rng(n).normal(size=(n, 3))
        ranking = knn.rank(points, np.tile([0.0, 0.0, 1.0], (n, 1)))
        assert sum(ranking.values()) == pytest.approx(1.0)


def test_shipped_weights_are_small():
    assert (DIRECTORY / "knn.npz").stat().st_size < 3_000_000


def test_importing_models_imports_neither_scikit_learn_nor_training():
    code = (
        "import sys; from primfit import models;"
        "[models.load_classifier(name) for name in models.CLASSIFIERS];"
        "heavy = ('sklearn', 'primfit.synthetic', 'torch', 'primfit.models.training');"
        "sys.exit(', '.join(m for m in sys.modules if m.startswith(heavy)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_wrong_arrays_are_refused():
    arrays = dict(load("knn")[0])
    arrays["projection"] = arrays["projection"][:-1]
    with pytest.raises(ValueError, match="projection"):
        KnnClassifier(arrays)
