"""Voting in few dimensions: the fullest cell, looked at ever more closely."""

import numpy as np

from primfit.fitting.geometry.vectors import Array, basis

CELLS = 40
ZOOMS = 3
SPANNED = 5
"""Cells of a histogram that the next, finer one spans about the fullest."""

DIRECTIONS = 500
"""Directions of half a sphere that are voted on first: they are about 6 degrees apart."""
APART = 0.11
STEPS = np.linspace(-1.0, 1.0, 7)
"""Steps, in the last distance, of the grid of directions that is voted on next."""
LEANS = 40
"""Cells of the cosine between a normal and an axis."""


def peak(values: Array, low: float, high: float) -> tuple[float, int]:
    """The value that most of the values (N,) between two bounds are near to, and how many are.

    Cells are smoothed by their neighbors. NaN and 0 where there is no value.
    """
    seen = values[(values >= low) & (values <= high)]
    for _ in range(ZOOMS):
        if len(seen) < 2 or not low < high:
            break
        votes, edges = np.histogram(seen, CELLS, (low, high))
        best = int(np.argmax(np.convolve(votes, (1.0, 2.0, 1.0), "same")))
        low, high = edges[max(best - SPANNED // 2, 0)], edges[min(best + 1 + SPANNED // 2, CELLS)]
        closer = seen[(seen >= low) & (seen <= high)]
        if len(closer) < len(seen) / 4:
            break
        seen = closer
    return (float(np.median(seen)), len(seen)) if len(seen) else (np.nan, 0)


def half_sphere(count: int) -> Array:
    """Unit vectors (count, 3) with z >= 0, evenly spread along a spiral by the golden angle."""
    z = (np.arange(count) + 0.5) / count
    azimuth = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    ring = np.sqrt(1.0 - z * z)
    return np.column_stack([ring * np.cos(azimuth), ring * np.sin(azimuth), z])


def around(direction: Array, width: float) -> Array:
    """A grid of unit vectors (K, 3) about one, out to `width` [rad] to each side."""
    u, v = basis(direction)
    steps = width * STEPS
    grid = direction + steps[:, None, None] * u + steps[None, :, None] * v
    grid = grid.reshape(-1, 3)
    return grid / np.linalg.norm(grid, axis=1, keepdims=True)


def voted_normal(normals: Array, weights: Array) -> Array:
    """The direction (3,) that most normals (N, 3) point along, either way; votes are spread as far as the
    directions are apart."""
    directions, width = half_sphere(DIRECTIONS), APART
    best = directions[0]
    for _ in range(ZOOMS + 1):
        sines = 1.0 - (directions @ normals.T) ** 2
        best = directions[np.argmax(np.exp(-0.5 * sines / width**2) @ weights)]
        directions, width = around(best, width), width / 3.0
    return best


def voted_axis(normals: Array, weights: Array, low: float, high: float) -> tuple[Array, float]:
    """The direction (3,) that most normals (N, 3) have one angle with, and the cosine of that.

    The cosine is between two bounds: about 0 for a cylinder, the sine of the half-angle for a cone.
    """
    directions, width = half_sphere(DIRECTIONS), APART
    best, cosine = directions[0], low
    for zoom in range(ZOOMS):
        votes, edges = lean_votes(directions, normals, weights, low, high, LEANS if zoom else LEANS // 2)
        place, cell = np.unravel_index(np.argmax(votes), votes.shape)
        best, cosine = directions[place], edges[cell : cell + 2].mean()
        directions, width = around(best, width), width / 3.0
    return best, float(cosine)


def lean_votes(
    directions: Array, normals: Array, weights: Array, low: float, high: float, cells: int
) -> tuple[Array, Array]:
    """Votes (K, cells) of normals for their cosines with K directions, smoothed, and the cells' edges."""
    leans = np.abs(directions @ normals.T)
    place = np.floor((leans - low) / (high - low) * cells)
    inside = (place >= 0) & (place < cells)
    flat = (np.arange(len(directions))[:, None] * cells + place)[inside].astype(int)
    spread = np.broadcast_to(weights, leans.shape)[inside]
    votes = np.bincount(flat, spread, len(directions) * cells).reshape(-1, cells)
    padded = np.pad(votes, ((0, 0), (1, 1)))
    return votes + 0.5 * (padded[:, :-2] + padded[:, 2:]), np.linspace(low, high, cells + 1)
