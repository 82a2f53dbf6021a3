"""The trimmed surface as a rectangle of the parameters of `Primitive.surface`, which every exporter draws."""

from dataclasses import dataclass

import numpy as np

from primfit.fitting.answer.result import Recognition
from primfit.fitting.extents.cone import ConeExtents
from primfit.fitting.extents.cylinder import CylinderExtents
from primfit.fitting.extents.plane import PlaneExtents
from primfit.fitting.extents.sphere import SphereExtents
from primfit.fitting.extents.torus import TorusExtents
from primfit.fitting.extents.values import Extents
from primfit.fitting.geometry.vectors import Array, around_axis, basis, cross
from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus


class NothingToExportError(ValueError):
    """There is no primitive, or no extents to trim it to."""


@dataclass(frozen=True)
class Patch:
    """A piece of a surface of revolution: u about the axis, v along the profile.

    Attributes
    ----------
    origin, axis, reference : (3,) where v and u are measured from; `reference` is where u is 0
    u, v : ranges; angles, or heights along the axis
    closed_u, closed_v : the range is a full turn
    """

    primitive: Cylinder | Cone | Sphere | Torus
    origin: Array
    axis: Array
    reference: Array
    u: tuple[float, float]
    v: tuple[float, float]
    closed_u: bool
    closed_v: bool = False

    def profile(self, v: Array | float) -> tuple[Array, Array]:
        """Distance from the axis and height above the origin."""
        v = np.asarray(v, np.float64)
        match self.primitive:
            case Cylinder(radius=radius):
                return np.full_like(v, radius), v
            case Cone(half_angle=half_angle):
                return v * np.tan(half_angle), v
            case Sphere(radius=radius):
                return radius * np.cos(v), radius * np.sin(v)
            case Torus(major_radius=major, minor_radius=minor):
                return major + minor * np.cos(v), minor * np.sin(v)

    def direction(self, u: Array | float) -> Array:
        """Unit vectors (..., 3) across the axis."""
        beyond = cross(self.axis, self.reference)
        return np.multiply.outer(np.cos(u), self.reference) + np.multiply.outer(np.sin(u), beyond)

    def at(self, u: Array | float, v: Array | float) -> Array:
        """Points (..., 3) of the surface."""
        rho, height = self.profile(v)
        u, rho, height = np.broadcast_arrays(np.asarray(u, np.float64), rho, height)
        return self.origin + rho[..., None] * self.direction(u) + np.multiply.outer(height, self.axis)

    @property
    def has_pole(self) -> tuple[bool, bool]:
        """Whether the surface shrinks to a point at either end of v: a cone's apex, a pole of a sphere."""
        match self.primitive:
            case Cone():
                return self.v[0] == 0.0, False
            case Sphere():
                return self.v[0] == -np.pi / 2.0, self.v[1] == np.pi / 2.0
        return False, False

    @property
    def is_closed(self) -> bool:
        """Whether the piece has no edge: a full sphere or a full torus."""
        return self.closed_u and (self.closed_v or all(self.has_pole))


def answered(recognition: Recognition) -> Primitive:
    """The primitive that is exported: the first of an ambiguous answer, the best try of `no_fit`.

    Raises
    ------
    NothingToExportError
        If the answer has no primitive.
    """
    if recognition.primitive is None:
        raise NothingToExportError(f"the answer is {recognition.status} and holds no primitive to export")
    return recognition.primitive


def trimmed(recognition: Recognition) -> tuple[Primitive, Extents]:
    """The primitive that is exported, and its extents.

    Raises
    ------
    NothingToExportError
        If the answer has no primitive, or its points span no surface to trim it to.
    """
    primitive = answered(recognition)
    if recognition.extents is None:
        raise NothingToExportError(f"the {primitive.kind} cannot be trimmed: it has no extents")
    return primitive, recognition.extents


Pieces = tuple[tuple[Array, ...], ...]
"""Of each piece of a plane the outer ring (K, 3), then those of its holes."""


def patch_of(primitive: Primitive, extents: Extents) -> Patch | Pieces:
    """The piece of a surface of revolution, or the pieces of a plane."""
    match primitive, extents:
        case Plane(), PlaneExtents():
            return extents.concave_outline
        case Sphere(), SphereExtents():
            lowest = -np.pi / 2.0 if extents.full_sphere else np.pi / 2.0 - extents.half_angle
            v = (lowest, np.pi / 2.0 - extents.start_half_angle)
            reference = basis(extents.axis)[0]
            turn = (0.0, 2.0 * np.pi)
            return Patch(primitive, primitive.center, extents.axis, reference, turn, v, True)
        case Cylinder(), CylinderExtents():
            _, _, ends = around_axis(np.stack([extents.start, extents.end]), primitive.point, primitive.axis)
            origin, v = primitive.point, (float(ends[0]), float(ends[1]))
            return Patch(primitive, origin, primitive.axis, extents.reference_direction, *_arc(extents, v))
        case Cone(), ConeExtents():
            v = (extents.start_height, extents.end_height)
            return Patch(
                primitive, primitive.apex, primitive.axis, extents.reference_direction, *_arc(extents, v)
            )
        case Torus(), TorusExtents():
            v = (extents.tube_start_angle, extents.tube_start_angle + extents.tube_span)
            return Patch(
                primitive,
                primitive.center,
                primitive.axis,
                extents.reference_direction,
                *_arc(extents, v),
                extents.tube_full_turn,
            )
    raise TypeError(f"extents of a {extents.kind} do not trim a {primitive.kind}")


def _arc(
    extents: CylinderExtents | ConeExtents | TorusExtents, v: tuple[float, float]
) -> tuple[tuple[float, float], tuple[float, float], bool]:
    return (extents.start_angle, extents.start_angle + extents.span), v, extents.full_turn
