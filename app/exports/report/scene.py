"""What the views of a report show: the trimmed surface in small pieces, its edges, its axis, and points."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from primfit.fitting.geometry.vectors import Array, cross
from primfit.fitting.primitives.primitive import Primitive

from ..drawing import Shape
from ..fitted import Fitted
from .ranges import range_about, robust_range

SHOWN_POINTS = 3000
"""So many points, a random sample, are in a view; all of them where there are no more."""

BESIDE, REACH = 0.02, 2.0
"""Points beside the surface are in the pictures up to this share of its size, and this many times the
distance that 95% of the inliers are within."""

UPRIGHT = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
"""Which way is up, and which is to the viewer, where there is no surface."""


def shown(n_points: int, most: int = SHOWN_POINTS) -> np.ndarray:
    """Rows of the points that are drawn, in their order; the same ones again for as many points."""
    if n_points <= most:
        return np.arange(n_points)
    return np.sort(np.random.default_rng(0).permutation(n_points)[:most])


@dataclass(frozen=True, eq=False)
class Surface:
    """A trimmed primitive to be drawn: what `drawing.Shape` says of it, and normals.

    Attributes
    ----------
    pieces : (M, 4, 3) or (M, 3, 3) corners
    normals : (M, 3) outward
    edges : polylines (K, 3)
    fine : (S, 3) samples
    axis : (2, 3) ends of the axis, or None
    """

    pieces: Array
    normals: Array
    edges: tuple[Array, ...]
    fine: Array
    axis: Array | None

    @classmethod
    def of(cls, primitive: Primitive, shape: Shape) -> Self:
        pieces = shape.pieces()
        normals = primitive.gradient(pieces.mean(axis=1))
        return cls(pieces, normals, shape.edges(), shape.fine(), shape.axis_line())


@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel projection: unit vectors to the right, up, and towards the viewer."""

    right: Array
    up: Array
    toward: Array

    @classmethod
    def at(cls, axis: Array, front: Array, azimuth: float, elevation: float) -> Self:
        """From so many degrees beside `front` and above the plane across `axis`."""
        around, above = np.radians(azimuth), np.radians(elevation)
        beside = cross(axis, front)
        ahead = np.cos(around) * front + np.sin(around) * beside
        toward = np.cos(above) * ahead + np.sin(above) * axis
        right = np.cos(around) * beside - np.sin(around) * front
        return cls(right, cross(toward, right), toward)

    def seen(self, points: Array) -> Array:
        """(..., 3): to the right, up, and towards the viewer."""
        return points @ np.stack([self.right, self.up, self.toward], axis=1)


@dataclass(frozen=True, eq=False)
class Scene:
    """What is drawn.

    Attributes
    ----------
    points : (N, 3), some of the cloud
    distance : (N,) their residuals, or None
    surface : the trimmed primitive, or None
    near : (K, 3) the inliers, or all points where there is no surface: pictures reach to those of them that
        are not far from the others
    slack : how far from the surface they may be to be in the pictures [length]
    cloud : (M, 3) all points
    axis, front : (3,) the directions that are up in the pictures, and to the viewer
    """

    points: Array
    distance: Array | None
    surface: Surface | None
    near: Array
    slack: float
    cloud: Array
    axis: Array
    front: Array

    @classmethod
    def of(cls, fitted: Fitted) -> Self:
        """The primitive is shown where the answer accepts it and its extents are known."""
        recognition, points = fitted.recognition, fitted.points
        distance = kept = None
        if recognition.status != "no_fit":
            distance, kept = fitted.residuals.distance, fitted.residuals.inlier
        shape = shape_in(fitted)
        surface = None if shape is None else Surface.of(fitted.primitive, shape)
        near, slack = points, 0.0
        if distance is not None and kept is not None and kept.any():
            near, slack = points[kept], REACH * float(np.percentile(np.abs(distance[kept]), 95.0))
        rows = shown(len(points))
        axis, front = UPRIGHT if shape is None else shape.directions()
        some = None if distance is None else distance[rows]
        return cls(points[rows], some, surface, near, slack, points, axis, front)

    def reach(self, camera: Camera, origin: Array) -> tuple[Array, Array]:
        """From where to where (3,) pictures go, as the camera sees it from the origin."""
        near = camera.seen(self.near - origin)
        if self.surface is None:
            return robust_range(near)
        pieces = camera.seen(self.surface.pieces.reshape(-1, 3) - origin)
        margin = BESIDE * float(np.ptp(pieces, axis=0).max()) + self.slack
        return range_about(near, pieces, margin)


def shape_in(fitted: Fitted) -> Shape | None:
    """The trimmed surface that a report shows, or None where there is none."""
    recognition = fitted.recognition
    return None if recognition.status == "no_fit" or recognition.extents is None else fitted.shape
