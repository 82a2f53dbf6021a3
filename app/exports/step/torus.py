"""A torus in STEP; its meridians are circles about the middle of the tube."""

from primfit.fitting.geometry.vectors import cross
from primfit.fitting.primitives.torus import Torus

from ..drawing.revolved import Revolved
from ..fitted import NothingToExportError
from . import Faces
from .bounds import about_revolved
from .file import File, real


def faces(file: File, primitive: Torus, shape: Revolved) -> Faces:
    major, minor = primitive.major_radius, primitive.minor_radius
    if not major > minor:
        raise NothingToExportError("STEP has no torus whose major radius is not over the minor one")
    where = file.placement(shape.origin, shape.axis, shape.reference)
    surface = file.add(f"TOROIDAL_SURFACE('',{where},{real(major)},{real(minor)})")

    def meridian(u: float) -> str:
        across = shape.direction(u)
        return file.circle(shape.origin + major * across, cross(across, shape.axis), across, minor)

    return surface, about_revolved(file, shape, meridian)
