"""What is compiled of the extents of planes, in NumPy and with Qhull's triangles: the same answers."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import shapely
from scipy.spatial import ConvexHull, Delaunay, cKDTree

from primfit.fitting.geometry.vectors import TINY, Array, basis
from primfit.fitting.primitives.plane import Plane
from tests.fitting.extents.reference_curved import CHANCE, FEWEST, MOST_STRAY, POINTS_A_CELL, ends

NEIGHBOURS = 6
REACH = 3.0
"""A corner of the outline is stray that has fewer than so many points within so many mean spacings."""

ROUNDED = 0.5
"""An outline that turns back by less than this is straight but for rounding [rad]."""

OCTAGON = np.stack([np.cos(np.arange(8) * np.pi / 4.0), np.sin(np.arange(8) * np.pi / 4.0)], axis=1)

Rings = tuple[Array, ...]
"""A piece: its outer ring (K, 2), counter-clockwise, and its holes, clockwise; no corner is repeated."""

IN_A_CELL = 7
"""Cells hold so many points on average; of random points 0.1% of the cells are empty."""

FEWEST_AROUND = 7
"""Points in a cell and its eight neighbors; where there are fewer (63 is usual), they are stray."""

FINEST = 8.0
"""Where much of the rectangle is empty the cells are smaller, by this factor at most."""

WIDER = 1.5
"""A reach that leaves out too many points is made wider by this factor."""

SMALLEST = 20
"""Pieces and holes of less than the area of so many points are none."""

MOST_OUTER, OUTER_SHARE = 100, 0.25
"""Where more of the points than both are corners of the convex outline they lie on a circle, not in it, and
that is their outline; to triangulate points of one circle takes time with their square."""

IRRATIONAL = np.sqrt([2.0, 3.0])
"""Along it only repeated points are at the same place, and its multiples leave evenly spread fractions."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Rows along the first coordinate, columns along the second.

    Attributes
    ----------
    low : (2,) corner where the cells begin
    step : (2,) sides of a cell
    taken : (N,) number of the cell of each point, row by row
    counts : (rows, columns) points in each cell
    """

    low: Array
    step: Array
    taken: np.ndarray
    counts: np.ndarray

    @classmethod
    def of(cls, points: Array, low: Array, size: Array, side: float) -> Self:
        """Over the rectangle of a size from `low` on; points outside it count at its edge."""
        shape = np.maximum(np.round(size / side), 1.0).astype(np.intp)
        step = size / shape
        row, column = np.clip(((points - low) / step).astype(np.intp), 0, shape - 1).T
        taken = row * shape[1] + column
        return cls(low, step, taken, np.bincount(taken, minlength=int(shape.prod())).reshape(shape))

    def centers(self, cells: np.ndarray) -> Array:
        """Middles (K, 2) of the cells of a mask (rows, columns), row by row."""
        return self.low + (np.argwhere(cells) + 0.5) * self.step


def around(values: np.ndarray, combine: np.ufunc = np.add) -> np.ndarray:
    """The sum (or largest) over each cell and its eight neighbors; beyond the edge there is 0."""
    padded = np.pad(values, 1)
    rows = combine(combine(padded[:-2], padded[1:-1]), padded[2:])
    return np.asarray(combine(combine(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:]))


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


def plane(primitive: Plane, feet: Array, blur: float) -> dict[str, Any]:
    """Some of the extents; and the pieces, before corners are left out, in the basis of the normal."""
    frame = np.array(basis(primitive.normal))
    flat = (feet - primitive.point) @ frame.T
    kept, corners = _outlined(flat)
    even = _turned(_rectangle(corners)[0][0])
    ended = _between_ends(kept, even, blur)
    corners = ended[_hull(ended)]
    axes, middle, size = _rectangle(corners)
    return {
        "outline": primitive.point + corners @ frame,
        "area": _area(corners),
        "coverage": _coverage(ended @ axes.T, corners @ axes.T),
        "center": primitive.point + middle @ frame,
        "length": size[0],
        "width": size[1],
        "pieces": shapely.transform(concave(kept @ even.T, corners @ even.T), lambda at: at @ even),
    }


def concave(points: Array, corners: Array) -> Any:
    """The shape that points (N, 2) fill, or an empty one where that is their convex outline (K, 2)."""
    once = np.unique(points @ IRRATIONAL, return_index=True)[1]
    points = points if len(once) == len(points) else points[np.sort(once)]
    if len(points) < FEWEST or len(corners) > max(MOST_OUTER, OUTER_SHARE * len(points)):
        return shapely.MultiPolygon()
    near = _near(points)
    reach = 2.0 * np.sqrt((np.log(len(points)) + CHANCE + 3.0) / np.pi)
    shape = _triangulated(near, reach, len(points) // MOST_STRAY)
    return shapely.MultiPolygon() if _fills(shape, corners, reach * near.mean_spacing / 2.0) else shape


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
    faces = shapely.get_parts(shapely.polygonize(shapely.linestrings(edges)))
    directed = {tuple(edge) for edge in edges.reshape(-1, 4).tolist()}
    faces = shapely.orient_polygons(faces, exterior_cw=False)
    return [face for face in faces if sum(face.exterior.coords[:2], ()) in directed]


def _large(parts: Iterable[Any], smallest: float) -> Any:
    """The polygons as one shape, without pieces and holes whose rings are around less than an area."""
    pieces = [piece for piece in parts if _area_of(piece.exterior) >= smallest]
    filled = [
        shapely.Polygon(piece.exterior, [ring for ring in piece.interiors if _area_of(ring) >= smallest])
        for piece in pieces
    ]
    return shapely.MultiPolygon(filled)


def _area_of(ring: Any) -> float:
    return float(shapely.Polygon(ring).area)


def _fills(shape: Any, corners: Array, depth: float) -> bool:
    """Whether it is one piece without holes, and nowhere deeper than so within a convex outline."""
    if len(shape.geoms) != 1 or shape.geoms[0].interiors:
        return False
    deeper = shapely.buffer(shapely.Polygon(corners), -depth, join_style="mitre")
    shapely.prepare(deeper)
    return not shapely.contains_xy(deeper, shapely.get_coordinates(shape)).any()


def _outlined(flat: Array) -> tuple[Array, Array]:
    """The points (M, 2) that are not stray, and the corners (K, 2) of their convex outline."""
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
        same = 1e-12 * np.ptp(along)
        inside &= (along >= low - same) & (along <= high + same)
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
    """Directions (2, 2), center (2,) and sizes (2,) of the rectangle of least area; it lies along an edge.

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
    side = np.sqrt(POINTS_A_CELL * abs(_area(corners)) / len(points))
    low = corners.min(axis=0)
    grid = Grid.of(points, low, corners.max(axis=0) - low, side)
    outline = shapely.Polygon(corners)
    shapely.prepare(outline)
    inside = shapely.intersects_xy(outline, *grid.centers(np.ones_like(grid.counts)).T)
    return float((grid.counts.ravel()[inside] > 0).mean()) if inside.any() else 1.0
