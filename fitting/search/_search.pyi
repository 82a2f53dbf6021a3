import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array
from ..trial._limits import Bounds

def race(
    kind: int,
    rows: Array,
    points: Array,
    smallest: float,
    widths: float,
    resolved: float,
    stages: NDArray[np.int64],
    limits: Bounds | None = None,
) -> tuple[Array, Array]: ...
def distinct(distances: Array, same: float, most: int) -> list[int]: ...
def cheapest(distances: Array, smallest: float) -> int: ...
def anneal(
    kind: int,
    row: Array,
    points: Array,
    tolerance: float,
    shrink: float,
    locked: float,
    at_noise: float,
    need: int,
    core: float,
    deviation: float,
    limits: Bounds | None = None,
) -> tuple[Array, Array]: ...
