"""The table of the primitives, and the numbers of an answer by name."""

from dataclasses import fields
from functools import cache
from importlib import import_module

import numpy as np

from ..geometry.vectors import Array
from ..names import KINDS
from ..plain import field_names
from .primitive import Primitive

PRIMITIVES: dict[str, type[Primitive]] = {
    kind: getattr(import_module(f".{kind}", __name__), kind.capitalize()) for kind in KINDS
}

_TYPES = {field.name: field.type for kind in KINDS for field in fields(PRIMITIVES[kind])}  # type: ignore[arg-type]
SIZES = tuple(name for name, of in _TYPES.items() if of is float)
VECTORS = tuple(name for name in _TYPES if name not in SIZES)
DIRECTIONS = tuple(name for name in VECTORS if name.endswith(("axis", "normal")))
"""Parameters of any kind: numbers, vectors, and those of them that are unit vectors."""


def parameters(primitive: Primitive) -> dict[str, str | float | list[float]]:
    """The public parameters as plain values, `kind` first.

    Examples
    --------
    >>> import primfit
    >>> primfit.parameters(primfit.Sphere(center=[0, 0, 0], radius=2.0))
    {'kind': 'sphere', 'center': [0.0, 0.0, 0.0], 'radius': 2.0}
    """
    values: dict[str, str | float | list[float]] = {"kind": primitive.kind}
    for name in field_names(type(primitive)):
        value = getattr(primitive, name)
        values[name] = value if isinstance(value, float) else value.tolist()
    return values


@cache
def parameters_of(kind: str) -> tuple[str, ...]:
    """The names of a kind's parameters, in the order of its answer."""
    return field_names(PRIMITIVES[kind])


@cache
def direction_of(kind: str) -> str | None:
    """The name of its axis or normal, or None where it has none."""
    return next((name for name in parameters_of(kind) if name in DIRECTIONS), None)


@cache
def names_of(kind: str) -> tuple[str, ...]:
    """The numbers of a kind in the order of its answer, vectors by component: `axis.x`, `radius`."""
    names: list[str] = []
    for name in parameters_of(kind):
        names += [f"{name}.{letter}" for letter in "xyz"] if name in VECTORS else [name]
    return tuple(names)


def is_angle(name: str) -> bool:
    """Whether a number is an angle [rad]."""
    return name.endswith("angle")


def is_length(name: str) -> bool:
    """Whether a number carries the unit of the points; directions and angles do not."""
    return not is_angle(name) and name.split(".")[0] not in DIRECTIONS


def values_of(primitive: Primitive) -> Array:
    """The numbers of a primitive in the order of `names_of`."""
    numbers: list[float] = []
    for name in parameters_of(primitive.kind):
        value = getattr(primitive, name)
        numbers += value.tolist() if name in VECTORS else [value]
    return np.array(numbers)
