from ..geometry.vectors import Array

Pieces = tuple[list[list[Array]], float, Array]

def coverage(along: Array, across: Array, aspect: float) -> float: ...
def cylinder(
    points: Array, point: Array, axis: Array, radius: float, blur: float
) -> tuple[float, float, float, float, bool, float]: ...
def cone(
    points: Array, apex: Array, axis: Array, half_angle: float, blur: float
) -> tuple[float, float, float, float, bool, float]: ...
def torus(
    points: Array, center: Array, axis: Array, major: float, minor: float, blur: float
) -> tuple[float, float, bool, float, float, bool, float, float]: ...
def sphere(
    points: Array, center: Array, radius: float, blur: float, spread: Array
) -> tuple[tuple[float, float, float], float, float, bool, float]: ...
def plane(
    points: Array, point: Array, first: Array, second: Array, blur: float
) -> tuple[Array, float, float, Array, Array, Pieces | None] | None: ...
