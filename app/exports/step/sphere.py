"""A sphere in STEP; its meridians are circles about the center."""

from primfit.fitting.geometry.vectors import cross
from primfit.fitting.primitives.sphere import Sphere

from ..drawing.revolved import Revolved
from . import Faces
from .bounds import about_revolved
from .file import File, real


def faces(file: File, primitive: Sphere, shape: Revolved) -> Faces:
    where = file.placement(shape.origin, shape.axis, shape.reference)
    surface = file.add(f"SPHERICAL_SURFACE('',{where},{real(primitive.radius)})")

    def meridian(u: float) -> str:
        across = shape.direction(u)
        return file.circle(shape.origin, cross(across, shape.axis), across, primitive.radius)

    return surface, about_revolved(file, shape, meridian)
