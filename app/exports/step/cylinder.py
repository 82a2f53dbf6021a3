"""A cylinder in STEP; its meridians are lines."""

from primfit.fitting.primitives.cylinder import Cylinder

from ..drawing.revolved import Revolved
from . import Faces
from .bounds import about_ruled
from .file import File, real


def faces(file: File, primitive: Cylinder, shape: Revolved) -> Faces:
    where = file.placement(shape.origin, shape.axis, shape.reference)
    surface = file.add(f"CYLINDRICAL_SURFACE('',{where},{real(primitive.radius)})")
    return surface, about_ruled(file, shape)
