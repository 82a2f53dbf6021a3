"""Square cells over points of a plane, and how many of the points each of them holds."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ..geometry.vectors import Array


@dataclass(frozen=True, eq=False)
class Grid:
    """Rows along the first coordinate, columns along the second.

    Attributes
    ----------
    low : (2,) corner where the cells begin
    step : (2,) sides of a cell
    taken : (N,) number of the cell of each point, row by row
    counts : (rows, columns) points in each cell
    """

    low: Array
    step: Array
    taken: np.ndarray
    counts: np.ndarray

    @classmethod
    def of(cls, points: Array, low: Array, size: Array, side: float) -> Self:
        """Over the rectangle of a size from `low` on; points outside it count at its edge."""
        shape = np.maximum(np.round(size / side), 1.0).astype(np.intp)
        step = size / shape
        row, column = np.clip(((points - low) / step).astype(np.intp), 0, shape - 1).T
        taken = row * shape[1] + column
        return cls(low, step, taken, np.bincount(taken, minlength=int(shape.prod())).reshape(shape))

    def centers(self, cells: np.ndarray) -> Array:
        """Middles (K, 2) of the cells of a mask (rows, columns), row by row."""
        return self.low + (np.argwhere(cells) + 0.5) * self.step


def around(values: np.ndarray, combine: np.ufunc = np.add) -> np.ndarray:
    """The sum (or largest) over each cell and its eight neighbours; beyond the edge there is 0."""
    padded = np.pad(values, 1)
    rows = combine(combine(padded[:-2], padded[1:-1]), padded[2:])
    return np.asarray(combine(combine(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:]))
