"""What a scanner does to the points it sees: noise along the ray, mixed pixels, outliers, rounded output."""

from typing import Literal

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

Law = Literal["box", "neighbour"]


def sigma_weights(distance: Array, cosine: Array) -> Array:
    """How the noise of a point compares with the others, root mean square 1.

    In proportion to the range, and growing with the incidence i as sqrt(1 + (tan(i) / 2)^2).
    """
    tangent_squared = 1.0 / cosine**2 - 1.0
    weights = distance * np.sqrt(1.0 + tangent_squared / 4.0)
    return weights / np.sqrt(np.mean(weights**2))


def correlated(rng: Generator, rows: int, columns: int, length: float) -> Array:
    """A normal field (rows, columns) of unit variance, white or correlated over `length` cells of a ray grid.

    Convolved with a Gaussian of standard deviation length / 2, so that the correlation at distance d is
    exp(-(d / length)^2); by rows and columns, with a margin, so that edges are like the middle.
    """
    if length <= 0.0:
        return rng.standard_normal((rows, columns))
    reach = int(np.ceil(2 * length))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (length / 2)) ** 2)
    kernel /= np.sqrt(np.sum(kernel**2))
    field = rng.standard_normal((rows + 2 * reach, columns + 2 * reach))
    by_row = sum((weight * field[k : k + rows] for k, weight in enumerate(kernel)), np.zeros(()))
    return sum((weight * by_row[:, k : k + columns] for k, weight in enumerate(kernel)), np.zeros(()))


def edges(seen: Mask) -> Mask:
    """Of the rays of a grid that hit (rows, columns), those beside one that misses."""
    padded = np.pad(seen, 1)
    inside = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    return seen & ~inside


def gross_outliers(rng: Generator, points: Array, count: int, law: Law) -> Array:
    """`count` points (count, 3) that have nothing to do with the surface that `points` were seen on.

    "box": uniform in the bounding box about its centre, its sides doubled. "neighbour": uniform on a square
    with the cloud's diagonal as side, in a plane that touches the cloud from a random direction.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    if law == "box":
        return (low + high) / 2 + (high - low) * rng.uniform(-1.0, 1.0, (count, 3))
    normal, across, along = np.linalg.qr(rng.standard_normal((3, 3)))[0].T
    touched = points[np.argmax(points @ normal)]
    side = np.linalg.norm(high - low)
    places = side * rng.uniform(-0.5, 0.5, (count, 2))
    return touched + places @ np.stack([across, along])


def rounded(points: Array, step: float | None) -> tuple[Array, float]:
    """Points at multiples of a step, or as float32 (`None`); and the largest distance of two such values."""
    if step == 0.0:
        return points, 0.0
    if step is None:
        return points.astype(np.float32).astype(np.float64), float(
            np.spacing(np.float32(np.abs(points).max()))
        )
    return np.round(points / step) * step, step
