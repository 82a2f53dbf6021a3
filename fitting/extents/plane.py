"""The part of a plane that holds points: their outlines, convex and concave, and the smallest rectangle."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from ..geometry.vectors import Array, basis, vector
from ..primitives.plane import Plane
from .grid import Grid
from .outline import concave
from .spread import POINTS_A_CELL, ends
from .values import Area, Extents, Length, Place, Places

NEIGHBOURS = 6
REACH = 3.0
"""A corner of the outline is stray that has fewer than so many points within so many mean spacings."""

MOST_STRAY = 20
"""At most one in so many points is dropped as stray."""

ROUNDED = 0.5
"""An outline that turns back by less than this is straight but for rounding [rad]."""

OCTAGON = np.stack([np.cos(np.arange(8) * np.pi / 4.0), np.sin(np.arange(8) * np.pi / 4.0)], axis=1)


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
    def of(cls, primitive: Plane, feet: Array, blur: float) -> Self:
        frame = np.array(basis(primitive.normal))
        flat = (feet - primitive.point) @ frame.T
        kept, corners = _outlined(flat)
        even = _turned(_rectangle(corners)[0][0])
        ended = _between_ends(kept, even, blur)
        corners = ended[_hull(ended)]
        area = _area(corners)
        axes, middle, size = _rectangle(corners)
        pieces = concave(kept @ even.T, corners @ even.T, blur)
        hollow = sum((_area(ring) for rings in pieces for ring in rings), 0.0)
        if not 0.0 < hollow < area:
            pieces, hollow = ((corners @ even.T,),), area
        return cls(
            area=area,
            coverage=_coverage(ended @ axes.T, corners @ axes.T),
            outline=primitive.point + corners @ frame,
            concave_outline=tuple(
                tuple(primitive.point + ring @ even @ frame for ring in rings) for rings in pieces
            ),
            concave_area=hollow,
            center=primitive.point + middle @ frame,
            length=float(size[0]),
            width=float(size[1]),
            length_direction=vector(axes[0] @ frame),
            width_direction=vector(axes[1] @ frame),
        )

    @staticmethod
    def words(of: Mapping[str, Any]) -> list[str]:
        return [
            f"{of['length']:.6g} x {of['width']:.6g}, an outline of {len(of['outline'])} corners",
            f"a concave outline of {_pieces(of['concave_outline'])}, area {of['concave_area']:.6g}",
        ]


def _outlined(flat: Array) -> tuple[Array, Array]:
    """The points (M, 2) that are not stray, and the corners (K, 2) of their convex outline."""
    from scipy.spatial import cKDTree

    kept, dropped = flat, 0
    while True:
        corners = _hull(kept)
        reach = REACH * np.sqrt(_area(kept[corners]) / len(kept))
        tree = cKDTree(kept, balanced_tree=False, compact_nodes=False)
        farthest = tree.query(kept[corners], k=[NEIGHBOURS + 1])[0][:, 0]  # the first is the corner itself
        stray = corners[farthest > reach]
        dropped += len(stray)
        if len(stray) == 0 or dropped > len(flat) // MOST_STRAY:
            return kept, kept[corners]
        kept = np.delete(kept, stray, axis=0)


def _hull(points: Array) -> np.ndarray:
    """Numbers of the corners of the convex hull, counter-clockwise.

    Points inside the octagon of the outermost ones are left out before, as Akl and Toussaint do ("A fast
    convex hull algorithm", Information Processing Letters 7(5), 1978).
    """
    from scipy.spatial import ConvexHull

    outermost = (points @ OCTAGON.T).argmax(axis=0)
    octagon = points[outermost]
    along = _following(octagon) - octagon
    inward = np.stack([-along[:, 1], along[:, 0]], axis=1)[along.any(axis=1)]
    offset = np.einsum("ki,ki->k", octagon[along.any(axis=1)], inward)
    inside = np.all(points @ inward.T > offset, axis=1) & along.any()
    inside[outermost] = False  # whatever rounding says
    outer = np.flatnonzero(~inside)
    return np.asarray(outer[ConvexHull(points[outer]).vertices])


def _between_ends(points: Array, directions: Array, blur: float) -> Array:
    """The points (N, 2) that lie between the ends of all along each of the directions (2, 2)."""
    inside = np.ones(len(points), bool)
    for along in (points @ directions.T).T:
        low, high = ends(along, (blur, blur))
        inside &= (along >= low) & (along <= high)
    return points[inside]


def _turned(along: Array) -> Array:
    """A unit vector (2,) and the one to its left."""
    return np.array([along, [-along[1], along[0]]])


def _following(corners: Array) -> Array:
    return np.concatenate([corners[1:], corners[:1]])


def _area(corners: Array) -> float:
    x, y = (corners - corners[0]).T
    following = _following(corners - corners[0])
    return float(x @ following[:, 1] - y @ following[:, 0]) / 2.0


def _rectangle(corners: Array) -> tuple[Array, Array, Array]:
    """Directions (2, 2), centre (2,) and sizes (2,) of the rectangle of least area; it lies along an edge.

    Its other sides touch the corners where the outline has turned by a quarter, a half, and three quarters
    since that edge (Toussaint, "Solving geometric problems with the rotating calipers", MELECON 1983).
    """
    edges = _following(corners) - corners
    along = edges / np.sqrt(np.einsum("ki,ki->k", edges, edges))[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    angle = np.arctan2(along[:, 1], along[:, 0])
    bend = np.mod(np.diff(angle) + ROUNDED, 2.0 * np.pi) - ROUNDED
    turned = np.concatenate([[0.0], np.cumsum(np.maximum(bend, 0.0))])

    def reached(quarters: int, directions: Array) -> Array:
        first = np.searchsorted(turned, np.mod(turned + quarters * np.pi / 2.0, 2.0 * np.pi))
        return np.einsum("ki,ki->k", corners[first % len(corners)], directions)

    low = np.stack([reached(3, along), np.einsum("ki,ki->k", corners, across)])
    high = np.stack([reached(1, along), reached(2, across)])
    size = high - low
    best = int(np.argmin(size[0] * size[1]))
    order = np.argsort(-size[:, best], kind="stable")
    directions = np.stack([along[best], across[best]])
    middle = (low + high)[:, best] / 2.0 @ directions
    return directions[order], middle, size[order, best]


def _coverage(points: Array, corners: Array) -> float:
    """Share of the cells inside the outline that hold points; see `fitting.extents.spread.coverage`.

    Both as seen along the sides of the rectangle.
    """
    import shapely

    side = np.sqrt(POINTS_A_CELL * abs(_area(corners)) / len(points))
    low = corners.min(axis=0)
    grid = Grid.of(points, low, corners.max(axis=0) - low, side)
    outline = shapely.Polygon(corners)
    shapely.prepare(outline)
    inside = shapely.intersects_xy(outline, *grid.centers(np.ones_like(grid.counts)).T)
    return float((grid.counts.ravel()[inside] > 0).mean()) if inside.any() else 1.0


def _pieces(outline: list[list[Any]]) -> str:
    holes = sum(len(rings) - 1 for rings in outline)
    parts = "one piece" if len(outline) == 1 else f"{len(outline)} pieces"
    return parts if holes == 0 else f"{parts} with {'a hole' if holes == 1 else f'{holes} holes'}"
