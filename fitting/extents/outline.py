"""The concave outline of points in a plane: pieces, notches and holes that are larger than chance leaves.

The triangles of the points' Delaunay triangulation are kept whose longest edge is not over what chance makes
of the local spacing; what they cover is the outline (Edelsbrunner, Kirkpatrick, Seidel, "On the shape of a
set of points in the plane", IEEE Trans. Inf. Theory 29(4), 1983, with a length that follows the density).
Points in the midst of others need no triangles, so only those near the edges are triangulated.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..geometry.vectors import TINY, Array
from .grid import Grid, around
from .spread import BLURRED, CHANCE, FEWEST, MOST_STRAY

Rings = tuple[Array, ...]
"""A piece: its outer ring (K, 2), counter-clockwise, and its holes, clockwise; no corner is repeated."""

IN_A_CELL = 7
"""Cells hold so many points on average; of random points 0.1 % of the cells are empty."""

FEWEST_AROUND = 7
"""Points in a cell and its eight neighbours; where there are fewer (63 is usual), they are stray."""

FINEST = 8.0
"""Where much of the rectangle is empty the cells are smaller, by this factor at most."""

WIDER = 1.5
"""A reach that leaves out too many points is made wider by this factor."""

SMALLEST = 20
"""Pieces and holes of less than the area of so many points are none."""

INWARD = 0.29
"""The edge of evenly random points lies so many spacings within what they were drawn from, on the average."""

BENDS = 0.5
"""The outline may move by so many spacings while corners are left out."""

MOST_CORNERS = 1000
COARSE = 2.0
"""For fewer corners the outline may move farther; over so many spacings, the smaller rings are left out."""

MOST_OUTER, OUTER_SHARE = 100, 0.25
"""Where more of the points than both are corners of the convex outline they lie on a circle, not in it, and
that is their outline; to triangulate points of one circle takes time with their square."""

IRRATIONAL = np.sqrt([2.0, 3.0])
"""Along it only repeated points are at the same place, and its multiples leave evenly spread fractions."""


@dataclass(frozen=True, eq=False)
class _Near:
    """What is triangulated.

    Attributes
    ----------
    points : (M, 2) those near an edge, then about the middles of the full cells next to them
    spacing : (M,) local one of the points, 0 of the middles
    mean_spacing : of all the points
    edge : (E, 2) points that are looked at for noise: a cell farther in than those near an edge
    """

    points: Array
    spacing: Array
    mean_spacing: float
    edge: Array


def concave(points: Array, corners: Array, blur: float) -> tuple[Rings, ...]:
    """The pieces that points (N, 2) fill, the largest first; none where that is their convex outline.

    Parameters
    ----------
    points : about even along both coordinates
    corners : (K, 2) of their convex outline, counter-clockwise
    blur : standard deviation of their noise
    """
    once = np.unique(points @ IRRATIONAL, return_index=True)[1]
    points = points if len(once) == len(points) else points[np.sort(once)]
    if len(points) < FEWEST or len(corners) > max(MOST_OUTER, OUTER_SHARE * len(points)):
        return ()
    near = _near(points)
    reach = 2.0 * np.sqrt((np.log(len(points)) + CHANCE + 3.0) / np.pi)
    shape = _triangulated(near, reach, len(points) // MOST_STRAY)
    if shape.is_empty or _fills(shape, corners, reach * near.mean_spacing / 2.0):
        return ()
    return _pieces(_tidied(shape, near, blur))


def _near(points: Array) -> _Near:
    low = points.min(axis=0)
    size = points.max(axis=0) - low
    side = float(np.sqrt(IN_A_CELL * size.prod() / len(points)))
    grid = Grid.of(points, low, size, side)
    taken = np.count_nonzero(grid.counts) / grid.counts.size
    if taken < 0.5:
        grid = Grid.of(points, low, size, side * max(float(np.sqrt(taken)), 1.0 / FINEST))
    occupied, cell = grid.counts > 0, float(grid.step.prod())
    mean_spacing = float(np.sqrt(np.count_nonzero(occupied) * cell / len(points)))
    counts = around(grid.counts)
    full = around(occupied.astype(np.intp)) == 9
    within = around(full.astype(np.intp)) == 9
    dense = counts >= FEWEST_AROUND
    chosen = (dense & ~full).ravel()[grid.taken]
    middles = grid.centers(full & ~within)
    # Off the middles, since a triangulation takes longer where many points lie on one circle.
    middles += grid.step * (np.mod(np.outer(np.arange(len(middles)), IRRATIONAL), 0.2) - 0.1)
    # Of the windows about a cell the fullest one is not cut by an edge.
    fullest = around(counts, np.maximum).ravel()[grid.taken[chosen]]
    spacing = np.maximum(np.sqrt(9.0 * cell / fullest), mean_spacing)
    return _Near(
        points=np.concatenate([points[chosen], middles]),
        spacing=np.concatenate([spacing, np.zeros(len(middles))]),
        mean_spacing=mean_spacing,
        edge=points[(dense & ~within).ravel()[grid.taken]],
    )


def _triangulated(near: _Near, reach: float, most: int) -> Any:
    """What the triangles cover that have no edge over `reach` spacings, or a corner in the midst of points.

    The reach is made wider while that leaves out more than `most` of the points, as far scan lines would.
    """
    import shapely
    from scipy.spatial import Delaunay

    if len(near.points) < 3:
        return shapely.Polygon()
    mesh = Delaunay(near.points)
    needed = _needed(near, mesh.simplices)
    beyond = mesh.neighbors
    while True:
        kept = needed <= reach
        triangle, opposite = np.nonzero(kept[:, None] & ~((beyond >= 0) & kept[beyond]))
        ends = [mesh.simplices[triangle, (opposite + k) % 3] for k in (1, 2)]
        shape = _large(_bounded(near.points[np.stack(ends, axis=1)]), SMALLEST * near.mean_spacing**2)
        shapely.prepare(shape)
        out = np.count_nonzero(~shapely.intersects_xy(shape, *near.points.T))
        if out <= most or kept.all():
            return shape
        reach *= WIDER


def _needed(near: _Near, triangles: np.ndarray) -> Array:
    """The longest edge of each triangle in local spacings, of its corners the median; 0 in the midst."""
    x, y = near.points.T[:, triangles.T]
    square = (x - x[[1, 2, 0]]) ** 2 + (y - y[[1, 2, 0]]) ** 2
    longest = np.sqrt(np.maximum(np.maximum(square[0], square[1]), square[2]))
    a, b, c = near.spacing[triangles.T]
    median = np.maximum(np.minimum(a, b), np.minimum(np.maximum(a, b), c))
    return np.where(np.minimum(np.minimum(a, b), c) == 0.0, 0.0, longest / np.maximum(median, TINY))


def _bounded(edges: Array) -> list[Any]:
    """The polygons to the left of edges (E, 2, 2)."""
    import shapely

    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(edges)))
    directed = {tuple(edge) for edge in edges.reshape(-1, 4).tolist()}
    faces = shapely.orient_polygons(faces, exterior_cw=False)
    return [face for face in faces if sum(face.exterior.coords[:2], ()) in directed]


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


def _fills(shape: Any, corners: Array, depth: float) -> bool:
    """Whether it is one piece without holes, and nowhere deeper than so within a convex outline."""
    import shapely

    if len(shape.geoms) != 1 or shape.geoms[0].interiors:
        return False
    deeper = shapely.buffer(shapely.Polygon(corners), -depth, join_style="mitre")
    shapely.prepare(deeper)
    return not shapely.contains_xy(deeper, shapely.get_coordinates(shape)).any()


def _tidied(shape: Any, near: _Near, blur: float) -> Any:
    """With fewer corners, and moved to where the edge is on the average of random points and of noise."""
    import shapely

    spacing, smallest = near.mean_spacing, SMALLEST * near.mean_spacing**2
    tolerance = BENDS * spacing
    plain = shapely.simplify(shape, tolerance)
    move = (shape.area - plain.area) / plain.length + _outward(shape, near, blur)
    tidy = _large(shapely.get_parts(shapely.buffer(plain, move, join_style="mitre")), smallest)
    while shapely.get_num_coordinates(tidy) > MOST_CORNERS:
        tolerance *= 2.0
        tidy = shapely.simplify(tidy, tolerance)
        if tolerance > COARSE * spacing:
            parts = shapely.get_parts(tidy)
            areas = [_area(ring) for part in parts for ring in (part.exterior, *part.interiors)]
            tidy = _large(parts, float(np.median(areas)))
    return tidy


def _outward(shape: Any, near: _Near, blur: float) -> float:
    """How far the edge is from the average one: within it for lack of points, beyond it for noise.

    Rows of a grid, along which corners are as near to each other as points are, lie on the edge itself.
    """
    import shapely

    corners = shapely.get_num_coordinates(shape)
    spacing = near.mean_spacing
    short = INWARD * spacing * float(np.clip(shape.length / (corners * spacing) - 1.0, 0.0, 1.0))
    over = int(BLURRED * blur * shape.length / spacing**2)
    if over < corners:  # which are that many points on the outline
        return short * (1.0 - over / corners)
    inside = shapely.contains_xy(shape, near.edge[:, 0], near.edge[:, 1])
    depths = np.where(inside, 1.0, -1.0) * shapely.distance(shapely.points(near.edge), shape.boundary)
    over = min(over, len(depths) - 1)
    return -max(float(np.partition(depths, over)[over]), 0.0)


def _pieces(shape: Any) -> tuple[Rings, ...]:
    import shapely

    parts = shapely.orient_polygons(shapely.get_parts(shape), exterior_cw=False)
    return tuple(
        tuple(np.array(ring.coords)[:-1] for ring in (part.exterior, *part.interiors))
        for part in sorted(parts, key=lambda part: -part.area)
    )
