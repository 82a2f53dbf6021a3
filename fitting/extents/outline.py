"""The concave outline of points in a plane: pieces, notches and holes that are larger than chance leaves.

The triangles of the points' Delaunay triangulation are kept whose longest edge is not over what chance makes
of the local spacing; what they cover is the outline (Edelsbrunner, Kirkpatrick, Seidel, "On the shape of a
set of points in the plane", IEEE Trans. Inf. Theory 29(4), 1983, with a length that follows the density).
Points in the midst of others need no triangles, so only those near the edges are triangulated. That is
compiled (`flat.h`); here corners are thinned out, and it is moved to where the edge is on the average.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..geometry.vectors import Array
from . import _extents

Rings = tuple[Array, ...]
"""A piece: its outer ring (K, 2), counter-clockwise, and its holes, clockwise; no corner is repeated."""

BLURRED = 0.4
"""Noise carries points over a sharp edge: as many as there are in this many of its standard deviations."""

SMALLEST = 20
"""Pieces and holes of less than the area of so many points are none."""

INWARD = 0.29
"""The edge of evenly random points lies so many spacings within what they were drawn from, on the average."""

BENDS = 0.5
"""The outline may move by so many spacings while corners are left out."""

MOST_CORNERS = 1000
COARSE = 2.0
"""For fewer corners the outline may move farther; over so many spacings, the smaller rings are left out."""


@dataclass(frozen=True, eq=False)
class Edge:
    """What is known of points near an edge.

    Attributes
    ----------
    spacing : mean one of all the points
    points : (E, 2) those that are looked at for noise
    blur : standard deviation of the noise
    """

    spacing: float
    points: Array
    blur: float


def tidied(pieces: Sequence[Sequence[Array]], edge: Edge) -> tuple[tuple[Rings, ...], float]:
    """With fewer corners, and moved to where the edge is on the average of random points and of noise.

    Returns
    -------
    the pieces, the largest first, and the area inside
    """
    import shapely

    shape = shapely.MultiPolygon([(outer, holes) for outer, *holes in pieces])
    tolerance = BENDS * edge.spacing
    plain = shapely.simplify(shape, tolerance)
    move = (shape.area - plain.area) / plain.length + _outward(shape, edge)
    smallest = SMALLEST * edge.spacing**2
    tidy = _large(shapely.get_parts(shapely.buffer(plain, move, join_style="mitre")), smallest)
    while shapely.get_num_coordinates(tidy) > MOST_CORNERS:
        tolerance *= 2.0
        tidy = shapely.simplify(tidy, tolerance)
        if tolerance > COARSE * edge.spacing:
            parts = shapely.get_parts(tidy)
            areas = [_area(ring) for part in parts for ring in (part.exterior, *part.interiors)]
            tidy = _large(parts, float(np.median(areas)))
    return _pieces(tidy), float(tidy.area)


def _large(parts: Iterable[Any], smallest: float) -> Any:
    """The polygons as one shape, without pieces and holes whose rings are around less than an area."""
    import shapely

    pieces = [piece for piece in parts if _area(piece.exterior) >= smallest]
    filled = [
        shapely.Polygon(piece.exterior, [ring for ring in piece.interiors if _area(ring) >= smallest])
        for piece in pieces
    ]
    return shapely.MultiPolygon(filled)


def _area(ring: Any) -> float:
    import shapely

    return float(shapely.Polygon(ring).area)


def _outward(shape: Any, edge: Edge) -> float:
    """How far the edge is from the average one: within it for lack of points, beyond it for noise.

    Rows of a grid, along which corners are as near to each other as points are, lie on the edge itself.
    """
    import shapely

    corners = shapely.get_num_coordinates(shape)
    spacing = edge.spacing
    short = INWARD * spacing * min(max(shape.length / (corners * spacing) - 1.0, 0.0), 1.0)
    over = int(BLURRED * edge.blur * shape.length / spacing**2)
    if over < corners:  # which are that many points on the outline
        return short * (1.0 - over / corners)
    depths = _extents.depths(edge.points, _edges(shape))
    over = min(over, len(depths) - 1)
    return -max(float(np.partition(depths, over)[over]), 0.0)


def _edges(shape: Any) -> Array:
    """Both ends (E, 4) of all edges."""
    rings = [np.array(ring.coords) for part in shape.geoms for ring in (part.exterior, *part.interiors)]
    return np.concatenate([np.hstack([ring[:-1], ring[1:]]) for ring in rings])


def _pieces(shape: Any) -> tuple[Rings, ...]:
    import shapely

    parts = shapely.orient_polygons(shapely.get_parts(shape), exterior_cw=False)
    return tuple(
        tuple(np.array(ring.coords)[:-1] for ring in (part.exterior, *part.interiors))
        for part in sorted(parts, key=lambda part: -part.area)
    )
