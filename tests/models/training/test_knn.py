"""Training: the same seed gives the same bytes, another seed others."""

from primfit.models.knn import KnnClassifier
from primfit.models.training.dataset import make_dataset, option
from primfit.models.training.knn import build, main, train
from primfit.models.training.metrics import metrics
from primfit.models.weights import load

FEW = {"benchmark": 12, "scanner": 6, "sensor": 4}


def test_one_seed_one_file(tmp_path):
    first = train(3, FEW, 5, tmp_path / "first")
    second = train(3, FEW, 5, tmp_path / "second")
    other = train(4, FEW, 5, tmp_path / "other")
    assert first == second
    for name in ("knn.npz", "knn.json"):
        assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes()
    assert other.sha256 != first.sha256
    assert load("knn", tmp_path / "first")[1] == first


def test_the_command_writes_weights_that_load(tmp_path, capsys):
    main(["--seed", "5", "--clouds", option(FEW), "--held-back", "5", "--out", str(tmp_path)])
    arrays, card = load("knn", tmp_path)
    assert card.recipe["clouds"] == FEW
    assert card.seed == 5 and card.recipe["held_back_seed"] == 6
    assert arrays["references"].shape[0] == sum(FEW.values())
    assert card.sha256 in capsys.readouterr().out


def test_a_classifier_knows_the_clouds_it_was_built_from():
    data = make_dataset(9, 150, families=("benchmark",))
    classifier = KnnClassifier(build(data))
    assert metrics(classifier.probabilities(data.rows), data)["benchmark"]["top1"] > 0.9
