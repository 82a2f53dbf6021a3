"""What is compiled in `fitting.cloud`, and how coordinates are rounded, as it is defined, in NumPy."""

from decimal import Decimal
from itertools import count

import numpy as np
from scipy.spatial import cKDTree

from primfit.fitting.cloud.order import RESOLVED
from primfit.fitting.noise.rounding import COARSEST_STEPS, ULPS

Array = np.ndarray


def distance_keys(points: Array) -> Array:
    low, high = points.min(axis=0), points.max(axis=0)
    extent = float(np.max(high / 2.0 - low / 2.0))
    offsets = points / extent - low / extent
    offsets -= offsets.mean(axis=0)
    squared = np.sum(offsets**2, axis=1)
    unit = RESOLVED * float(squared.max())
    offsets -= squared @ offsets / float(squared.sum())
    first, second = (
        np.round(each / unit).astype(np.uint64) for each in (squared, np.sum(offsets**2, axis=1))
    )
    return (first << np.uint64(32)) + second


def hashed(keys: Array, multiplier: int) -> Array:
    mixed = keys * np.uint64(multiplier)
    for factor in (0xFF51AFD7ED558CCD, 0xC4CEB9FE1A85EC53):
        mixed ^= mixed >> np.uint64(33)
        mixed *= np.uint64(factor)
    return mixed ^ (mixed >> np.uint64(33))


def shuffled(keys: Array, rng: np.random.Generator) -> Array:
    starts = np.flatnonzero(np.append(True, keys[1:] != keys[:-1]))
    places = np.arange(len(keys)) - np.repeat(starts, np.diff(starts, append=len(keys)))
    multiplier = 2 * int(rng.integers(2**62, dtype=np.uint64)) + 1
    return np.argsort(hashed(keys + (places.astype(np.uint64) << np.uint64(52)), multiplier), kind="stable")


def frame(points: Array) -> tuple[Array, float]:
    """Center and scale."""
    lowest, highest = points.min(axis=0), points.max(axis=0)
    middle, half = lowest / 2.0 + highest / 2.0, float(np.max(highest / 2.0 - lowest / 2.0))
    offsets = (points - middle) / half
    centroid = offsets.mean(axis=0)
    rms = half * float(np.sqrt(np.mean(np.sum((offsets - centroid) ** 2, axis=1))))
    spacing = np.spacing(np.max(np.abs([lowest, highest]), axis=0))
    return np.round((middle + half * centroid) / spacing) * spacing, float(2.0 ** np.round(np.log2(rms)))


def halves(points: Array, times: int) -> Array:
    """Numbers (N,) of the pieces."""
    numbers = np.zeros(len(points), int)
    for _ in range(times):
        finer = 2 * numbers
        for piece in np.unique(numbers):
            among = np.flatnonzero(numbers == piece)
            along = int(np.argmax(np.ptp(points[among], axis=0)))
            order = np.argsort(points[among, along], kind="stable")
            finer[among[order[len(among) // 2 :]]] += 1
        numbers = finer
    return numbers


def local_planes(points: Array, at: Array, k: int) -> tuple[Array, Array, Array]:
    """Normals (M, 3), and scatter (M,) about the plane and in the narrower direction along it."""
    offsets = points[cKDTree(points).query(at, k=k)[1]]
    offsets -= offsets.mean(axis=1, keepdims=True)
    squares, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", offsets, offsets))
    scatter, breadth = np.sqrt(np.maximum(squares.T[:2], 0.0) / max(k - 3, 1))
    return vectors[:, :, 0], scatter, breadth


def rounding(points: Array) -> tuple[float, float | None]:
    """Size and step."""
    double, single = (ULPS * float(np.finfo(each).eps * np.abs(points).max()) for each in (float, np.float32))
    with np.errstate(over="ignore"):
        size = single if np.array_equal(points.astype(np.float32), points) else double
    step = step_of(points, double)
    if step is not None and step <= size:
        step = None
    finest = max(float(np.ptp(points, axis=0).max()) / COARSEST_STEPS, double)
    return max(each for each in (double, size, step or 0.0) if each <= finest), step


def step_of(points: Array, rounding: float) -> float | None:
    for decimals in count():
        exact = Decimal(1).scaleb(-decimals)
        if exact <= 2.0 * rounding:
            return None
        unit = float(exact)
        whole = np.rint(points / unit)
        if np.all(np.abs(points - unit * whole) <= rounding):
            units = int(np.gcd.reduce((whole - whole[0]).astype(np.int64), axis=None))
            return float(units * exact) or None
    return None
