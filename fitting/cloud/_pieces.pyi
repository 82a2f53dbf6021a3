import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array

def halves(points: Array, times: int) -> NDArray[np.intp]: ...
def numbered(order: NDArray[np.intp], times: int) -> NDArray[np.intp]: ...
def local_planes(
    points: Array, order: NDArray[np.intp], times: int, at: Array, k: int
) -> tuple[Array, Array, Array]: ...
