"""How long a ranking takes, on one thread:  OMP_NUM_THREADS=1 python -m primfit.models.training.timing

Processor time of features and network, without the normals, which the pipeline needs anyway.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from primfit.synthetic import cloud

from .. import CLASSIFIERS, load_classifier
from ..features import features
from .dataset import FAMILIES, TRAINING_RECIPES, seen

Array = NDArray[np.float64]
Ranker = Callable[[Array, Array], object]

ROUNDS = 5
"""Each cloud counts with the fastest of so many."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clouds", type=int, default=100, help="of each family")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    rankers: dict[str, Ranker] = {"features alone": features}
    for name in CLASSIFIERS:
        classifier = load_classifier(name)
        if classifier is not None:
            rankers[name] = classifier.rank
    for family in FAMILIES:
        recipe = replace(TRAINING_RECIPES[family], seed=given.seed)
        clouds = [seen(cloud(recipe, i), np.random.default_rng(i)) for i in range(given.clouds)]
        for name, rank in rankers.items():
            times = [min(_seconds(rank, *points) for _ in range(ROUNDS)) for points in clouds]
            middle, mean = 1e3 * np.median(times), 1e3 * np.mean(times)
            print(f"{family}, {name}: median {middle:.2f} ms, mean {mean:.2f} ms")


def _seconds(rank: Ranker, points: Array, normals: Array) -> float:
    start = time.thread_time()
    rank(points, normals)
    return time.thread_time() - start


if __name__ == "__main__":
    main()
