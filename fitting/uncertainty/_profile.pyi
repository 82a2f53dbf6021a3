from collections.abc import Sequence

from ..geometry.vectors import Array
from ..trial._limits import Bounds

def numbers(kind: int, row: Array, center: Array) -> tuple[Array, Array]: ...

class Region:
    def __init__(
        self,
        kind: int,
        row: Array,
        points: Array,
        *,
        kernel: int,
        scale: float,
        factors: Array | None,
        bounds: Bounds | None,
        touches: float,
        center: Array,
        sizes: Sequence[int],
        angles: Sequence[bool],
    ) -> None: ...
    @property
    def rows(self) -> Array: ...
    def ends(self, weights: Array, half: float, rise: float) -> tuple[Array | None, Array | None]: ...
