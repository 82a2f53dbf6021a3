"""What happens at the border of a segment: ragged cuts, edge fringes, comet tails."""

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from .effects import Seen
from .fields import Rough
from .recipes import Range
from .scanner import log_uniform

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

RAGGEDNESS = Range(0.01, 0.08)
"""How far a border grown by a region leaps to and fro, in extents, standard deviation."""
RAGGED_REACH = 0.1
"""Over which distance it does so, in extents."""
FRINGE_SIZE = Range(1.0, 6.0)
"""How far edge points stand off on the average, in noises."""
FRINGE_SHARE, TAIL_SHARE = Range(0.2, 0.8), Range(0.05, 0.4)
"""Of the edge points."""
TAIL_REACH = Range(0.03, 0.3)
"""How far comet tails go back along the rays, in extents."""
MOST_MIXED = 0.08
"""Of all points: nearly all rays of a sparse grid are at an edge."""


def ragged(rng: Generator, points: Array, keeps: float) -> Mask:
    """The share `keeps` of the points on one side of a border that wanders to and fro."""
    extent = float(np.linalg.norm(np.ptp(points, axis=0)))
    direction = rng.standard_normal(3)
    height = points @ (direction / np.linalg.norm(direction))
    wander = log_uniform(rng, RAGGEDNESS) * extent * Rough(RAGGED_REACH * extent).draw(rng, points)
    border = height + wander
    return border >= np.quantile(border, 1.0 - keeps)


def some_of(rng: Generator, edge: Mask, share: Range) -> Mask:
    """A drawn share of the edge points, at most `MOST_MIXED` of all."""
    places = np.flatnonzero(edge)
    count = min(int(rng.uniform(share.low, share.high) * len(places)), int(MOST_MIXED * len(edge)))
    chosen = np.zeros(len(edge), dtype=bool)
    chosen[rng.permutation(places)[:count]] = True
    return chosen


def edge_fringe(rng: Generator, seen: Seen, points: Array, noise: float) -> tuple[Array, Mask]:
    """Edge points lean to what is behind or before the part, all to the same side, by some noises.

    Disparity windows and laser spots see both (Hirschmueller, Innocent and Garibaldi, "Real-time
    correlation-based stereo vision with reduced border errors", IJCV 47, 2002; Adams and Probert,
    International Journal of Robotics Research 15, 1996).
    """
    moved = some_of(rng, seen.on_edge, FRINGE_SHARE)
    step = rng.choice([-1.0, 1.0]) * noise * log_uniform(rng, FRINGE_SIZE)
    error = np.where(moved, step * rng.random(len(points)), 0.0)
    return points + error[:, None] * seen.rays, moved


def comet_tail(rng: Generator, seen: Seen, points: Array) -> tuple[Array, Mask]:
    """Mixed pixels: edge points lie anywhere along their ray behind the part.

    Tang, Huber and Akinci, "A comparative analysis of depth-discontinuity and mixed-pixel detection
    algorithms", 3DIM 2007.
    """
    moved = some_of(rng, seen.on_edge, TAIL_SHARE)
    reach = seen.extent * log_uniform(rng, TAIL_REACH)
    error = np.where(moved, reach * rng.random(len(points)), 0.0)
    return points + error[:, None] * seen.rays, moved
