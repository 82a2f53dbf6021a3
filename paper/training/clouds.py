"""The clouds that networks learn from: the benchmark's recipe, normalized, kept under build/ meanwhile.

The paper's training set has 46,000 clouds of 77 to 8100 points. These have `POINTS` points each, and as many
clouds as `make weights-paper` asks for; no seed here is one that the benchmark measures on.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from primfit.models.rough import KINDS
from primfit.synthetic import BenchmarkRecipe, cloud

from ..parts.normalization import resampled, unit_sphere
from ..parts.numbers import to_numbers

POINTS = 2048
"""Kept of each cloud, drawn at random; of smaller clouds some are there several times."""
SHARD = 500
"""Clouds that a process draws, and a file holds, at a time."""


@dataclass(frozen=True, eq=False)
class Clouds:
    """M clouds in their unit spheres.

    Attributes
    ----------
    points : (M, POINTS, 3) float16
    labels : (M,) index of the kind in `KINDS`
    numbers : (M, 8) float32, the truth as in `parts.numbers`, in the normalized frame
    scales : (M,) the radius of the unit sphere in the unit of the cloud
    """

    points: NDArray[np.float16]
    labels: NDArray[np.int64]
    numbers: NDArray[np.float32]
    scales: NDArray[np.float64]

    def of(self, kind: str) -> "Clouds":
        """The clouds of one kind."""
        return self.where(np.flatnonzero(self.labels == KINDS.index(kind)))

    def where(self, chosen: NDArray[Any]) -> "Clouds":
        """The clouds of these indices."""
        return Clouds(*(getattr(self, field.name)[chosen] for field in fields(self)))


def drawn(seed: int, first: int, last: int) -> Clouds:
    """The clouds `first` to before `last` of a seed."""
    rows: list[tuple[Any, ...]] = [_row(seed, index) for index in range(first, last)]
    points, labels, numbers, scales = zip(*rows, strict=True)
    return Clouds(
        np.array(points, np.float16),
        np.array(labels, np.int64),
        np.array(numbers, np.float32),
        np.array(scales, np.float64),
    )


def _row(seed: int, index: int) -> tuple[Any, ...]:
    made = cloud(BenchmarkRecipe(seed), index)
    frame = unit_sphere(made.points)
    kept = resampled(frame.normalize(made.points), POINTS, np.random.default_rng([seed, index, 2]))
    assert made.primitive is not None  # the benchmark has no foreign shapes
    return kept, KINDS.index(made.kind), to_numbers(frame.bring(made.primitive)), frame.scale


def _kept(span: tuple[int, int], seed: int, cache: Path) -> Clouds:
    """Drawn, or read where they were kept before."""
    file = cache / f"clouds-{seed}-{span[0]}-{span[1]}-{POINTS}.npz"
    if not file.exists():
        made = drawn(seed, *span)
        part = file.with_suffix(f".{os.getpid()}.npz")
        np.savez(part, **{field.name: getattr(made, field.name) for field in fields(Clouds)})
        part.replace(file)
    with np.load(file, allow_pickle=False) as found:
        return Clouds(*(found[field.name] for field in fields(Clouds)))


def clouds(seed: int, count: int, cache: Path, processes: int = 1) -> Clouds:
    """The first `count` clouds of a seed, whatever was kept before and however many processes draw."""
    cache.mkdir(parents=True, exist_ok=True)
    spans = [(first, min(first + SHARD, count)) for first in range(0, count, SHARD)]
    make = partial(_kept, seed=seed, cache=cache)
    if processes > 1:
        with ProcessPoolExecutor(processes) as pool:
            return join(list(pool.map(make, spans)))
    return join([make(span) for span in spans])


def join(parts: Sequence[Clouds]) -> Clouds:
    """One after the other."""
    return Clouds(
        *(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(Clouds))
    )
