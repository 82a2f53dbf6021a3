"""How a plane is drawn."""

from primfit.fitting.extents.plane import PlaneExtents
from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives.plane import Plane

from .flat import Flat
from .unrolled import Unrolled

POSITIVE = "on the side the normal points to"
UPRIGHT = "normal"


def trimmed(primitive: Plane, extents: PlaneExtents) -> Flat:
    return Flat(
        extents.concave_outline,
        primitive.normal,
        extents.center,
        extents.length_direction,
        extents.width_direction,
    )


def unrolled(primitive: Plane, shape: Flat, points: Array) -> Unrolled:
    relative = points - shape.center
    names = ("along the length", "along the width")
    return Unrolled(relative @ shape.long, relative @ shape.short, names, (True, True))
