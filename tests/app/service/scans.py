"""Scans with segments, as text."""

from typing import Any

import numpy as np


def csv(points: np.ndarray, labels: Any = None) -> bytes:
    """Points (N, 3), and their labels where there are any."""
    rows = [",".join(map(repr, row)) for row in points.tolist()]
    if labels is None:
        return "\n".join(["x,y,z", *rows]).encode()
    return "\n".join(
        ["x,y,z,label", *(f"{row},{label}" for row, label in zip(rows, labels, strict=True))]
    ).encode()


def many(n_segments: int, n_points: int = 100) -> bytes:
    """A scan of so many cylinders in one file; each differs from the others."""
    rng = np.random.default_rng(n_segments)
    n = n_segments * n_points
    angle, height = rng.uniform(0, 5, n), rng.uniform(-2, 2, n)
    radius = np.repeat(np.linspace(1, 2, n_segments), n_points)
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])
    return csv(points + rng.normal(scale=1e-3, size=(n, 3)), np.repeat(np.arange(n_segments), n_points))
