"""The distributions that the benchmark's clouds are drawn from, and the recipe that draws a batch.

The numbers describe the training set of SHREC 2022 (Romanengo et al., Computers & Graphics 107, 2022,
section 2.1). What the paper does not say was read off the published truth of the 46,000 training clouds:
radii, angles, axes, positions and numbers of points, with the sizes of cylinders, cones and planes inferred
from how far they are moved (a translation is at most three times the half-extent). No cloud of the test set
was used.
"""

from dataclasses import dataclass

from fitting.primitives import KINDS


@dataclass(frozen=True)
class Range:
    """The uniform distribution on [low, high]; lengths carry the unit of the cloud, angles are radians."""

    low: float
    high: float

    def __post_init__(self) -> None:
        if not self.low <= self.high:
            raise ValueError(f"a range needs low <= high, not [{self.low}, {self.high}]")


@dataclass(frozen=True)
class NoiseLaw:
    """The values of n in U(-1/n, 1/n) and in N(-1/n, (2/n)^2); one is drawn a cloud."""

    uniform_n: tuple[int, ...] = (3, 5, 10, 15, 20)
    gaussian_n: tuple[int, ...] = (10, 15, 20, 25, 30)


PERTURBATIONS = ("A0", "A1", "A2", "A3", "A4", "A5", "A6", "A7", "A8", "A9")
TRAINING_COUNTS = (5000,) * 9 + (1000,)
"""Clouds of each perturbation type in the benchmark's training set: their shares in a batch."""


@dataclass(frozen=True)
class BenchmarkRecipe:
    """Benchmark-like clouds: cloud `i` depends on `seed` and `i` alone.

    Kinds take turns, so any run of len(kinds) clouds is balanced. The perturbation type is drawn with the
    frequencies of the benchmark's training set, restricted to `perturbations`.
    """

    seed: int
    kinds: tuple[str, ...] = KINDS
    perturbations: tuple[str, ...] = PERTURBATIONS

    def __post_init__(self) -> None:
        for name, given, known in (
            ("kinds", self.kinds, KINDS),
            ("perturbations", self.perturbations, PERTURBATIONS),
        ):
            if not given or not set(given) <= set(known):
                raise ValueError(f"{name} must be some of {known}, not {given}")
        if self.seed < 0:
            raise ValueError(f"seed must not be negative, not {self.seed}")
