"""What angle of a curved surface the points cover."""

import numpy as np

from ..geometry.vectors import Array, around_axis, basis
from ..primitives.cone import Cone
from ..primitives.cylinder import Cylinder
from ..primitives.primitive import Primitive
from ..primitives.sphere import Sphere
from ..primitives.torus import Torus

SEEN = 0.99
"""An arc is covered if this share of the points lies on it: strays do not make it whole."""


def arcs_of(primitive: Primitive, points: Array) -> dict[str, float]:
    """Degrees that points (N, 3) cover, by how they are counted; a plane has none.

    Of a sphere it is the opening angle of the cap about their mean direction; a torus has one about its axis
    and one around its tube.
    """
    if isinstance(primitive, Sphere):
        outward = primitive.gradient(points)
        middle = outward.mean(axis=0)
        cosines = outward @ (middle / max(float(np.linalg.norm(middle)), 1e-12))
        return {"cap": 2.0 * _degrees(float(np.arccos(np.clip(np.quantile(cosines, 1.0 - SEEN), -1.0, 1.0))))}
    if isinstance(primitive, Cylinder):
        return {"about the axis": _about(points, primitive.point, primitive.axis)}
    if isinstance(primitive, Cone):
        return {"about the axis": _about(points, primitive.apex, primitive.axis)}
    if isinstance(primitive, Torus):
        _, rho, height = around_axis(points, primitive.center, primitive.axis)
        return {
            "about the axis": _about(points, primitive.center, primitive.axis),
            "around the tube": covered(np.arctan2(height, rho - primitive.major_radius)),
        }
    return {}


def _about(points: Array, origin: Array, axis: Array) -> float:
    u, v = basis(axis)
    relative = points - origin
    return covered(np.arctan2(relative @ v, relative @ u))


def covered(angles: Array) -> float:
    """Degrees of the smallest arc that holds the share `SEEN` of angles (N,) [rad], at most a whole turn."""
    angles = np.sort(angles)
    held = int(np.ceil(SEEN * len(angles))) - 1
    twice = np.concatenate([angles, angles + 2.0 * np.pi])
    return _degrees(float(np.min(twice[held : held + len(angles)] - angles)))


def _degrees(angle: float) -> float:
    return float(np.degrees(angle))
