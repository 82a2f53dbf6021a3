import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array

def costs(kernel: int, squared: Array) -> tuple[Array, Array]: ...
def derivatives(kind: int, row: Array, points: Array) -> tuple[Array, Array]: ...
def core_scale(absolute: Array, core: float, deviation: float, rest: float) -> float: ...
def stepped(kind: int, row: Array, step: Array) -> Array: ...
def refine(
    kind: int,
    row: Array,
    points: Array,
    kernel: int,
    scale: float,
    max_iterations: int,
    factors: Array | None = None,
    limits: Array | None = None,
) -> tuple[Array, float, bool]: ...
def pull(
    kind: int,
    row: Array,
    points: Array,
    kernel: int,
    scale: float,
    core: float,
    deviation: float,
    rest: float,
    factors: Array | None = None,
) -> tuple[Array, Array, float]: ...
def settle(
    kind: int,
    rows: Array,
    points: Array,
    smallest: float,
    widths: float,
    steps: int,
    limits: Array | None = None,
) -> tuple[Array, Array]: ...
def compete(
    kind: int,
    rows: Array,
    points: Array,
    smallest: float,
    widths: float,
    resolved: float,
    stages: NDArray[np.int64],
) -> tuple[Array, Array]: ...
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
    limits: Array | None = None,
) -> tuple[Array, Array | None]: ...
def solve_linear(design: Array, target: Array, rounds: int) -> Array: ...
def solve_circles(x: Array, y: Array, rounds: int) -> Array: ...
def solve_fields(
    white: Array, bells: Array, which: NDArray[np.int64], sizes: Array, columns: Array
) -> tuple[Array, Array, Array]: ...
def halves(points: Array, times: int) -> NDArray[np.int64]: ...
