"""The part of a cone that holds points: between two heights from the apex and two angles."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..geometry.vectors import TINY, Array
from ..primitives.cone import Cone
from .around import Around
from .spread import CHANCE, coverage, ends, turn
from .values import Extents, Length, Place, arc_in_words


@dataclass(frozen=True, eq=False)
class ConeExtents(Extents):
    """The piece of a cone between two heights from the apex and two angles.

    Attributes
    ----------
    start_height : along the axis from the apex to the nearer end
    end_height : along the axis from the apex to the farther end
    start_radius : of the circle at the nearer end
    end_radius : of the circle at the farther end
    start : (3,) centre of the nearer end, on the axis
    end : (3,) centre of the farther end, on the axis
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
    def of(cls, primitive: Cone, feet: Array, blur: float) -> Self:
        seen = Around.of(feet, primitive.apex, primitive.axis)
        height = np.maximum(seen.height, 0.0)
        # Squares of heights are areas: along them points are evenly dense.
        steepness = 2.0 * blur * np.cos(primitive.half_angle)
        low2, high2 = ends(height**2, (steepness * height.min(), steepness * height.max()))
        inside = low2 * len(feet) <= CHANCE * (high2 - low2)
        low, high = 0.0 if inside else float(np.sqrt(low2)), float(np.sqrt(high2))
        steady = seen.steady
        start, span, full = turn(seen.angle[steady], blur / max(float(np.median(seen.rho[steady])), TINY))
        tangent = float(np.tan(primitive.half_angle))
        arc, slant = span * tangent * (low + high) / 2.0, (high - low) / np.cos(primitive.half_angle)
        along = (height**2 - low**2) / max(high**2 - low**2, TINY)
        return cls(
            area=float(arc * slant),
            coverage=coverage(along, seen.share(start, span), slant / max(arc, TINY)),
            start_height=low,
            end_height=high,
            start_radius=low * tangent,
            end_radius=high * tangent,
            start=primitive.apex + low * primitive.axis,
            end=primitive.apex + high * primitive.axis,
            apex_inside=bool(inside),
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
        return [
            f"height {of['start_height']:.6g} to {of['end_height']:.6g} from the apex",
            f"radius {of['start_radius']:.6g} to {of['end_radius']:.6g}",
            arc_in_words(of),
        ]
