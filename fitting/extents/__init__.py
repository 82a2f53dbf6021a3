"""Where a recognized primitive begins and ends: one file a kind, of its name."""

import math
from importlib import import_module

import numpy as np

from ..geometry.vectors import Array
from ..names import KINDS
from ..primitives.primitive import Primitive
from .values import Extents

EXTENTS: dict[str, type[Extents]] = {
    kind: getattr(import_module(f".{kind}", __name__), f"{kind.capitalize()}Extents") for kind in KINDS
}


def extents_of(primitive: Primitive, points: Array, noise: float) -> Extents | None:
    """The extents of a primitive about the points that belong to it, in their units.

    Parameters
    ----------
    points : (N, 3), without the outliers; what counts are their feet on the surface
    noise : standard deviation of their noise, which blurs ends along the surface as well

    Returns
    -------
    None where the feet span no surface: fewer than three points, or all on one line of a plane.
    """
    if len(points) < 3:
        return None
    points = np.ascontiguousarray(points, dtype=np.float64)
    found = EXTENTS[primitive.kind].of(primitive, points, float(noise))
    return found if found is not None and math.isfinite(found.area) and found.area > 0.0 else None


def has_arcs(kind: str) -> bool:
    """Whether arcs are told of a surface of this kind: `Extents.arcs`."""
    return EXTENTS[kind].arcs is not Extents.arcs
