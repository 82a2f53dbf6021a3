"""A plane in STEP: a face for each of its pieces, with a bound for each ring."""

from primfit.fitting.geometry.vectors import basis
from primfit.fitting.primitives.plane import Plane

from ..drawing.flat import Flat
from . import Faces
from .bounds import bound, outlined
from .file import File


def faces(file: File, primitive: Plane, shape: Flat) -> Faces:
    where = file.placement(primitive.point, primitive.normal, basis(primitive.normal)[0])
    surface = file.add(f"PLANE('',{where})")
    return surface, [
        [bound(file, outlined(file, ring), outer=i == 0) for i, ring in enumerate(rings)]
        for rings in shape.rings
    ]
