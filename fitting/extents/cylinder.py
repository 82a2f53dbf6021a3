"""The part of a cylinder that holds points: between two heights and two angles."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from ..geometry.vectors import Array, basis, vector
from ..primitives.cylinder import Cylinder
from . import _extents
from .values import Extents, Length, Place, Row, arc_in_words, long


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
    def of(cls, primitive: Cylinder, points: Array, blur: float) -> Self:
        low, high, start, span, full, coverage = _extents.cylinder(
            points, primitive.point, primitive.axis, primitive.radius, blur
        )
        return cls(
            area=span * primitive.radius * (high - low),
            coverage=coverage,
            start=primitive.point + low * primitive.axis,
            end=primitive.point + high * primitive.axis,
            length=high - low,
            reference_direction=vector(basis(primitive.axis)[0]),
            start_angle=start,
            span=span,
            full_turn=full,
        )

    @property
    def arcs(self) -> dict[str, float]:
        return {"about the axis": math.degrees(self.span)}

    @staticmethod
    def words(of: Mapping[str, Any], unit: str | None) -> list[Row]:
        return [("length", long(of["length"], unit)), ("around the axis", arc_in_words(of))]
