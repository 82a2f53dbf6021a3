from collections.abc import Sequence

import numpy as np

from ..geometry.vectors import Array

_Columns = tuple[Array, Array, Array, Array, Array, Array, Array, Array]

class Grid:
    def __init__(
        self,
        ranges: Sequence[float],
        rough: int,
        sizes: Sequence[Sequence[float]],
        which: Sequence[Sequence[int]],
        pairs: Sequence[Sequence[int]],
    ) -> None: ...

def explained(
    grid: Grid,
    mean: Array,
    jacobian: Array,
    count: Array,
    apart: Array,
    scatter: float,
    spare: float,
    prior: float,
    least: float,
) -> tuple[_Columns, float, float, Array]: ...
def patched(
    patch: np.ndarray, grain: np.ndarray, residual: Array, jacobian: Array, place: Array, turn: float
) -> tuple[Array, Array, Array, Array, float, float, float]: ...
