"""Plane patches with known cuts that the tests share."""

from collections.abc import Callable

import numpy as np

from primfit.fitting.geometry.vectors import Array


def _radius(at: Array) -> Array:
    return np.hypot(at[:, 0] - 0.5, at[:, 1] - 0.5)


CUTS: dict[str, tuple[Callable[[Array], np.ndarray], float, int]] = {
    "L": (lambda at: ~((at[:, 0] > 0.4) & (at[:, 1] > 0.4)), 0.64, 0),
    "U": (lambda at: ~((at[:, 0] > 0.3) & (at[:, 0] < 0.7) & (at[:, 1] > 0.3)), 0.72, 0),
    "ring": (lambda at: (_radius(at) < 0.5) & (_radius(at) > 0.25), np.pi * (0.5**2 - 0.25**2), 1),
    "disc": (lambda at: _radius(at) < 0.5, np.pi / 4.0, 0),
    "square": (lambda at: np.ones(len(at), bool), 1.0, 0),
}
"""Which points of the unit square are inside, their area, and the number of holes."""


def patch(name: str, n: int, seed: int = 0) -> Array:
    """`n` evenly random points (n, 2)."""
    inside, area, _ = CUTS[name]
    at = np.random.default_rng(seed).uniform(0.0, 1.0, (int(1.2 * n / area) + 100, 2))
    return at[inside(at)][:n]


def lattice(name: str, n: int) -> Array:
    """About `n` points (N, 2) on a square grid; each stands for a cell of it."""
    inside, area, _ = CUTS[name]
    each = int(np.sqrt(n / area))
    along = (np.arange(each) + 0.5) / each
    at = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    return at[inside(at)]
