"""Random fields over points: rough, self-affine and smooth ones, as sums of cosines.

A stationary field with correlation C(d) is the limit of  sqrt(2 / K) sum cos(w_k . x + p_k)  with wave
vectors w_k drawn from the spectral density of C and uniform phases p_k (Shinozuka, "Simulation of
multivariate and multidimensional random processes", J. Acoust. Soc. America 49, 1971; the same as the random
Fourier features of Rahimi and Recht, NIPS 2007). It costs O(N K) for N points, wherever they lie, and needs
no grid. Wave numbers are stratified, so that each cloud, and not only the mean over many, has the variogram
of the law.
"""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.special import ndtri

Array = NDArray[np.float64]

TERMS = 400
"""Cosines a field: their sum is normal to a few per cent, and 200,000 points take a second or two."""
CHUNK = 2_000
"""Points at a time, so that a chunk's cosines stay within a processor's cache."""
TABLE = 400
"""Distances at which a correlation that is a sum is worked out; denser towards 0, and straight in between."""


class Field(Protocol):
    """A field of mean 0 and variance 1, known by its correlation."""

    name: ClassVar[str]

    @property
    def range(self) -> float:
        """The distance at which the correlation has fallen to 1/e."""
        ...

    def correlation(self, distance: Array) -> Array:
        """Of two points so far apart."""
        ...

    def draw(self, rng: Generator, points: Array) -> Array:
        """Its values (N,) at points (N, D)."""
        ...


def strata(rng: Generator, count: int) -> Array:
    """One uniform number of each of `count` equal parts of [0, 1], in random order."""
    return rng.permutation((np.arange(count) + rng.random(count)) / count)


def directions(rng: Generator, count: int, dimension: int) -> Array:
    """Unit vectors (count, dimension), uniform."""
    vectors = rng.standard_normal((count, dimension))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def cosines(rng: Generator, points: Array, waves: Array, variances: Array) -> Array:
    """sum sqrt(2 v_k) cos(w_k . x + p_k) at points (N, D), with uniform phases.

    In single precision, five times as fast: what that leaves out is noise of a millionth of the field.
    """
    phases = rng.uniform(0.0, 2 * np.pi, len(waves)).astype(np.float32)
    amplitudes = np.sqrt(2.0 * variances).astype(np.float32)
    single, across = points.astype(np.float32), waves.T.astype(np.float32)
    parts = [
        np.cos(single[first : first + CHUNK] @ across + phases) @ amplitudes
        for first in range(0, len(points), CHUNK)
    ]
    return np.concatenate(parts).astype(np.float64)


def equal_variances() -> Array:
    return np.full(TERMS, 1.0 / TERMS)


@dataclass(frozen=True)
class Rough:
    """The exponential variogram, 1 - exp(-d / length): continuous, but nowhere smooth.

    Its spectral density is that of a Cauchy vector in any dimension (Matern, nu = 1/2; Rasmussen and
    Williams, Gaussian Processes, 2006, section 4.2.1): w = z / (length |n|), z and n standard normal.
    """

    length: float
    name: ClassVar[str] = "rough"

    @property
    def range(self) -> float:
        return self.length

    def correlation(self, distance: Array) -> Array:
        return np.exp(-distance / self.length)

    def draw(self, rng: Generator, points: Array) -> Array:
        half_normal = ndtri(0.5 + strata(rng, TERMS) / 2)
        waves = rng.standard_normal((TERMS, points.shape[1])) / (self.length * half_normal[:, None])
        return cosines(rng, points, waves, equal_variances())


@dataclass(frozen=True)
class Smooth:
    """The Gaussian variogram, 1 - exp(-(d / length)^2 / 2): what a filter or a bending part leaves."""

    length: float
    name: ClassVar[str] = "smooth"

    @property
    def range(self) -> float:
        return float(np.sqrt(2.0)) * self.length

    def correlation(self, distance: Array) -> Array:
        return np.exp(-0.5 * (distance / self.length) ** 2)

    def draw(self, rng: Generator, points: Array) -> Array:
        waves = rng.standard_normal((TERMS, points.shape[1])) / self.length
        return cosines(rng, points, waves, equal_variances())


@dataclass(frozen=True)
class SelfAffine:
    """The power variogram d^(2 hurst) between two wavelengths; hurst = 1/2 is Brownian.

    Cosines with log-uniform wave numbers k and variances in proportion to k^(-2 hurst), in uniform directions
    of space, have it in the limit (Mandelbrot and van Ness, SIAM Review 10, 1968; Voss, "Random fractal
    forgeries", 1985). Waves longer than `longest` are left out: they only move and tilt the whole.
    """

    hurst: float
    shortest: float
    longest: float
    name: ClassVar[str] = "self-affine"

    @property
    def range(self) -> float:
        distance = np.linspace(0.0, self.longest, 500)
        return float(distance[np.argmax(self.correlation(distance) < np.exp(-1.0))])

    def wave_numbers(self, shares: Array) -> tuple[Array, Array]:
        """The wave numbers at these quantiles [0, 1], and their variances, of sum 1."""
        low, high = 2 * np.pi / self.longest, 2 * np.pi / self.shortest
        numbers = low * (high / low) ** shares
        variances = numbers ** (-2.0 * self.hurst)
        return numbers, variances / variances.sum()

    def correlation(self, distance: Array) -> Array:
        """sum v_k sin(k d) / (k d), the mean over directions in space."""
        numbers, variances = self.wave_numbers((np.arange(TERMS) + 0.5) / TERMS)
        tabulated = float(distance.max()) * np.linspace(0.0, 1.0, TABLE) ** 3
        values = np.sinc(np.multiply.outer(tabulated, numbers) / np.pi) @ variances
        return np.interp(distance, tabulated, values)

    def draw(self, rng: Generator, points: Array) -> Array:
        numbers, variances = self.wave_numbers(strata(rng, TERMS))
        waves = numbers[:, None] * directions(rng, TERMS, points.shape[1])
        return cosines(rng, points, waves, variances)
