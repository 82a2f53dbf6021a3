"""How a torus is drawn: v is the angle around the tube, 0 where it is farthest from the axis [rad]."""

import numpy as np

from primfit.fitting.extents.torus import TorusExtents
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.torus import Torus

from .patch import Span
from .revolved import Revolved, swept
from .unrolled import Unrolled, near

POSITIVE = "outside the tube"
UPRIGHT = "axis"


def trimmed(primitive: Torus, extents: TorusExtents) -> Revolved:
    major, minor = primitive.major_radius, primitive.minor_radius
    start = extents.tube_start_angle
    v = Span(start, start + extents.tube_span, minor, extents.tube_full_turn)

    def profile(v: Array) -> tuple[Array, Array]:
        return major + minor * np.cos(v), minor * np.sin(v)

    return swept(extents, profile, v, primitive.center, primitive.axis)


def unrolled(primitive: Torus, shape: Revolved, points: Array) -> Unrolled:
    angle, rho, height = shape.around(points)
    tube = near(np.arctan2(height, rho - primitive.major_radius), shape.v.middle)
    names = ("around the axis", "around the tube")
    return Unrolled(np.degrees(angle), np.degrees(tube), names, (False, False))
