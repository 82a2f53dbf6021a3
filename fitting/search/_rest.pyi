from typing import Any

from numpy.typing import NDArray

from ..geometry.vectors import Array
from ..trial._limits import Bounds

def with_its_scale(
    kind: int,
    row: Array,
    points: Array,
    smallest: float,
    steps: int,
    rounds: int,
    across: NDArray[Any],
    width: float,
    deviation: float,
    rest: float,
    factors: Array | None = None,
    limits: Bounds | None = None,
) -> tuple[Array, float, Array]: ...
