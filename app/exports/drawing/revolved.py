"""A piece of a surface of revolution: u about the axis, v along the profile."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from primfit.fitting.extents.cone import ConeExtents
from primfit.fitting.extents.cylinder import CylinderExtents
from primfit.fitting.extents.torus import TorusExtents
from primfit.fitting.geometry.vectors import Array, around_axis, basis, cross

from .patch import Patch, Span
from .unrolled import near

Profile = Callable[[Array], tuple[Array, Array]]
"""From v to the distance from the axis and the height above the origin."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Revolved(Patch):
    """A profile turned about an axis.

    Attributes
    ----------
    origin, axis, reference : (3,) where v and u are measured from; `reference` is where u is 0
    draws_axis : the axis is the surface's own, and not only that of the piece
    """

    origin: Array
    axis: Array
    reference: Array
    profile: Profile
    draws_axis: bool = True

    def place(self, v: float) -> tuple[float, float]:
        """The distance from the axis and the height above the origin at one v."""
        rho, height = self.profile(np.asarray(v, np.float64))
        return float(rho), float(height)

    def direction(self, u: Array | float) -> Array:
        """Unit vectors (..., 3) across the axis."""
        beyond = cross(self.axis, self.reference)
        return np.multiply.outer(np.cos(u), self.reference) + np.multiply.outer(np.sin(u), beyond)

    def at(self, u: Array | float, v: Array | float) -> Array:
        rho, height = self.profile(np.asarray(v, np.float64))
        u, rho, height = np.broadcast_arrays(np.asarray(u, np.float64), rho, height)
        return self.origin + rho[..., None] * self.direction(u) + np.multiply.outer(height, self.axis)

    def around(self, points: Array) -> tuple[Array, Array, Array]:
        """Of points (N, 3) the angle u near the piece, the distance from the axis and the height."""
        radial, rho, height = around_axis(points, self.origin, self.axis)
        beyond = cross(self.axis, self.reference)
        angle = np.arctan2(radial @ beyond, radial @ self.reference)
        return near(angle, self.u.middle), rho, height

    def axis_line(self) -> Array | None:
        if not self.draws_axis:
            return None
        heights = self.profile(self.v.samples(49))[1]
        low, high = float(heights.min()), float(heights.max())
        margin = 0.15 * max(high - low, float(self.profile(np.array(self.v.ends))[0].max()))
        return self.origin + np.outer([low - margin, high + margin], self.axis)

    def directions(self) -> tuple[Array, Array]:
        """The axis, turned up, and the middle of the arc."""
        up = self.axis if self.axis[2] >= -1e-9 else -self.axis
        return up, basis(up)[1] if self.u.closed else self.direction(self.u.middle)


def swept(
    extents: CylinderExtents | ConeExtents | TorusExtents,
    profile: Profile,
    v: Span,
    origin: Array,
    axis: Array,
    poles: tuple[bool, bool] = (False, False),
) -> Revolved:
    """The piece over the arc of the extents, whose largest circle is where the profile is farthest out."""
    widest = float(profile(v.samples(33))[0].max())
    u = Span(extents.start_angle, extents.start_angle + extents.span, widest, extents.full_turn)
    reference = extents.reference_direction
    return Revolved(u=u, v=v, poles=poles, origin=origin, axis=axis, reference=reference, profile=profile)
