"""A primitive as the numbers that regression networks learn: direction, position and sizes, eight in a row.

The row holds the direction (3), the position (3) and two sizes; a sphere's direction and sizes that a kind
does not have are 0 and never looked at. What the paper leaves open is chosen here: the point of a plane and
of a cylinder's axis is the one closest to the origin, which normalization puts at the centroid of the cloud.
A direction's sign is as it is drawn; who learns from it says what becomes of that.
"""

import numpy as np

from primfit.fitting.geometry.vectors import Array
from primfit.fitting.primitives import PRIMITIVES
from primfit.fitting.primitives.primitive import Primitive

DIRECTION = slice(0, 3)
POSITION = slice(3, 6)
SIZES = slice(6, 8)
ROW = 8

LAYOUT: dict[str, tuple[str | None, str, tuple[str, ...]]] = {
    "plane": ("normal", "point", ()),
    "sphere": (None, "center", ("radius",)),
    "cylinder": ("axis", "point", ("radius",)),
    "cone": ("axis", "apex", ("half_angle",)),
    "torus": ("axis", "center", ("major_radius", "minor_radius")),
}
"""Kind -> the names of its direction, its position and its sizes."""

LEAST = 1e-3
"""A radius, in the unit sphere, and half-angle [rad] are at least this, a half-angle as far from pi/2."""


def to_numbers(primitive: Primitive) -> Array:
    """The row (8,) of a primitive in the normalized frame."""
    direction, position, sizes = LAYOUT[primitive.kind]
    row = np.zeros(ROW)
    row[POSITION] = getattr(primitive.canonical(np.zeros(3)), position)
    if direction is not None:
        row[DIRECTION] = getattr(primitive, direction)
    row[6 : 6 + len(sizes)] = [getattr(primitive, name) for name in sizes]
    return row


def from_numbers(kind: str, row: Array) -> Primitive:
    """The primitive of a row (8,), whatever a network says: sizes are brought into their range.

    A direction of no length becomes z. The axis of a cone is turned to where the origin is, which is the
    centroid of the cloud: some networks learn axes without their sign.
    """
    direction, position, sizes = LAYOUT[kind]
    values: dict[str, object] = {position: row[POSITION]}
    if direction is not None:
        values[direction] = row[DIRECTION] if row[DIRECTION].any() else np.array([0.0, 0.0, 1.0])
    if kind == "cone" and row[DIRECTION] @ row[POSITION] > 0.0:
        values["axis"] = -row[DIRECTION]
    for name, size in zip(sizes, row[SIZES], strict=False):
        most = np.pi / 2 - LEAST if name == "half_angle" else np.inf
        values[name] = float(np.clip(abs(size), LEAST, most))
    return PRIMITIVES[kind](**values)
