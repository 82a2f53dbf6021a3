import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array

def linear(
    kind: int, row: Array, points: Array, pivot: Array | None = None
) -> tuple[Array, Array, Array]: ...
def mostly(patch: np.ndarray, inlier: NDArray[np.uint8]) -> NDArray[np.uint8]: ...
