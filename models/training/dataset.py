"""Synthetic clouds as the recognize pipeline shows them to a classifier, turned into features."""

import hashlib
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.cloud.cloud import NORMAL_POINTS
from primfit.fitting.cloud.frame import Frame
from primfit.fitting.cloud.normals import estimate_normals
from primfit.synthetic import RECIPES, SensorRecipe, SyntheticCloud, cloud

from ..features import FEATURE_VERSION, features, representatives
from ..rough import KINDS

Array = NDArray[np.float64]

SEED = 2022
HELD_BACK_CLOUDS = 2_000
"""Clouds a family that both classifiers are scored on."""
KEPT_POINTS = 256
"""Points of each cloud that a dataset keeps beside the features, for networks that look at points."""
TRAINING_CLOUDS = {"benchmark": 10_000, "scanner": 10_000, "sensor": 2_500}
"""Clouds that both classifiers learn from; of sensors, which take longest to draw, fewer do."""
FAMILIES = tuple(TRAINING_CLOUDS)
"""The recipes that classifiers are trained on."""
TRAINING_RECIPES = {**RECIPES, "sensor": replace(SensorRecipe(), share_of_many=0.0)}
"""Without sensor clouds of over 20,000 points, which take six times as long as others to draw; the pipeline
thins larger clouds to so many before a classifier sees any of them."""
SHARD = 250
"""Clouds that a process makes, and a cache keeps, at a time."""


@dataclass(frozen=True, eq=False)
class Dataset:
    """Of each of M clouds features, the index of its kind, perturbation, sensor, size, family and points.

    Perturbations are those of benchmark clouds, sensors those of sensor clouds; elsewhere they are empty.
    `points` is (M, KEPT_POINTS, 6) float32: representatives with their normals, repeated where they are few.
    """

    rows: Array
    labels: NDArray[np.int64]
    perturbations: NDArray[np.str_]
    sensors: NDArray[np.str_]
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


@dataclass(frozen=True)
class Shard:
    """The clouds `first` to before `last` of one seed of a family."""

    family: str
    seed: int
    first: int
    last: int

    def made(self, cache: Path | None = None) -> Dataset:
        """Drawn, or read from the cache, a directory, if they were kept there before."""
        if cache is None:
            return self.drawn()
        file = self._file(cache)
        if not file.exists():
            data = self.drawn()
            part = file.with_suffix(f".{os.getpid()}.part.npz")
            np.savez(part, **{field.name: getattr(data, field.name) for field in fields(Dataset)})
            part.replace(file)
        with np.load(file, allow_pickle=False) as found:
            return Dataset(*(found[field.name] for field in fields(Dataset)))

    def _file(self, cache: Path) -> Path:
        key = f"{self} {FEATURE_VERSION} {TRAINING_RECIPES[self.family]}"
        return cache / f"{self.family}-{hashlib.sha256(key.encode()).hexdigest()[:16]}.npz"

    def drawn(self) -> Dataset:
        recipe = replace(TRAINING_RECIPES[self.family], seed=self.seed)
        rows, labels, perturbations, sensors, sizes, kept = [], [], [], [], [], []
        for index in range(self.first, self.last):
            drawn = cloud(recipe, index)
            points, normals = seen(drawn, np.random.default_rng([self.seed, index, 1]))
            rows.append(features(points, normals))
            labels.append(KINDS.index(drawn.kind))
            perturbations.append(drawn.perturbation)
            sensors.append(drawn.sensor)
            sizes.append(len(drawn.points))
            few = np.hstack(representatives(points, normals))
            kept.append(few[np.linspace(0, len(few) - 1, KEPT_POINTS).astype(int)].astype(np.float32))
        return Dataset(
            np.array(rows),
            np.array(labels, np.int64),
            np.array(perturbations, np.str_),
            np.array(sensors, np.str_),
            np.array(sizes, np.int64),
            np.full(len(rows), self.family),
            np.array(kept),
        )


def join(parts: Sequence[Dataset]) -> Dataset:
    """One dataset after the other."""
    return Dataset(
        *(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Dataset))
    )


def numbers(text: str) -> dict[str, int]:
    """Of clouds by family, from an option: `benchmark=60,scanner=60,sensor=20`, or one number for all."""
    if text.isdecimal():
        return dict.fromkeys(FAMILIES, int(text))
    found = {family: int(n) for family, _, n in (part.partition("=") for part in text.split(","))}
    if set(found) != set(FAMILIES):
        raise ValueError(f"needs a number for each of {', '.join(FAMILIES)}")
    return found


def option(clouds: Mapping[str, int]) -> str:
    """What `numbers` reads."""
    return ",".join(f"{family}={n}" for family, n in clouds.items())


def make_dataset(
    seed: int,
    n: int | Mapping[str, int],
    families: Sequence[str] = FAMILIES,
    processes: int = 1,
    cache: Path | None = None,
) -> Dataset:
    """The first n clouds of a seed of each family, or n by family; whatever the number of processes.

    With a cache, a directory, what was made before with the same recipe and `FEATURE_VERSION` is read from
    there, so that a run goes on where it was cut off; nobody notices changes of the generator, so the cache
    is for one build.
    """
    clouds = dict.fromkeys(families, n) if isinstance(n, int) else n
    shards = [
        Shard(family, seed, first, min(first + SHARD, clouds[family]))
        for family in families
        for first in range(0, clouds[family], SHARD)
    ]
    if cache:
        cache.mkdir(parents=True, exist_ok=True)
    make = partial(Shard.made, cache=cache)
    if processes > 1:
        with ProcessPoolExecutor(processes) as pool:
            return join(list(pool.map(make, shards)))
    return join([make(shard) for shard in shards])
