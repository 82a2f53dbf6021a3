"""What extents are made of: lengths, areas, points and directions that go from the frame to input units."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated, Any, ClassVar, Self, get_type_hints

from ..cloud.frame import Frame
from ..equality import ByValue
from ..geometry.vectors import Array
from ..plain import plain
from ..words import figure


def _length(value: float, frame: Frame) -> float:
    return frame.scale * value


def _area(value: float, frame: Frame) -> float:
    return frame.scale**2 * value


def _place(value: Array, frame: Frame) -> Array:
    return frame.center + frame.scale * value


def _places(value: tuple[tuple[Array, ...], ...], frame: Frame) -> tuple[tuple[Array, ...], ...]:
    return tuple(tuple(_place(ring, frame) for ring in rings) for rings in value)


Row = tuple[str, str]
"""A label and the text beside it."""

EXTENT_DIGITS = 5
"""Digits of lengths of extents: their ends are known to about the spacing of the points."""

Length = Annotated[float, _length]
Area = Annotated[float, _area]
Place = Annotated[Array, _place]
"""A point (3,), or several (K, 3). Directions and angles are the same in the frame and in input units."""

Places = Annotated[tuple[tuple[Array, ...], ...], _places]
"""Rings (K, 3) of points, by the piece that they bound."""


@dataclass(frozen=True, eq=False)
class Extents(ByValue):
    """What the extents of all kinds have in common; `fitting/extents/spread.h` counts the coverage.

    Attributes
    ----------
    area : of the trimmed surface
    coverage : share of that area near which there are points
    """

    kind: ClassVar[str]

    area: Area
    coverage: float

    @classmethod
    def of(cls, primitive: Any, points: Array, blur: float) -> Self | None:
        """Of a primitive of its kind, from points (N, 3) near it and the scale of their noise.

        What counts of the points are their feet on the surface. None where these span no surface.
        """
        raise NotImplementedError

    def restored(self, frame: Frame) -> Self:
        """The same in the units of the input."""
        units: dict[str, Callable[..., Any]] = _units(type(self))  # type: ignore[arg-type]
        return replace(self, **{name: to(getattr(self, name), frame) for name, to in units.items()})

    @property
    def arcs(self) -> dict[str, float]:
        """Degrees that the points cover of a curved surface, by how they are counted."""
        return {}

    @staticmethod
    def words(of: Mapping[str, Any], unit: str | None) -> list[Row]:
        """Plain values, as `values` gives them, as rows of text; the first is what is asked for first."""
        raise NotImplementedError

    def values(self) -> dict[str, Any]:
        """Plain values for the answer, `kind` first."""
        return {"kind": self.kind, **plain(self)}


@cache
def _units(kind: type[Extents]) -> dict[str, Callable[..., Any]]:
    """How the values of a kind that have a unit go from the frame to input units, by their names."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items() if hasattr(hint, "__metadata__")}


def arc_in_words(of: Mapping[str, Any], prefix: str = "") -> str:
    """An arc of plain values, whose names have the prefix."""
    if of[f"{prefix}full_turn"]:
        return "a full turn"
    start, span = (math.degrees(of[f"{prefix}{name}"]) for name in ("start_angle", "span"))
    return f"{span:.1f} degrees, beginning at {start:.1f}"


def long(length: float, unit: str | None) -> str:
    """A length of extents in words."""
    return figure(length, unit, EXTENT_DIGITS)


def large(area: float, unit: str | None) -> str:
    """An area of extents in words."""
    return figure(area, unit and f"{unit}\u00b2", EXTENT_DIGITS)
