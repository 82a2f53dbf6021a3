import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array

def costs(kernel: int, squared: Array) -> tuple[Array, Array]: ...
def core_scale(absolute: Array, core: float, deviation: float, rest: float) -> float: ...
def solve_fields(
    white: Array, bells: Array, which: NDArray[np.int64], sizes: Array, columns: Array
) -> tuple[Array, Array, Array]: ...
