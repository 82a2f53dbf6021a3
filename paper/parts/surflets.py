"""Histograms of surflet-pair relations: four features of two points with normals, for many pairs.

Source: Wahl, Hillenbrand and Hirzinger, "Surflet-pair-relation histograms", 3DIM 2003, section 2.
"""

import numpy as np

from primfit.fitting.geometry.vectors import TINY, Array, cross

PARTS = 5
"""Each feature falls in one of so many parts of its range."""


def relations(points: Array, normals: Array) -> Array:
    """Features (P, 4) of all pairs of points (N, 3), each between 0 and 1.

    The frame of a pair stands at the point whose normal is nearer to the line between them. As estimated
    normals have no sign, that one is turned towards the other point, and the other normal to its side.
    """
    first, second = np.triu_indices(len(points), 1)
    line = points[second] - points[first]
    length = np.linalg.norm(line, axis=1)
    line /= (length + TINY)[:, None]
    near = np.abs(_dot(normals[first], line)) >= np.abs(_dot(normals[second], line))
    u = np.where(near[:, None], normals[first], normals[second])
    other = np.where(near[:, None], normals[second], normals[first])
    line = np.where(near[:, None], line, -line)
    u = u * _sign(_dot(u, line))[:, None]
    other = other * _sign(_dot(u, other))[:, None]
    v = cross(line, u)
    v /= (np.linalg.norm(v, axis=1) + TINY)[:, None]
    w = cross(u, v)
    turn = np.arctan2(_dot(w, other), _dot(u, other)) / np.pi + 0.5
    lean = (_dot(v, other) + 1.0) / 2.0
    return np.stack([turn, lean, _dot(u, line), length / (length.max(initial=0.0) + TINY)], axis=1)


def surflet_histogram(points: Array, normals: Array) -> Array:
    """Shares (PARTS ** 4,) of the pairs."""
    cells = np.minimum((PARTS * relations(points, normals)).astype(int), PARTS - 1)
    flat = np.ravel_multi_index(tuple(cells.clip(0).T), (PARTS,) * 4)
    return np.bincount(flat, minlength=PARTS**4) / max(len(flat), 1)


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("ij,ij->i", a, b)


def _sign(values: Array) -> Array:
    return np.where(values < 0.0, -1.0, 1.0)
