"""Synthetic clouds as the recognise pipeline shows them to a classifier, turned into features."""

import hashlib
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fitting.cloud import NORMAL_POINTS
from fitting.normalize import Frame
from fitting.normals import estimate_normals
from fitting.primitives import KINDS
from models.features import FEATURE_VERSION, features, representatives
from synthetic import RECIPES, SyntheticCloud, cloud

Array = NDArray[np.float64]

SEED = 2022
TRAINING_CLOUDS = 16_000
HELD_BACK_CLOUDS = 2_000
"""Clouds a family that both classifiers learn from and are scored on."""
KEPT_POINTS = 256
"""Points of each cloud that a dataset keeps beside the features, for networks that look at points."""
FAMILIES = ("benchmark", "scanner")
"""The recipes that classifiers are trained on."""
SHARD = 250
"""Clouds that a process makes at a time."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """Of each of M clouds its features, the index of its kind, its perturbation, size and family, and points.

    `points` is (M, KEPT_POINTS, 6) float32: representatives with their normals, repeated where they are few.
    """

    rows: Array
    labels: NDArray[np.int64]
    perturbations: NDArray[np.str_]
    sizes: NDArray[np.int64]
    families: NDArray[np.str_]
    points: NDArray[np.float32]

    def where(self, chosen: NDArray[np.bool_]) -> "Dataset":
        """The clouds that a mask picks."""
        return Dataset(*(getattr(self, field.name)[chosen] for field in fields(self)))


def seen(cloud: SyntheticCloud, rng: np.random.Generator) -> tuple[Array, Array]:
    """Points and normals that a classifier gets of this cloud: a random sample, as the pipeline takes it."""
    points = Frame.of(cloud.points).normalize(cloud.points)
    sample = points[rng.permutation(len(points))[:NORMAL_POINTS]]
    return sample, estimate_normals(points, at=sample)


def _shard(family: str, seed: int, bounds: tuple[int, int]) -> Dataset:
    recipe = replace(RECIPES[family], seed=seed)
    rows, labels, perturbations, sizes, kept = [], [], [], [], []
    for index in range(*bounds):
        drawn = cloud(recipe, index)
        points, normals = seen(drawn, np.random.default_rng([seed, index, 1]))
        rows.append(features(points, normals))
        labels.append(KINDS.index(drawn.kind))
        perturbations.append(drawn.perturbation)
        sizes.append(len(drawn.points))
        few = np.hstack(representatives(points, normals))
        kept.append(few[np.linspace(0, len(few) - 1, KEPT_POINTS).astype(int)].astype(np.float32))
    return Dataset(
        np.array(rows),
        np.array(labels, np.int64),
        np.array(perturbations, np.str_),
        np.array(sizes, np.int64),
        np.full(len(rows), family),
        np.array(kept),
    )


def join(parts: Sequence[Dataset]) -> Dataset:
    """One dataset after the other."""
    return Dataset(
        *(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Dataset))
    )


def make_dataset(
    seed: int, n: int, families: Sequence[str] = FAMILIES, processes: int = 1, cache: Path | None = None
) -> Dataset:
    """The first n clouds of a seed of each family; the same whatever the number of processes.

    With a cache, a directory, a dataset made before with the same arguments and `FEATURE_VERSION` is read
    from there; nobody notices changes of the generator, so the cache is for one build.
    """
    parts = []
    for family in families:
        key = f"{family} {seed} {n} {FEATURE_VERSION} {RECIPES[family]}"
        file = cache / f"{family}-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npz" if cache else None
        if file and file.exists():
            with np.load(file, allow_pickle=False) as found:
                parts.append(Dataset(*(found[field.name] for field in fields(Dataset))))
            continue
        bounds = [(first, min(first + SHARD, n)) for first in range(0, n, SHARD)]
        make = partial(_shard, family, seed)
        if processes > 1:
            with ProcessPoolExecutor(processes) as pool:
                made = join(list(pool.map(make, bounds)))
        else:
            made = join([make(bound) for bound in bounds])
        if file:
            file.parent.mkdir(parents=True, exist_ok=True)
            np.savez(file, **{field.name: getattr(made, field.name) for field in fields(Dataset)})
        parts.append(made)
    return join(parts)
