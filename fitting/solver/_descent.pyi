from ..geometry.vectors import Array
from ..trial._limits import Bounds

NAMES: tuple[str, ...]

def distances(kind: int, row: Array, points: Array) -> Array: ...
def derivatives(kind: int, row: Array, points: Array) -> tuple[Array, Array]: ...
def stepped(kind: int, row: Array, step: Array) -> Array: ...
def refine(
    kind: int,
    row: Array,
    points: Array,
    kernel: int,
    scale: float,
    max_iterations: int,
    factors: Array | None = None,
    limits: Bounds | None = None,
) -> tuple[Array, float, bool]: ...
