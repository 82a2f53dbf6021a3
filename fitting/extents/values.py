"""What extents are made of: lengths, areas, points and directions that go from the frame to input units."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar, Self, get_type_hints

from ..cloud.frame import Frame
from ..geometry.vectors import Array
from ..plain import plain


def _length(value: float, frame: Frame) -> float:
    return frame.scale * value


def _area(value: float, frame: Frame) -> float:
    return frame.scale**2 * value


def _place(value: Array, frame: Frame) -> Array:
    return frame.center + frame.scale * value


def _places(value: tuple[tuple[Array, ...], ...], frame: Frame) -> tuple[tuple[Array, ...], ...]:
    return tuple(tuple(_place(ring, frame) for ring in rings) for rings in value)


Length = Annotated[float, _length]
Area = Annotated[float, _area]
Place = Annotated[Array, _place]
"""A point (3,), or several (K, 3). Directions and angles are the same in the frame and in input units."""

Places = Annotated[tuple[tuple[Array, ...], ...], _places]
"""Rings (K, 3) of points, by the piece that they bound."""


@dataclass(frozen=True, eq=False)
class Extents:
    """What the extents of all kinds have in common; `fitting.extents.spread.coverage` counts the coverage.

    Attributes
    ----------
    area : of the trimmed surface
    coverage : share of that area near which there are points
    """

    kind: ClassVar[str]

    area: Area
    coverage: float

    @classmethod
    def of(cls, primitive: Any, feet: Array, blur: float) -> Self:
        """Of a primitive of its kind, from feet (N, 3) of points on it and the scale of their noise."""
        raise NotImplementedError

    def restored(self, frame: Frame) -> Self:
        """The same in the units of the input."""
        hints = get_type_hints(type(self), include_extras=True)
        units = {name: hint.__metadata__[0] for name, hint in hints.items() if hasattr(hint, "__metadata__")}
        return replace(self, **{name: to(getattr(self, name), frame) for name, to in units.items()})

    @property
    def arcs(self) -> dict[str, float]:
        """Degrees that the points cover of a curved surface, by how they are counted."""
        return {}

    @staticmethod
    def words(of: Mapping[str, Any]) -> list[str]:
        """Plain values, as `values` gives them, in some lines of text."""
        raise NotImplementedError

    def values(self) -> dict[str, Any]:
        """Plain values for the answer, `kind` first."""
        return {"kind": self.kind, **plain(self)}


def arc_in_words(of: Mapping[str, Any], prefix: str = "") -> str:
    """An arc of plain values, whose names have the prefix."""
    if of[f"{prefix}full_turn"]:
        return "a full turn"
    start, span = (math.degrees(of[f"{prefix}{name}"]) for name in ("start_angle", "span"))
    return f"{span:.5g} degrees, from {start:.5g}"
