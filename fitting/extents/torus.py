"""The part of a torus that holds points: an arc around the axis and an arc around the tube."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from ..geometry.vectors import Array, basis, vector
from ..primitives.torus import Torus
from . import _extents
from .values import Extents, Row, arc_in_words


@dataclass(frozen=True, eq=False)
class TorusExtents(Extents):
    """The piece of a torus between two angles about the axis and two around the tube.

    Attributes
    ----------
    reference_direction : (3,) unit vector across the axis at which angles about it are 0; they grow from it
        towards axis x reference_direction
    start_angle : where the arc about the axis begins, radians in [0, 2 pi)
    span : of that arc from there on, radians up to 2 pi
    full_turn : that arc is the whole circle; then it starts at 0
    tube_start_angle : where the arc around the tube begins, radians in [0, 2 pi): 0 where the tube is
        farthest from the axis, growing to the side that the axis points to
    tube_span : of that arc from there on, radians up to 2 pi
    tube_full_turn : that arc is the whole circle; never with a major radius below the minor one
    """

    kind: ClassVar[str] = "torus"

    reference_direction: Array
    start_angle: float
    span: float
    full_turn: bool
    tube_start_angle: float
    tube_span: float
    tube_full_turn: bool

    @classmethod
    def of(cls, primitive: Torus, points: Array, blur: float) -> Self:
        start, span, full, tube_start, tube_span, tube_full, area, coverage = _extents.torus(
            points, primitive.center, primitive.axis, primitive.major_radius, primitive.minor_radius, blur
        )
        return cls(
            area=area,
            coverage=coverage,
            reference_direction=vector(basis(primitive.axis)[0]),
            start_angle=start,
            span=span,
            full_turn=full,
            tube_start_angle=tube_start,
            tube_span=tube_span,
            tube_full_turn=tube_full,
        )

    @property
    def arcs(self) -> dict[str, float]:
        return {"about the axis": math.degrees(self.span), "around the tube": math.degrees(self.tube_span)}

    @staticmethod
    def words(of: Mapping[str, Any], unit: str | None) -> list[Row]:
        return [("around the axis", arc_in_words(of)), ("around the tube", arc_in_words(of, "tube_"))]
