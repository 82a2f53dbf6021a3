"""What the caller knows about the primitive beforehand: parameters that are fixed or bounded.

A constraint acts on every kind that has a parameter of its name and leaves the other kinds free.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Self, TypeVar

import numpy as np

from ..errors import InvalidOptionError
from ..geometry.vectors import Array, unit, vector
from ..names import KINDS
from ..plain import worded
from ..primitives import is_angle, parameters_of
from ..primitives.primitive import Primitive
from ..words import as_given, with_unit
from .values import Triple, direction, number, positive, triple

P = TypeVar("P", bound=Primitive)

SMALLEST_ANGLE, LARGEST_ANGLE = 1e-9, math.pi / 2 - 1e-9
"""Limits [rad] of a half-angle that is fixed: at 0 the apex is lost, at pi/2 the nappe."""

TOUCHES = 1e-9
"""A number this close to its bound, relatively, is at it; so is an axis this close [rad] to its limit."""


@dataclass(frozen=True)
class Range:
    """A number from `low` to `high`, both included; fixed where they are equal.

    Examples
    --------
    >>> import primfit
    >>> primfit.Constraints(radius=primfit.Range(4.0, 6.0)).plain()
    {'radius': {'min': 4.0, 'max': 6.0}}
    """

    low: float = 0.0
    high: float = math.inf

    @property
    def fixed(self) -> bool:
        return self.low == self.high


@dataclass(frozen=True)
class Direction:
    """An axis or a normal within `max_angle` [rad] of a direction, up to sign; fixed where that is 0.

    Examples
    --------
    >>> import primfit
    >>> primfit.Constraints(axis=primfit.Direction((0, 0, 1), max_angle=0.05)).plain()
    {'axis': {'direction': [0.0, 0.0, 1.0], 'max_angle': 0.05}}
    """

    direction: Triple
    max_angle: float = 0.0

    @property
    def unit(self) -> Array:
        return unit(self.direction)


@dataclass(frozen=True)
class Constraints:
    """What is known of the primitive, in the unit of the input and in radians.

    Each acts on the kinds that have a parameter of its name, and leaves the others free.

    Attributes
    ----------
    radius : of a sphere or cylinder
    major_radius, minor_radius : of a torus
    half_angle : of a cone
    axis : of a cylinder, cone or torus
    normal : of a plane
    center : of a sphere or torus
    apex : of a cone
    point : that a plane, or the axis of a cylinder, passes through

    Raises
    ------
    InvalidOptionError
        One that cannot be meant.

    Examples
    --------
    >>> import numpy as np, primfit
    >>> azimuth, polar = np.random.default_rng(0).random((2, 300)) * np.array([[6.0], [3.0]])
    >>> points = primfit.Sphere([0, 0, 0], 2.0).surface(azimuth, polar)
    >>> known = primfit.Constraints(radius=primfit.Range(2.5, 3.0))
    >>> primfit.fit(points, kinds=["sphere"], constraints=known).active_constraints
    {'radius': 'at its lower bound 2.5'}
    >>> known == primfit.Constraints.of({"radius": {"min": 2.5, "max": 3.0}})
    True
    """

    radius: Range | None = None
    major_radius: Range | None = None
    minor_radius: Range | None = None
    half_angle: Range | None = None
    axis: Direction | None = None
    normal: Direction | None = None
    center: Triple | None = None
    apex: Triple | None = None
    point: Triple | None = None

    def __post_init__(self) -> None:
        """What was built by hand passes the same checks as what was parsed, and may be as plain."""
        for name, parse in _PARSERS.items():
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, parse(f"constraints.{name}", _plain(value)))

    @classmethod
    def of(cls, values: Self | Mapping[str, Any]) -> Self:
        """From plain values: `{"radius": {"min": 4, "max": 6}, "axis": {"direction": [0, 0, 1]}, ...}`.

        A number is `{"value": v}` or `{"min": a, "max": b}`, of which one may be left out; a direction has a
        `max_angle`, 0 by default; a position is `[x, y, z]`. Constraints are taken as they are.
        """
        if isinstance(values, cls):
            return values
        parts = _parts("constraints", values, tuple(_PARSERS))
        return cls(**{name: _PARSERS[name](f"constraints.{name}", value) for name, value in parts.items()})

    @cached_property
    def given(self) -> dict[str, Any]:
        """The constraints that are there, by name."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}

    def on(self, kind: str) -> dict[str, Any]:
        """Those that act on a kind."""
        names = parameters_of(kind)
        return {name: value for name, value in self.given.items() if name in names}

    def check_kinds(self, kinds: tuple[str, ...]) -> None:
        """Raise `InvalidOptionError` for a constraint that acts on none of the kinds."""
        for name in self.given:
            if not any(name in self.on(kind) for kind in kinds):
                having = [kind for kind in KINDS if name in self.on(kind)]
                raise InvalidOptionError(
                    f"constraints.{name} is given, but kinds allows only {', '.join(kinds)}; "
                    f"{' and '.join(having)} have it",
                    f"constraints.{name}",
                )

    def plain(self) -> dict[str, Any]:
        """The values that `of` takes."""
        return {name: _plain(value) for name, value in self.given.items()}

    def written_into(self, primitive: P) -> P:
        """The primitive, in input units, with every fixed value as it was given.

        It is there already but for the last digit: centering and scaling a position, and normalizing an axis,
        round. A cylinder's or plane's `point` stays the one closest to the centroid.
        """
        exact: dict[str, Any] = {}
        for name, value in self.on(primitive.kind).items():
            if isinstance(value, Range):
                exact[name] = min(max(getattr(primitive, name), value.low), value.high)
            elif isinstance(value, Direction) and value.max_angle == 0.0:
                exact[name] = math.copysign(1.0, value.unit @ getattr(primitive, name)) * value.unit
            elif name in ("center", "apex"):
                exact[name] = vector(value)
        return replace(primitive, **exact) if exact else primitive  # type: ignore[type-var]

    def effects(self, primitive: Primitive) -> dict[str, str]:
        """How each constraint acts on a primitive, by name, or that its kind has no such parameter."""
        acting = self.on(primitive.kind)
        return {
            name: _effect(value, getattr(primitive, name))
            if name in acting
            else f"not applicable: a {primitive.kind} has no {worded(name)}"
            for name, value in self.given.items()
        }

    def holding(self, primitive: Primitive, unit: str | None) -> dict[str, str]:
        """Those that hold a primitive where it is, in words, by name: `the radius fixed at 5 mm`."""
        found = {}
        for name, value in self.on(primitive.kind).items():
            if (held := _held(value, getattr(primitive, name))) is not None:
                how, limit = held
                towards = isinstance(value, Direction)
                what = f"direction of the {name}" if towards else worded(name)
                if limit is None:
                    found[name] = f"the {how} {what}"
                else:
                    found[name] = f"the {what} {how} {_told(limit, towards or is_angle(name), unit)}"
        return found


def _told(limit: float, angle: bool, unit: str | None) -> str:
    return with_unit(f"{math.degrees(limit):.6g}", "degrees") if angle else with_unit(f"{limit:.12g}", unit)


def _held(constraint: Any, value: Any) -> tuple[str, float | None] | None:
    """How a constraint holds a value, and at what number, if it is one; None if the value is free."""
    if isinstance(constraint, Range):
        if constraint.fixed:
            return "fixed at", constraint.low
        for bound, name in ((constraint.low, "lower"), (constraint.high, "upper")):
            if abs(value - bound) <= TOUCHES * bound < math.inf:
                return f"at its {name} bound", bound
        return None
    if isinstance(constraint, Direction) and constraint.max_angle > 0.0:
        across = np.linalg.norm(np.cross(value, constraint.unit))
        angle = math.atan2(across, abs(value @ constraint.unit))
        return (
            ("at its largest angle", constraint.max_angle)
            if angle >= constraint.max_angle - TOUCHES
            else None
        )
    return "fixed", None


def _effect(constraint: Any, value: Any) -> str:
    held = _held(constraint, value)
    if held is None:
        return "largest angle, not active" if isinstance(constraint, Direction) else "bounds, not active"
    how, limit = held
    return how if limit is None else f"{how} {limit!r}"


def _check_range(field: str, value: Range, angle: bool) -> None:
    low, high = value.low, value.high
    if low > high:
        raise InvalidOptionError(f"{field} has the min {as_given(low)} over the max {as_given(high)}", field)
    if angle and (low > LARGEST_ANGLE or high < SMALLEST_ANGLE or math.pi / 2 < high < math.inf):
        found = as_given(low) if value.fixed else f"from {as_given(low)} to {as_given(high)}"
        raise angle_error(field, found)


def angle_error(field: str, found: str) -> InvalidOptionError:
    """The complaint about a half-angle."""
    limits = f"it lies between {SMALLEST_ANGLE:g} and pi/2 - {SMALLEST_ANGLE:g}"
    return InvalidOptionError(f"{field} is {found}; {limits}", field)


def _parts(field: str, value: object, allowed: tuple[str, ...]) -> Mapping[str, Any]:
    """The entries of a mapping that are not None, all of them allowed."""
    if not isinstance(value, Mapping):
        raise InvalidOptionError(
            f"{field} is {value!r:.40}; a mapping with {', '.join(allowed)} is needed", field
        )
    for key in value:
        if key not in allowed:
            raise InvalidOptionError(f"{field} holds {key!r:.40}; allowed are {', '.join(allowed)}", field)
    return {key: part for key, part in value.items() if part is not None}


def _range(field: str, value: object) -> Range:
    parts = _parts(field, value, ("value", "min", "max"))
    numbers = {key: positive(f"{field}.{key}", part) for key, part in parts.items()}
    if not numbers or ("value" in numbers and len(numbers) > 1):
        raise InvalidOptionError(f"{field} needs either a value, or a min, a max or both", field)
    low, high = numbers.get("min", 0.0), numbers.get("max", math.inf)
    result = Range(numbers.get("value", low), numbers.get("value", high))
    _check_range(field, result, angle=is_angle(field))
    return result


def _direction(field: str, value: object) -> Direction:
    parts = _parts(field, value, ("direction", "max_angle"))
    if "direction" not in parts:
        raise InvalidOptionError(f"{field} needs a direction [x, y, z]", field)
    result = Direction(
        direction(f"{field}.direction", parts["direction"]),
        number(f"{field}.max_angle", parts.get("max_angle", 0.0)),
    )
    if not 0.0 <= result.max_angle < math.pi / 2:
        raise InvalidOptionError(
            f"{field}.max_angle is {as_given(result.max_angle)}; it lies in [0, pi/2) radians, "
            "and beyond that nothing is constrained",
            f"{field}.max_angle",
        )
    return result


_PARSERS: dict[str, Any] = {
    "radius": _range,
    "major_radius": _range,
    "minor_radius": _range,
    "half_angle": _range,
    "axis": _direction,
    "normal": _direction,
    "center": triple,
    "apex": triple,
    "point": triple,
}


def _plain(value: Any) -> Any:
    """What the parser of a constraint takes."""
    if isinstance(value, Range):
        if value.fixed:
            return {"value": value.low}
        bounds = {"min": (value.low, 0.0), "max": (value.high, math.inf)}
        return {name: bound for name, (bound, open_end) in bounds.items() if bound != open_end}
    if isinstance(value, Direction):
        return {"direction": _plain(value.direction), "max_angle": value.max_angle}
    return list(value) if isinstance(value, tuple) else value


UNCONSTRAINED = Constraints()
