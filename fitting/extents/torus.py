"""The part of a torus that holds points: an arc around the axis and an arc around the tube."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..geometry.vectors import TINY, Array
from ..primitives.torus import Torus
from .around import Around
from .spread import coverage, ends, turn
from .values import Extents, arc_in_words


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
    def of(cls, primitive: Torus, feet: Array, blur: float) -> Self:
        major, minor = primitive.major_radius, primitive.minor_radius
        seen = Around.of(feet, primitive.center, primitive.axis)
        steady = seen.steady
        start, span, full = turn(seen.angle[steady], blur / max(float(np.median(seen.rho[steady])), TINY))
        tube = np.arctan2(seen.height, seen.rho - major)
        tube_blur = blur / max(minor, TINY)
        if major > minor:
            low, tube_span, tube_full = turn(tube, tube_blur, (major - minor) / major)
        else:
            low, high = ends(tube, (tube_blur, tube_blur))
            tube_span, tube_full = high - low, False
        # The area up to an angle, over minor_radius and span.
        middle = low + tube_span / 2.0
        unwrapped = middle + np.mod(tube - middle + np.pi, 2.0 * np.pi) - np.pi
        grown = major * (unwrapped - low) + minor * (np.sin(unwrapped) - np.sin(low))
        whole = float(major * tube_span + minor * (np.sin(low + tube_span) - np.sin(low)))
        area = minor * span * whole
        length = minor * tube_span
        return cls(
            area=area,
            coverage=coverage(grown / max(whole, TINY), seen.share(start, span), length**2 / max(area, TINY)),
            reference_direction=seen.reference,
            start_angle=start,
            span=span,
            full_turn=full,
            tube_start_angle=float(np.mod(low, 2.0 * np.pi)),
            tube_span=tube_span,
            tube_full_turn=tube_full,
        )

    @property
    def arcs(self) -> dict[str, float]:
        return {"about the axis": math.degrees(self.span), "around the tube": math.degrees(self.tube_span)}

    @staticmethod
    def words(of: Mapping[str, Any]) -> list[str]:
        return [f"around the axis {arc_in_words(of)}", f"around the tube {arc_in_words(of, 'tube_')}"]
