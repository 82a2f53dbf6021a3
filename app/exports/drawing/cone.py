"""How a cone is drawn: v is the height above its apex."""

import numpy as np

from primfit.fitting.extents.cone import ConeExtents
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.cone import Cone

from .patch import Span
from .revolved import Revolved, swept
from .unrolled import Unrolled

POSITIVE = "outside"
UPRIGHT = "axis"


def trimmed(primitive: Cone, extents: ConeExtents) -> Revolved:
    v = Span(extents.start_height, extents.end_height, 0.0)
    tangent = np.tan(primitive.half_angle)

    def profile(v: Array) -> tuple[Array, Array]:
        return v * tangent, v

    return swept(extents, profile, v, primitive.apex, primitive.axis, (v.start == 0.0, False))


def unrolled(primitive: Cone, shape: Revolved, points: Array) -> Unrolled:
    angle, _, height = shape.around(points)
    names = ("around the axis", "height from the apex")
    return Unrolled(np.degrees(angle), height, names, (False, True))
