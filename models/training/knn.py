"""Build the k-NN weights from synthetic clouds:  python -m primfit.models.training.knn

The same seed and sizes give the same bytes. With --check a small build is made twice in a temporary folder,
compared, loaded and scored; the shipped weights stay as they are.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.cloud.cloud import NORMAL_POINTS

from ..features import BLOCKS
from ..knn import CLIP, NEIGHBOURS, SMOOTHING, KnnClassifier
from ..weights import DIRECTORY, Card, load, save
from .dataset import FAMILIES, HELD_BACK_CLOUDS, SEED, TRAINING_CLOUDS, Dataset, make_dataset, numbers, option
from .metrics import metrics

CHECK_CLOUDS = 250
LOWEST_CHECK = 0.8
"""Top-1 accuracy that even the small build of --check must reach."""


def build(data: Dataset) -> dict[str, NDArray[Any]]:
    """Standardization, the discriminant projection, and the clouds themselves as references."""
    from sklearn.discriminant_analysis import LinearDiscriminantAnalysis

    mean, scale = data.rows.mean(axis=0), data.rows.std(axis=0)
    scale = np.where(scale > 1e-9, scale, 1.0)
    standard = np.clip((data.rows - mean) / scale, -CLIP, CLIP)
    projection = LinearDiscriminantAnalysis().fit(standard, data.labels).scalings_
    return {
        "mean": mean.astype(np.float32),
        "scale": scale.astype(np.float32),
        "projection": projection.astype(np.float32),
        "references": (standard @ projection).astype(np.float16),
        "labels": data.labels.astype(np.uint8),
    }


def train(
    seed: int,
    clouds: Mapping[str, int],
    held_back: int,
    directory: Path,
    processes: int = 1,
    cache: Path | None = None,
) -> Card:
    """Build from clouds of `seed`, score on clouds of `seed + 1`, write the weights and their card."""
    arrays = build(make_dataset(seed, clouds, processes=processes, cache=cache))
    test = make_dataset(seed + 1, held_back, processes=processes, cache=cache)
    scores = metrics(KnnClassifier(arrays).probabilities(test.rows), test)
    recipe = {
        "command": f"python -m primfit.models.training.knn --seed {seed} --clouds {option(clouds)} "
        f"--held-back {held_back}",
        "clouds": dict(clouds),
        "held_back_seed": seed + 1,
        "seen_points": NORMAL_POINTS,
        "feature_blocks": BLOCKS,
        "projection": "linear discriminant analysis of the standardized features",
        "neighbours": NEIGHBOURS,
        "smoothing": SMOOTHING,
    }
    return save(arrays, "knn", recipe, seed, scores, directory)


def check(seed: int) -> None:
    """Raise unless two small builds agree to the byte, load, and are right often enough."""
    cards = []
    for _ in range(2):
        with tempfile.TemporaryDirectory() as folder:
            train(seed, dict.fromkeys(FAMILIES, CHECK_CLOUDS), CHECK_CLOUDS // 2, Path(folder))
            cards.append(load("knn", Path(folder))[1])
    if cards[0] != cards[1]:
        raise SystemExit("two builds from one seed differ")
    top1 = {family: scores["top1"] for family, scores in cards[0].metrics.items()}
    if top1["benchmark"] < LOWEST_CHECK:
        raise SystemExit(f"top-1 accuracy on benchmark clouds is {top1['benchmark']}, below {LOWEST_CHECK}")
    print(f"two builds of {CHECK_CLOUDS} clouds a family agree to the byte; top-1 {top1}")


def main(arguments: list[str] | None = None) -> None:
    parser = argparse.ArgumentParser(
        prog="python -m primfit.models.training.knn", description=__doc__.splitlines()[0]
    )
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--clouds", type=numbers, default=TRAINING_CLOUDS, help="of each family, or of all")
    parser.add_argument(
        "--held-back", type=int, default=HELD_BACK_CLOUDS, help="a family, scored, from seed + 1"
    )
    parser.add_argument("--processes", type=int, default=1, help="that draw clouds")
    parser.add_argument("--cache", type=Path, help="directory for datasets, to share them in one build")
    parser.add_argument("--out", type=Path, default=DIRECTORY)
    parser.add_argument("--check", action="store_true", help="two small builds, compared; writes nothing")
    options = parser.parse_args(arguments)
    if options.check:
        check(options.seed)
        return
    start = time.perf_counter()
    card = train(
        options.seed, options.clouds, options.held_back, options.out, options.processes, options.cache
    )
    print(f"{options.out / 'knn.npz'}: sha256 {card.sha256}")
    for family, scores in card.metrics.items():
        print(f"{family}: top-1 {scores['top1']}, top-2 {scores['top2']} on {scores['clouds']} clouds")
    print(f"{time.perf_counter() - start:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
