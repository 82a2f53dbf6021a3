"""The benchmark's perturbation types A0 to A9 (section 2.1 of the paper), from four parts.

Noise is added to a random share of the points, independently on each world coordinate, and leaves the
others exact; parts are removed afterwards. Every function takes points (N, 3) and returns new arrays.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from .recipes import NoiseLaw, Range

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NOISY_SHARE = Range(0.3, 0.8)
"""Share of the points that noise is added to; the others stay exact."""
REMOVED_SHARE = Range(0.5, 0.8)
MISSING_RADIUS = Range(0.01, 0.08)
BUMP_WIDTH = Range(0.02, 0.05)
BUMP_HEIGHT = Range(0.02, 0.08)
"""A missing part's radius, a bump's standard deviations and amplitude, as shares of the diagonal."""
BUMP_REACH = 8.0
"""Standard deviations beyond which a bump is below rounding and is not added."""
FEWEST_POINTS = 77
"""The smallest cloud of the training set; removals stop there."""

NOISE: dict[str, NoiseLaw] = {"plane": NoiseLaw((1, 3, 5, 10, 15, 20), (3, 5, 10, 15, 20, 25, 30))}
"""Planes get larger amplitudes than the paper says; all other kinds the `NoiseLaw` of the paper."""


@dataclass(frozen=True)
class Perturbation:
    """What is done to a cloud, in this order."""

    noise: Literal["uniform", "gaussian"] | None = None
    bump: bool = False
    removal: Literal["undersampling", "missing_part"] | None = None


TYPES: dict[str, Perturbation] = {
    "A0": Perturbation(),
    "A1": Perturbation(noise="uniform"),
    "A2": Perturbation(noise="gaussian"),
    "A3": Perturbation(removal="undersampling"),
    "A4": Perturbation(removal="missing_part"),
    "A5": Perturbation(noise="uniform", removal="undersampling"),
    "A6": Perturbation(noise="gaussian", removal="undersampling"),
    "A7": Perturbation(noise="uniform", removal="missing_part"),
    "A8": Perturbation(noise="gaussian", removal="missing_part"),
    "A9": Perturbation(bump=True),
}


def diagonal(points: Array) -> float:
    """Length of the bounding box's diagonal."""
    extent = points.max(axis=0) - points.min(axis=0)
    return float(np.sqrt(extent @ extent))


def random_subset(rng: Generator, size: int, count: int) -> Mask:
    """A mask with exactly `count` of `size` places set."""
    mask = np.zeros(size, dtype=bool)
    mask[rng.permutation(size)[:count]] = True
    return mask


def uniform_noise(rng: Generator, count: int, n: int) -> Array:
    """U(-1/n, 1/n) on each coordinate, shape (count, 3)."""
    return rng.uniform(-1.0 / n, 1.0 / n, (count, 3))


def gaussian_noise(rng: Generator, count: int, n: int) -> Array:
    """N(-1/n, (2/n)^2) on each coordinate, shape (count, 3): biased, as in the benchmark."""
    return rng.normal(-1.0 / n, 2.0 / n, (count, 3))


def add_noise(
    rng: Generator, points: Array, law: NoiseLaw, noise: Literal["uniform", "gaussian"]
) -> tuple[Array, Mask]:
    """Noise on a random share of the points; returns the points and the mask of those moved."""
    n = int(rng.choice(law.uniform_n if noise == "uniform" else law.gaussian_n))
    share = rng.uniform(NOISY_SHARE.low, NOISY_SHARE.high)
    moved = random_subset(rng, len(points), int(share * len(points)))
    draw = uniform_noise if noise == "uniform" else gaussian_noise
    noisy = points.copy()
    noisy[moved] += draw(rng, int(np.count_nonzero(moved)), n)
    return noisy, moved


def add_bump(rng: Generator, points: Array) -> tuple[Array, Mask]:
    """A bivariate Gaussian over the tangent plane at a random point, added along the normal there.

    It also decays along the normal, so that the far side of a closed surface stays where it is.
    """
    size = diagonal(points)
    center = points[rng.integers(len(points))]
    offsets = points - center
    squared = np.einsum("ij,ij->i", offsets, offsets)
    nearest = offsets[np.argsort(squared, kind="stable")[:24]]
    normal, *tangents = np.linalg.eigh(nearest.T @ nearest)[1].T
    turn = rng.uniform(0.0, np.pi)
    along = np.cos(turn) * tangents[0] + np.sin(turn) * tangents[1]
    across = np.cos(turn) * tangents[1] - np.sin(turn) * tangents[0]
    width, breadth = size * rng.uniform(BUMP_WIDTH.low, BUMP_WIDTH.high, 2)
    scaled = offsets @ np.stack([along / width, across / breadth, normal / np.sqrt(width * breadth)], axis=1)
    exponent = np.einsum("ij,ij->i", scaled, scaled)
    moved = exponent < BUMP_REACH**2
    height = size * rng.uniform(BUMP_HEIGHT.low, BUMP_HEIGHT.high) * rng.choice([-1.0, 1.0])
    bumped = points.copy()
    bumped[moved] += np.multiply.outer(height * np.exp(-0.5 * exponent[moved]), normal)
    return bumped, moved


def undersampled(rng: Generator, size: int) -> Mask:
    """The points kept when a random share is removed."""
    share = rng.uniform(REMOVED_SHARE.low, REMOVED_SHARE.high)
    return random_subset(rng, size, max(round((1.0 - share) * size), min(size, FEWEST_POINTS)))


def without_part(rng: Generator, points: Array) -> Mask:
    """The points kept outside a sphere about a random point; its radius is halved while too few are left."""
    offsets = points - points[rng.integers(len(points))]
    squared = np.einsum("ij,ij->i", offsets, offsets)
    radius = diagonal(points) * rng.uniform(MISSING_RADIUS.low, MISSING_RADIUS.high)
    while np.count_nonzero(squared > radius**2) < min(FEWEST_POINTS, len(points) - 1):
        radius /= 2.0
    return squared > radius**2


def perturb(rng: Generator, points: Array, kind: str, perturbation: str) -> tuple[Array, Mask]:
    """The perturbed points and the mask of those that were moved; raises `KeyError` for an unknown type."""
    recipe = TYPES[perturbation]
    moved = np.zeros(len(points), dtype=bool)
    if recipe.noise is not None:
        points, moved = add_noise(rng, points, NOISE.get(kind, NoiseLaw()), recipe.noise)
    if recipe.bump:
        points, moved = add_bump(rng, points)
    if recipe.removal is None:
        return points, moved
    kept = undersampled(rng, len(points)) if recipe.removal == "undersampling" else without_part(rng, points)
    return points[kept], moved[kept]
