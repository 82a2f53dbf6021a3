"""Where a recognised primitive begins and ends: one small file a kind, and the contract that they share."""

from typing import Any

import numpy as np
from scipy.spatial import QhullError

from ..geometry.vectors import Array
from ..primitives import Primitive
from .cone import ConeExtents
from .cylinder import CylinderExtents
from .plane import PlaneExtents
from .sphere import SphereExtents
from .torus import TorusExtents

__all__ = [
    "EXTENTS",
    "ConeExtents",
    "CylinderExtents",
    "Extents",
    "PlaneExtents",
    "SphereExtents",
    "TorusExtents",
    "extents_of",
]

Extents = PlaneExtents | SphereExtents | CylinderExtents | ConeExtents | TorusExtents

EXTENTS: dict[str, Any] = {
    extents.kind: extents
    for extents in (PlaneExtents, SphereExtents, CylinderExtents, ConeExtents, TorusExtents)
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
    feet = points - primitive.signed_distance(points)[:, None] * primitive.gradient(points)
    try:
        found: Extents = EXTENTS[primitive.kind].of(primitive, feet, noise)
    except QhullError:
        return None
    return found if np.isfinite(found.area) and found.area > 0.0 else None
