"""The part of a cone that holds points: between two heights from the apex and two angles."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from ..geometry.vectors import Array, basis, vector
from ..primitives.cone import Cone
from ..words import between
from . import _extents
from .values import Extents, Length, Place, Row, arc_in_words, long


@dataclass(frozen=True, eq=False)
class ConeExtents(Extents):
    """The piece of a cone between two heights from the apex and two angles.

    Attributes
    ----------
    start_height : along the axis from the apex to the nearer end
    end_height : along the axis from the apex to the farther end
    start_radius : of the circle at the nearer end
    end_radius : of the circle at the farther end
    start : (3,) center of the nearer end, on the axis
    end : (3,) center of the farther end, on the axis
    apex_inside : the surface reaches the apex, which is the start then; `start_height` and `start_radius`
        are 0
    reference_direction : (3,) unit vector across the axis at which angles are 0; they grow from it towards
        axis x reference_direction
    start_angle : where the arc begins, radians in [0, 2 pi)
    span : of the arc from there on, radians up to 2 pi
    full_turn : the arc is the whole circle; then it starts at 0
    """

    kind: ClassVar[str] = "cone"

    start_height: Length
    end_height: Length
    start_radius: Length
    end_radius: Length
    start: Place
    end: Place
    apex_inside: bool
    reference_direction: Array
    start_angle: float
    span: float
    full_turn: bool

    @classmethod
    def of(cls, primitive: Cone, points: Array, blur: float) -> Self:
        low, high, start, span, full, coverage = _extents.cone(
            points, primitive.apex, primitive.axis, primitive.half_angle, blur
        )
        tangent, cosine = math.tan(primitive.half_angle), math.cos(primitive.half_angle)
        return cls(
            area=span * tangent * (low + high) / 2.0 * (high - low) / cosine,
            coverage=coverage,
            start_height=low,
            end_height=high,
            start_radius=low * tangent,
            end_radius=high * tangent,
            start=primitive.apex + low * primitive.axis,
            end=primitive.apex + high * primitive.axis,
            apex_inside=low == 0.0,
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
        height = long(of["end_height"] - of["start_height"], unit)
        ends = between(2.0 * of["start_radius"], 2.0 * of["end_radius"], unit)
        return [
            ("length", f"{height}, diameter {ends}"),
            ("from the apex", between(of["start_height"], of["end_height"], unit)),
            ("around the axis", arc_in_words(of)),
        ]
