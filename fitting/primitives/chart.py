"""The numbers of an answer by name, and how they follow a step in the minimal coordinates of `linearize`."""

from collections.abc import Callable
from dataclasses import fields

import numpy as np

from ..geometry.vectors import Array, basis
from . import PRIMITIVES, Primitive

DIRECTIONS = ("axis", "normal")
SIZES = ("radius", "half_angle", "major_radius", "minor_radius")
VECTORS = (*DIRECTIONS, "center", "apex", "point")


def names_of(kind: str) -> tuple[str, ...]:
    """The numbers of a kind in the order of its answer, vectors by component: `axis.x`, `radius`."""
    names: list[str] = []
    for field in fields(PRIMITIVES[kind]):  # type: ignore[arg-type]
        names += [f"{field.name}.{letter}" for letter in "xyz"] if field.name in VECTORS else [field.name]
    return tuple(names)


def worded(name: str) -> str:
    """A name of the answer in words: `major_radius`, `half_angle`, `axis.x`, `no_fit`."""
    return name.replace("half_angle", "half-angle").replace("_", " ").replace(".", " ")


def is_length(name: str) -> bool:
    """Whether a number carries the unit of the points; directions and angles do not."""
    return name != "half_angle" and name.split(".")[0] not in DIRECTIONS


def values_of(primitive: Primitive) -> Array:
    """The numbers of a primitive in the order of `names_of`."""
    numbers: list[float] = []
    for field in fields(primitive):  # type: ignore[arg-type]
        value = getattr(primitive, field.name)
        numbers += value.tolist() if field.name in VECTORS else [value]
    return np.array(numbers)


def derivative(primitive: Primitive, center: Array) -> Array:
    """Derivatives (P, dof) of the numbers by a step, in the frame of the steps.

    The `point` of a plane or a cylinder is the one closest to `center`. `fitting.solver._descent` says how a
    step moves a row; here t is a tilt, s a shift, f the foot of the origin:

    plane     n' = n + t, p = c - (c . n - h) n with h = f . n
    cylinder  a' = a + t, f' = f + s - (t . f) a, p = f + ((c - f) . a) a, where (t . f) a drops out
    cone      apex = f + s - offset / sin(angle) (a + t)
    """
    return _DERIVATIVES[primitive.kind](primitive.row(), center)


def _plane(row: Array, center: Array) -> Array:
    normal, height = row[:3], row[3:6] @ row[:3]
    result = np.zeros((6, 3))
    tilts = np.stack(basis(normal), axis=1)
    result[:3, :2] = tilts
    result[3:, :2] = (height - center @ normal) * tilts - np.outer(normal, center @ tilts)
    result[3:, 2] = normal
    return result


def _sphere(row: Array, center: Array) -> Array:
    return np.eye(4)


def _cylinder(row: Array, center: Array) -> Array:
    axis, relative = row[:3], center - row[3:6]
    across = np.stack(basis(axis), axis=1)
    result = np.zeros((7, 5))
    result[:3, :2] = across
    result[3:6, :2] = np.outer(axis, relative @ across) + (relative @ axis) * across
    result[3:6, 2:4] = across
    result[6, 4] = 1.0
    return result


def _cone(row: Array, center: Array) -> Array:
    axis, angle, offset = row[:3], row[6], row[8]
    across, sine = np.stack(basis(axis), axis=1), np.sin(angle)
    result = np.zeros((7, 6))
    result[:3, :2] = -offset / sine * across
    result[:3, 2:4] = across
    result[:3, 4] = offset * np.cos(angle) / sine**2 * axis
    result[:3, 5] = -axis / sine
    result[3:6, :2] = across
    result[6, 4] = 1.0
    return result


def _torus(row: Array, center: Array) -> Array:
    axis = row[:3]
    across = np.stack(basis(axis), axis=1)
    result = np.zeros((8, 7))
    result[:3, 2:4], result[:3, 4] = across, axis
    result[3:6, :2] = across
    result[6, 5] = result[7, 6] = 1.0
    return result


_DERIVATIVES: dict[str, Callable[[Array, Array], Array]] = {
    "plane": _plane,
    "sphere": _sphere,
    "cylinder": _cylinder,
    "cone": _cone,
    "torus": _torus,
}
