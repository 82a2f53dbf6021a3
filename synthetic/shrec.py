"""Labelled clouds like those of SHREC 2022: sample, cut, place, perturb."""

from collections.abc import Iterator

import numpy as np
from numpy.random import Generator

from .canonical import sample_segment
from .clouds import SyntheticCloud
from .perturb import perturb
from .poses import place
from .recipes import KINDS, PERTURBATIONS, TRAINING_COUNTS, BenchmarkRecipe

WHOLE_AND_TURNED = "A9"
"""In the training set clouds of this type are never cut, and their axes never stay z."""


def sample_cloud(rng: Generator, kind: str, perturbation: str) -> SyntheticCloud:
    """One cloud of the benchmark.

    Parameters
    ----------
    rng : the only source of randomness; the same state gives the same cloud
    kind : one of `fitting.names.KINDS`
    perturbation : "A0" to "A9"

    Returns
    -------
    SyntheticCloud with points (N, 3), 77 <= N <= 8100, in the benchmark's units (extents of 2 to 30)
    """
    whole = perturbation == WHOLE_AND_TURNED
    primitive, points = place(rng, *sample_segment(rng, kind, cuts=not whole), turn=whole)
    points, moved = perturb(rng, points, kind, perturbation)
    return SyntheticCloud(points, primitive, kind, perturbation, 1.0 - float(np.mean(moved)))


def benchmark_cloud(recipe: BenchmarkRecipe, index: int) -> SyntheticCloud:
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
    return (benchmark_cloud(recipe, index) for index in range(start, start + n))
