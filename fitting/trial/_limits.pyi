from collections.abc import Sequence

import numpy as np

from ..geometry.vectors import Array

class Bounds:
    def __init__(
        self,
        *,
        frozen: Sequence[bool] | np.ndarray,
        slots: Sequence[int],
        low: Array,
        high: Array,
        reference: Array,
        most_tilt: float,
    ) -> None: ...
