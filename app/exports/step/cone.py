"""A cone in STEP, which starts from its circle at the lower end; its meridians are lines."""

from primfit.fitting.primitives.cone import Cone

from ..drawing.revolved import Revolved
from . import Faces
from .bounds import about_ruled
from .file import File, real


def faces(file: File, primitive: Cone, shape: Revolved) -> Faces:
    radius, height = shape.place(shape.v.start)
    where = file.placement(shape.origin + height * shape.axis, shape.axis, shape.reference)
    surface = file.add(f"CONICAL_SURFACE('',{where},{real(radius)},{real(primitive.half_angle)})")
    return surface, about_ruled(file, shape)
