"""Synthetic clouds as the recognise pipeline shows them to a classifier, turned into features."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fitting.normalize import Frame
from fitting.normals import estimate_normals
from fitting.primitives import KINDS
from models.features import N_FEATURES, features
from synthetic import SyntheticCloud, batch

Array = NDArray[np.float64]

SEEN_POINTS = 1024
"""The pipeline shows a random sample of this size, with normals from the whole cloud."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """Features (M, N_FEATURES) and, of each cloud, the index of its kind, its perturbation and its size."""

    rows: Array
    labels: NDArray[np.int64]
    perturbations: tuple[str, ...]
    sizes: NDArray[np.int64]


def seen(cloud: SyntheticCloud, rng: np.random.Generator) -> tuple[Array, Array]:
    """Points and normals that a classifier gets of this cloud."""
    points = Frame.of(cloud.points).normalize(cloud.points)
    sample = points[rng.permutation(len(points))[:SEEN_POINTS]]
    return sample, estimate_normals(points, at=sample)


def make_dataset(seed: int, n: int) -> Dataset:
    """The first n benchmark clouds of a seed."""
    rows = np.empty((n, N_FEATURES))
    labels, sizes = np.empty(n, np.int64), np.empty(n, np.int64)
    perturbations = []
    for index, cloud in enumerate(batch(seed, n)):
        rows[index] = features(*seen(cloud, np.random.default_rng([seed, index, 1])))
        labels[index] = KINDS.index(cloud.kind)
        sizes[index] = len(cloud.points)
        perturbations.append(cloud.perturbation)
    return Dataset(rows, labels, tuple(perturbations), sizes)
