"""Labelled clouds like those of SHREC 2022: sample, cut, place, perturb."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from fitting.primitives import KINDS, Primitive
from synthetic.canonical import sample_segment
from synthetic.perturb import perturb
from synthetic.poses import place
from synthetic.recipes import PERTURBATIONS, TRAINING_COUNTS, BenchmarkRecipe

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SyntheticCloud:
    """A labelled cloud; `exact_share` is the share of its points that no perturbation moved."""

    points: Array
    primitive: Primitive
    kind: str
    perturbation: str
    exact_share: float


def sample_cloud(rng: Generator, kind: str, perturbation: str) -> SyntheticCloud:
    """One cloud of the benchmark.

    Parameters
    ----------
    rng : the only source of randomness; the same state gives the same cloud
    kind : one of `fitting.primitives.KINDS`
    perturbation : "A0" to "A9"

    Returns
    -------
    SyntheticCloud with points (N, 3), 77 <= N <= 8100, in the benchmark's units (extents of 2 to 30)
    """
    primitive, points = place(rng, *sample_segment(rng, kind))
    points, moved = perturb(rng, points, kind, perturbation)
    return SyntheticCloud(points, primitive, kind, perturbation, 1.0 - float(np.mean(moved)))


def cloud(recipe: BenchmarkRecipe, index: int) -> SyntheticCloud:
    """Cloud `index` of a recipe, whatever was drawn before it."""
    rng = np.random.default_rng([recipe.seed, index])
    counts = np.array([TRAINING_COUNTS[PERTURBATIONS.index(name)] for name in recipe.perturbations])
    perturbation = recipe.perturbations[int(rng.choice(len(counts), p=counts / counts.sum()))]
    return sample_cloud(rng, recipe.kinds[index % len(recipe.kinds)], perturbation)


def batch(
    seed: int,
    n: int,
    kinds: tuple[str, ...] = KINDS,
    perturbations: tuple[str, ...] = PERTURBATIONS,
    start: int = 0,
) -> Iterator[SyntheticCloud]:
    """Clouds start .. start + n - 1 of the recipe with this seed; batches of one seed overlap exactly."""
    recipe = BenchmarkRecipe(seed, tuple(kinds), tuple(perturbations))
    return (cloud(recipe, index) for index in range(start, start + n))
