"""The part of a plane that holds points: their outlines, convex and concave, and the smallest rectangle."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..geometry.vectors import Array, basis, vector
from ..primitives.plane import Plane
from . import _extents
from .outline import Edge, Rings, tidied
from .values import Area, Extents, Length, Place, Places, Row, large, long


@dataclass(frozen=True, eq=False)
class PlaneExtents(Extents):
    """The outlines of the points on a plane, and the rectangle of least area about them.

    `area` and `coverage` are those of the convex outline.

    Attributes
    ----------
    outline : (K, 3) corners of the convex outline, counter-clockwise about the normal
    concave_outline : the pieces that points fill, the largest first; of each the outer ring (K, 3),
        counter-clockwise about the normal, then the rings of its holes, clockwise; at most 1000 corners. The
        convex outline alone where the points fill that
    concave_area : inside the concave outline, without the holes
    center : (3,) of the rectangle of least area about the outline
    length : of the longer side of the rectangle
    width : of the shorter side
    length_direction : (3,) unit vector along its longer side
    width_direction : (3,) unit vector along its shorter side
    """

    kind: ClassVar[str] = "plane"

    outline: Place
    concave_outline: Places
    concave_area: Area
    center: Place
    length: Length
    width: Length
    length_direction: Array
    width_direction: Array

    @classmethod
    def of(cls, primitive: Plane, points: Array, blur: float) -> Self | None:
        point, frame = primitive.point, np.array(basis(primitive.normal))
        found = _extents.plane(points, point, frame[0], frame[1], blur)
        if found is None:
            return None
        corners, area, coverage, rectangle, along, near = found
        outline = point + corners @ frame
        pieces, hollow = tidied(near[0], Edge(*near[1:], blur)) if near else ((), 0.0)
        even = np.array([along, [-along[1], along[0]]]) @ frame
        filled = not 0.0 < hollow < area
        sides, middle, size = rectangle[:2] @ frame, rectangle[2] @ frame, rectangle[3].tolist()
        return cls(
            area=area,
            coverage=coverage,
            outline=outline,
            concave_outline=((outline,),) if filled else _placed(pieces, point, even),
            concave_area=area if filled else hollow,
            center=point + middle,
            length=size[0],
            width=size[1],
            length_direction=vector(sides[0]),
            width_direction=vector(sides[1]),
        )

    @staticmethod
    def words(of: Mapping[str, Any], unit: str | None) -> list[Row]:
        concave = f"{_pieces(of['concave_outline'])}, area {large(of['concave_area'], unit)}"
        return [
            ("size", f"{long(of['length'], None)} x {long(of['width'], unit)}"),
            ("outline", f"{len(of['outline'])} corners, area {large(of['area'], unit)}"),
            ("concave outline", concave),
        ]


def _placed(pieces: tuple[Rings, ...], point: Array, frame: Array) -> tuple[tuple[Array, ...], ...]:
    return tuple(tuple(point + ring @ frame for ring in rings) for rings in pieces)


def _pieces(outline: list[list[Any]]) -> str:
    holes = sum(len(rings) - 1 for rings in outline)
    parts = "one piece" if len(outline) == 1 else f"{len(outline)} pieces"
    return parts if holes == 0 else f"{parts} with {'a hole' if holes == 1 else f'{holes} holes'}"
