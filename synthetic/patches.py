"""Bounded pieces of the five primitives in canonical position, and where rays meet them.

Canonical: centre, apex or a point at the origin, axis z; a piece is bounded in the two parameters of
`Primitive.surface`, with azimuths measured from the x axis.
"""

from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from primfit.fitting.primitives.cone import Cone
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.plane import Plane
from primfit.fitting.primitives.primitive import Primitive
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Span = tuple[float, float]

MARCH_STEPS = 80
"""Steps along a ray to a torus; rays that still crawl then graze it and count as misses."""
CONVERGED = 1e-4
"""Distance, in outer radii, from which Newton's method takes over."""


def around(angle: Array, span: Span) -> Mask:
    """Which angles lie in the span, modulo a turn."""
    return np.mod(angle - span[0], 2 * np.pi) <= span[1] - span[0]


@dataclass(frozen=True, eq=False)
class Patch:
    """The part of a canonical primitive with parameters in `u` and `v`."""

    primitive: Primitive
    u: Span
    v: Span

    def sample(self, rng: Generator, count: int) -> Array:
        """Points (count, 3) with uniform parameters."""
        return self.primitive.surface(rng.uniform(*self.u, count), rng.uniform(*self.v, count))

    def between_ends(self, points: Array) -> Mask:
        """Which points of the surface lie between the two ends of a cylinder or cone; elsewhere all do."""
        if isinstance(self.primitive, Cylinder | Cone):
            return (points[..., 2] >= self.v[0]) & (points[..., 2] <= self.v[1])
        return np.ones(points.shape[:-1], dtype=bool)

    def contains(self, points: Array) -> Mask:
        """Which points of the surface belong to the piece."""
        x, y, z = np.moveaxis(points, -1, 0)
        if isinstance(self.primitive, Plane):
            return (x >= self.u[0]) & (x <= self.u[1]) & (y >= self.v[0]) & (y <= self.v[1])
        inside = around(np.arctan2(y, x), self.u) & self.between_ends(points)
        match self.primitive:
            case Sphere(radius=radius):
                polar = np.arccos(np.clip(z / radius, -1.0, 1.0))
                return inside & (polar >= self.v[0]) & (polar <= self.v[1])
            case Torus(major_radius=major_radius):
                return inside & around(np.arctan2(z, np.hypot(x, y) - major_radius), self.v)
        return inside

    def first_hits(self, origin: Array, directions: Array, solid: bool) -> tuple[Array, Mask]:
        """Distances (N,) along rays to what they meet first, and which of them meet this piece.

        A `solid` object is whole between its ends: what is not of the piece hides the piece, and so does the
        inside of an open end. Otherwise the piece is a thin sheet, and what is missing of it lets rays pass.
        """
        with np.errstate(invalid="ignore", divide="ignore"):
            if isinstance(self.primitive, Torus):
                return self._first_hits_of_torus(self.primitive, origin, directions, solid)
            distances = crossings(self.primitive, origin, directions)
            points = origin + distances[..., None] * directions
            blocks = (self.between_ends(points) if solid else self.contains(points)) & (distances > 0.0)
        first = np.where(blocks, distances, np.inf).argmin(axis=0)[None]
        hit = np.take_along_axis(blocks, first, axis=0)[0]
        distance = np.take_along_axis(distances, first, axis=0)[0]
        distance[hit] = polished(self.primitive, origin, directions[hit], distance[hit])
        hit[hit] = self.contains(origin + distance[hit, None] * directions[hit])
        return distance, hit

    def _first_hits_of_torus(
        self, torus: Torus, origin: Array, directions: Array, solid: bool
    ) -> tuple[Array, Mask]:
        distance, hit = march(torus, origin, directions, np.zeros(len(directions)))
        mine = np.zeros(len(hit), dtype=bool)
        mine[hit] = self.contains(origin + distance[hit, None] * directions[hit])
        for _ in range(0 if solid else 3):
            missed = np.flatnonzero(hit & ~mine)
            beyond = distance[missed] + 10 * CONVERGED * (torus.major_radius + torus.minor_radius)
            distance[missed], hit[missed] = march(torus, origin, directions[missed], beyond)
            mine[missed] = hit[missed] & self.contains(origin + distance[missed, None] * directions[missed])
        return distance, mine


def crossings(primitive: Primitive, origin: Array, directions: Array) -> Array:
    """Where rays cross a plane (1, N) or a quadric (2, N), as distances; NaN where they do not.

    With a point o + t d:  a t^2 + 2 b t + c = 0  for  x.D.x = k with a diagonal D, and the roots q / a and
    c / q with q = -(b + sign(b) sqrt(b^2 - a c)), which do not cancel. A cone's second nappe is left out by
    the ends of its piece.
    """
    if isinstance(primitive, Plane):
        return (-origin[2] / directions[:, 2])[None]
    match primitive:
        case Sphere(radius=radius):
            weights, level = np.ones(3), radius**2
        case Cylinder(radius=radius):
            weights, level = np.array([1.0, 1.0, 0.0]), radius**2
        case Cone(half_angle=half_angle):
            weights, level = np.array([1.0, 1.0, -(np.tan(half_angle) ** 2)]), 0.0
        case _:
            raise TypeError(f"no crossings for {type(primitive).__name__}")
    a = directions**2 @ weights
    b = directions @ (weights * origin)
    c = float(origin**2 @ weights) - level
    q = -(b + np.copysign(np.sqrt(b * b - a * c), b))
    return np.stack([q / a, c / q])


def march(torus: Torus, origin: Array, directions: Array, start: Array) -> tuple[Array, Mask]:
    """The next crossing of rays (N,) with a torus beyond `start`: distances, and which rays have one.

    Steps as long as the distance to the surface cannot pass it (Hart, "Sphere tracing", The Visual Computer
    12, 1996); Newton's method along the ray ends it.
    """
    reach = torus.major_radius + torus.minor_radius
    middle = -(directions @ origin)
    half = np.sqrt(np.maximum(reach**2 - (origin @ origin - middle**2), 0.0))
    distance = np.maximum(start, middle - half)
    active = np.flatnonzero((half > 0.0) & (distance < middle + half))
    hit = np.zeros(len(directions), dtype=bool)
    for _ in range(MARCH_STEPS):
        if not len(active):
            break
        step = np.abs(torus.signed_distance(origin + distance[active, None] * directions[active]))
        distance[active] += step
        close = step < CONVERGED * reach
        hit[active[close]] = True
        active = active[~close]
        active = active[distance[active] < (middle + half)[active]]
    distance[hit] = polished(torus, origin, directions[hit], distance[hit], rounds=4)
    hit[hit] = np.abs(torus.signed_distance(origin + distance[hit, None] * directions[hit])) < 1e-9 * reach
    return distance, hit


def polished(
    primitive: Primitive, origin: Array, directions: Array, distance: Array, rounds: int = 1
) -> Array:
    """Crossings (N,) after a few steps of Newton's method along their rays, short where a ray grazes."""
    for _ in range(rounds):
        points = origin + distance[:, None] * directions
        slope = np.einsum("ij,ij->i", primitive.gradient(points), directions)
        distance = distance - primitive.signed_distance(points) / np.copysign(
            np.maximum(np.abs(slope), 0.05), slope
        )
    return distance
