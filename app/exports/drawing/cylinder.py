"""How a cylinder is drawn: v is the height above its `point`."""

import numpy as np

from primfit.fitting.extents.cylinder import CylinderExtents
from primfit.fitting.geometry.vectors import Array, around_axis
from primfit.fitting.primitives.cylinder import Cylinder

from .patch import Span
from .revolved import Revolved, swept
from .unrolled import Unrolled

POSITIVE = "outside"
UPRIGHT = "axis"


def trimmed(primitive: Cylinder, extents: CylinderExtents) -> Revolved:
    _, _, ends = around_axis(np.stack([extents.start, extents.end]), primitive.point, primitive.axis)
    v = Span(float(ends[0]), float(ends[1]), 0.0)

    def profile(v: Array) -> tuple[Array, Array]:
        return np.full_like(v, primitive.radius), v

    return swept(extents, profile, v, primitive.point, primitive.axis)


def unrolled(primitive: Cylinder, shape: Revolved, points: Array) -> Unrolled:
    angle, _, height = shape.around(points)
    names = ("arc length around the axis", "along the axis")
    around = primitive.radius * (angle - shape.u.start)
    return Unrolled(around, height - shape.v.start, names, (True, True))
