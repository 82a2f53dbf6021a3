"""The part of a plane that holds points: their convex outline and the smallest rectangle about it."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.spatial import ConvexHull

from fitting.extents.spread import POINTS_A_CELL, ends
from fitting.extents.values import Bounds, Length, Place
from fitting.geometry import Array, basis, vector
from fitting.primitives import Plane

NEIGHBOURS = 6
REACH = 3.0
"""A corner of the outline is stray that has fewer than so many points within so many mean spacings."""

MOST_STRAY = 20
"""At most one in so many points is dropped as stray."""


@dataclass(frozen=True, eq=False)
class PlaneExtents(Bounds):
    """The bounded plane.

    Attributes
    ----------
    outline : (K, 3) corners of the convex outline, counter-clockwise about the normal
    center : (3,) of the rectangle of least area about the outline
    length, width : of that rectangle; the length is the longer
    length_direction, width_direction : (3,) unit vectors along its sides
    """

    kind: ClassVar[str] = "plane"

    outline: Place
    center: Place
    length: Length
    width: Length
    length_direction: Array
    width_direction: Array

    @classmethod
    def of(cls, primitive: Plane, feet: Array, blur: float) -> "PlaneExtents":
        frame = np.array(basis(primitive.normal))
        flat = (feet - primitive.point) @ frame.T
        kept, corners = _outlined(flat)
        kept = _between_ends(kept, _rectangle(corners)[0], blur)
        corners = kept[ConvexHull(kept).vertices]
        area = _area(corners)
        (along, across), middle, size = _rectangle(corners)
        return cls(
            area=area,
            coverage=_coverage(kept, corners, along, across),
            outline=primitive.point + corners @ frame,
            center=primitive.point + middle @ frame,
            length=float(size[0]),
            width=float(size[1]),
            length_direction=vector(along @ frame),
            width_direction=vector(across @ frame),
        )


def _outlined(flat: Array) -> tuple[Array, Array]:
    """The points (M, 2) that are not stray, and the corners (K, 2) of their convex outline."""
    kept, dropped = flat, 0
    while True:
        corners = ConvexHull(kept).vertices
        reach = REACH * np.sqrt(_area(kept[corners]) / len(kept))
        apart = kept[corners, None] - kept[None]
        near = np.count_nonzero(np.einsum("kni,kni->kn", apart, apart) <= reach**2, axis=1) - 1
        stray = corners[near < NEIGHBOURS]
        dropped += len(stray)
        if len(stray) == 0 or dropped > len(flat) // MOST_STRAY:
            return kept, kept[corners]
        kept = np.delete(kept, stray, axis=0)


def _between_ends(points: Array, directions: Array, blur: float) -> Array:
    """The points (N, 2) that lie between the ends of all along each of the directions (2, 2)."""
    inside = np.ones(len(points), bool)
    for along in (points @ directions.T).T:
        low, high = ends(along, (blur, blur))
        inside &= (along >= low) & (along <= high)
    return points[inside]


def _area(corners: Array) -> float:
    x, y = (corners - corners[0]).T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2.0)


def _rectangle(corners: Array) -> tuple[Array, Array, Array]:
    """Directions (2, 2), centre (2,) and sizes (2,) of the rectangle of least area; it lies along an edge."""
    edges = np.roll(corners, -1, axis=0) - corners
    along = edges / np.sqrt(np.einsum("ki,ki->k", edges, edges))[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    spread = np.stack([corners @ along.T, corners @ across.T])
    low, high = spread.min(axis=1), spread.max(axis=1)
    size = high - low
    best = int(np.argmin(size[0] * size[1]))
    order = np.argsort(-size[:, best], kind="stable")
    directions = np.stack([along[best], across[best]])
    middle = (low + high)[:, best] / 2.0 @ directions
    return directions[order], middle, size[order, best]


def _coverage(points: Array, corners: Array, along: Array, across: Array) -> float:
    """Share of the cells inside the outline that hold points; see `fitting.extents.spread.coverage`."""
    side = np.sqrt(POINTS_A_CELL * _area(corners) / len(points))
    axes = np.stack([along, across])
    low = (corners @ axes.T).min(axis=0)
    rows, columns = np.maximum(np.round(((corners @ axes.T).max(axis=0) - low) / side), 1).astype(np.intp)
    step = ((corners @ axes.T).max(axis=0) - low) / (rows, columns)
    taken = np.minimum(((points @ axes.T - low) / step).astype(np.intp), (rows - 1, columns - 1))
    holds = np.zeros((rows, columns), bool)
    holds[taken[:, 0], taken[:, 1]] = True
    centers = low + (np.argwhere(np.ones_like(holds)) + 0.5) * step
    ring = corners @ axes.T
    edges = np.roll(ring, -1, axis=0) - ring
    turned = np.sign(_area(ring)) * (
        edges[:, 0] * (centers[:, 1, None] - ring[:, 1]) - edges[:, 1] * (centers[:, 0, None] - ring[:, 0])
    )
    inside = np.all(turned >= 0.0, axis=1)
    return float(holds.ravel()[inside].mean()) if inside.any() else 1.0
