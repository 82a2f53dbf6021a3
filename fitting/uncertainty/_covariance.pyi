import numpy as np

from ..geometry.vectors import Array

def linearized(
    kind: int, row: Array, points: Array, kernel: int, scale: float, factors: Array | None = None
) -> Array: ...
def weighted_products(rows: Array, weight: Array) -> Array: ...
def inverted(square: Array, least: float) -> Array | None: ...
def uneven(
    rows: Array, pull: Array, slope: Array, bread: Array, copies: float, most_leverage: float
) -> tuple[Array, float]: ...
def fields(
    rows: Array,
    gain: Array,
    feet: Array,
    patch: np.ndarray,
    seen: np.ndarray,
    extent: float,
    rough: Array,
    smooth: Array,
) -> Array: ...
def mixture_ends(deviations: Array, weights: Array, free_squares: int, share: float) -> Array: ...
def mixed(
    meats: Array,
    shares: Array,
    weights: Array,
    bread: Array,
    free_squares: int,
    share: float,
    quantile: float,
) -> tuple[Array, float]: ...
