from collections.abc import Sequence

from ..geometry.vectors import Array

def newton(
    kind: int, row: Array, points: Array, kernel: int, scale: float, pairs: Sequence[tuple[int, int]]
) -> Array | None: ...
