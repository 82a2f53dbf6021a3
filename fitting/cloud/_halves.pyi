import numpy as np
from numpy.typing import NDArray

from ..geometry.vectors import Array

def halves(points: Array, times: int) -> NDArray[np.int64]: ...
