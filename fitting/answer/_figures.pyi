from ..geometry.vectors import Array

def figures(
    distance: Array, judged: Array, reach: float, share: float
) -> tuple[float, float, float, float, float, float, float, float]: ...
