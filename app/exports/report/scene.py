"""What the views of a report show: the trimmed surface in small pieces, its edges, its axis, and points."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from primfit.fitting.extents.plane import PlaneExtents
from primfit.fitting.geometry.vectors import Array, basis, cross
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from ..fitted import Fitted
from ..mesh import flat
from ..patch import Patch, Pieces, patch_of

SHOWN_POINTS = 3000
"""So many points, drawn by chance, are in a view; all of them where there are no more."""

STRIPS = 40
"""Pieces around a full turn."""

BANDS = 6
"""Pieces along a straight profile."""

FINE = 400
"""Samples each way that decide what is hidden."""


def shown(n_points: int) -> np.ndarray:
    """Rows of the points that are drawn, in their order; the same ones again for as many points."""
    if n_points <= SHOWN_POINTS:
        return np.arange(n_points)
    return np.sort(np.random.default_rng(0).permutation(n_points)[:SHOWN_POINTS])


@dataclass(frozen=True, eq=False)
class Surface:
    """A trimmed primitive to be drawn.

    Attributes
    ----------
    pieces : (M, 4, 3) corners of small quadrilaterals, or (M, 3, 3) of triangles of a plane
    normals : (M, 3) outward
    edges : polylines (K, 3) where it ends
    fine : (S, 3) samples, dense enough to hide what is behind; none of a plane, which hides nothing of note
    axis : (2, 3) ends of the axis, a little longer than the surface; None of spheres and planes
    """

    pieces: Array
    normals: Array
    edges: tuple[Array, ...]
    fine: Array
    axis: Array | None

    @classmethod
    def of(cls, primitive: Primitive, patch: Patch | Pieces) -> Self:
        if not isinstance(patch, Patch):
            corners, triangles = flat(patch, primitive)
            edges = tuple(np.vstack([ring, ring[:1]]) for rings in patch for ring in rings)
            normals = primitive.gradient(corners[triangles[:, 0]])
            return cls(corners[triangles], normals, edges, np.empty((0, 3)), None)
        corners = patch.at(*_lattice(patch, STRIPS, BANDS))
        quads = [corners[:-1, :-1], corners[:-1, 1:], corners[1:, 1:], corners[1:, :-1]]
        pieces = np.stack(quads, axis=2).reshape(-1, 4, 3)
        fine = patch.at(np.linspace(*patch.u, FINE), np.linspace(*patch.v, FINE)[:, None]).reshape(-1, 3)
        return cls(pieces, primitive.gradient(pieces.mean(axis=1)), _edges(patch), fine, _axis(patch))


def _lattice(patch: Patch, strips: int, bands: int) -> tuple[Array, Array]:
    """Values of u (U,) and v (V, 1) whose pieces are about square on curved profiles."""
    turn = 2.0 * np.pi
    across, along = (strips * (end - start) / turn for start, end in (patch.u, patch.v))
    if not isinstance(patch.primitive, Sphere | Torus):
        along = bands
    n_u, n_v = (max(int(np.ceil(n)), 4) for n in (across, along))
    return np.linspace(*patch.u, n_u + 1), np.linspace(*patch.v, n_v + 1)[:, None]


def _edges(patch: Patch) -> tuple[Array, ...]:
    u, v = np.linspace(*patch.u, 97), np.linspace(*patch.v, 49)
    edges = [patch.at(end, v) for end in patch.u if not patch.closed_u]
    ends = zip(patch.v, patch.has_pole, strict=True)
    edges += [patch.at(u, end) for end, is_pole in ends if not (is_pole or patch.closed_v)]
    return tuple(edges)


def _axis(patch: Patch) -> Array | None:
    if isinstance(patch.primitive, Sphere):
        return None
    heights = patch.profile(np.linspace(*patch.v, 49))[1]
    low, high = float(heights.min()), float(heights.max())
    margin = 0.15 * max(high - low, float(patch.profile(np.array(patch.v))[0].max()))
    return patch.origin + np.outer([low - margin, high + margin], patch.axis)


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
    framed : (F, 3) what has to be in the pictures: the surface and the inliers
    axis, front : (3,) the directions that are up in the pictures, and to the viewer
    """

    points: Array
    distance: Array | None
    surface: Surface | None
    framed: Array
    axis: Array
    front: Array

    @classmethod
    def of(cls, fitted: Fitted) -> Self:
        """The primitive is shown where the answer accepts it and its extents are known."""
        recognition, points = fitted.recognition, fitted.points
        distance = kept = None
        if recognition.status != "no_fit":
            distance, kept = fitted.residuals.distance, fitted.residuals.inlier
        patch = patch_in(fitted)
        surface = None if patch is None else Surface.of(fitted.primitive, patch)
        framed = points[kept] if kept is not None and kept.any() else points
        if surface is not None:
            framed = np.vstack([framed, surface.pieces.reshape(-1, 3)])
        rows = shown(len(points))
        axis, front = _directions(fitted, patch)
        some = None if distance is None else distance[rows]
        return cls(points[rows], some, surface, framed, axis, front)


def patch_in(fitted: Fitted) -> Patch | Pieces | None:
    """The trimmed surface that a report shows, or None where there is none."""
    recognition = fitted.recognition
    if recognition.status == "no_fit" or recognition.extents is None:
        return None
    return patch_of(fitted.primitive, recognition.extents)


def _directions(fitted: Fitted, patch: Patch | Pieces | None) -> tuple[Array, Array]:
    """Which way is up and which is to the viewer: the axis, turned up, and the middle of the arc."""
    if patch is None:
        return np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])
    extents = fitted.recognition.extents
    if isinstance(extents, PlaneExtents):
        axis = fitted.primitive.gradient(extents.center[None])[0]
        return axis, -extents.width_direction
    assert isinstance(patch, Patch)
    up = patch.axis if patch.axis[2] >= -1e-9 else -patch.axis
    front = basis(up)[1] if patch.closed_u else patch.direction(float(np.mean(patch.u)))
    return up, front
