"""The part of a cylinder that holds points: between two heights and two angles."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from ..geometry.vectors import TINY, Array
from ..primitives.cylinder import Cylinder
from .around import Around
from .spread import coverage, ends, turn
from .values import Extents, Length, Place, arc_in_words


@dataclass(frozen=True, eq=False)
class CylinderExtents(Extents):
    """The piece of a cylinder between two heights and two angles.

    Attributes
    ----------
    start : (3,) end point of the axis
    end : (3,) end point of the axis, in its direction from the start
    length : between the end points
    reference_direction : (3,) unit vector across the axis at which angles are 0; they grow from it towards
        axis x reference_direction
    start_angle : where the arc begins, radians in [0, 2 pi)
    span : of the arc from there on, radians up to 2 pi
    full_turn : the arc is the whole circle; then it starts at 0
    """

    kind: ClassVar[str] = "cylinder"

    start: Place
    end: Place
    length: Length
    reference_direction: Array
    start_angle: float
    span: float
    full_turn: bool

    @classmethod
    def of(cls, primitive: Cylinder, feet: Array, blur: float) -> Self:
        seen = Around.of(feet, primitive.point, primitive.axis)
        low, high = ends(seen.height, (blur, blur))
        start, span, full = turn(seen.angle, blur / primitive.radius)
        tall, arc = high - low, span * primitive.radius
        along = (seen.height - low) / max(tall, TINY)
        return cls(
            area=arc * tall,
            coverage=coverage(along, seen.share(start, span), tall / max(arc, TINY)),
            start=primitive.point + low * primitive.axis,
            end=primitive.point + high * primitive.axis,
            length=tall,
            reference_direction=seen.reference,
            start_angle=start,
            span=span,
            full_turn=full,
        )

    @property
    def arcs(self) -> dict[str, float]:
        return {"about the axis": math.degrees(self.span)}

    @staticmethod
    def words(of: Mapping[str, Any]) -> list[str]:
        return [f"length {of['length']:.6g}", arc_in_words(of)]
