"""How a sphere is drawn: v is the latitude above the equator of the cap [rad]."""

import numpy as np

from primfit.fitting.extents.sphere import SphereExtents
from primfit.fitting.geometry.vectors import Array, basis
from primfit.fitting.primitives.sphere import Sphere

from .patch import Span
from .revolved import Revolved
from .unrolled import Unrolled

POSITIVE = "outside"
UPRIGHT = "axis"
POLE = np.pi / 2.0


def trimmed(primitive: Sphere, extents: SphereExtents) -> Revolved:
    radius = primitive.radius
    low = -POLE if extents.full_sphere else POLE - extents.half_angle
    v = Span(low, POLE - extents.start_half_angle, radius)

    def profile(v: Array) -> tuple[Array, Array]:
        return radius * np.cos(v), radius * np.sin(v)

    return Revolved(
        u=Span(0.0, 2.0 * np.pi, float(profile(v.samples(33))[0].max()), closed=True),
        v=v,
        poles=(v.start == -POLE, v.end == POLE),
        origin=primitive.center,
        axis=extents.axis,
        reference=basis(extents.axis)[0],
        profile=profile,
        draws_axis=False,
    )


def unrolled(primitive: Sphere, shape: Revolved, points: Array) -> Unrolled:
    """A cap of no more than a hemisphere is laid flat with true distances from its middle."""
    angle, rho, height = shape.around(points)
    latitude = np.arctan2(height, rho)
    if shape.v.start >= 0.0:
        away = primitive.radius * (np.pi / 2.0 - latitude)
        name = "from the center of the cap"
        return Unrolled(away * np.cos(angle), away * np.sin(angle), (name, name), (True, True))
    names = ("around the axis of the cap", "above its equator")
    return Unrolled(np.degrees(angle), np.degrees(latitude), names, (False, False))
