"""Clouds of shapes that are none of the five primitives: to see what a recogniser does with them.

Each shape gives points with normals, at most as many as asked for and uniform in area; a few stations see the
points that face them, more of those that face them squarely. (One part of a shape never hides another.)
Shapes of several surfaces show a second one with as many points as no neighbour in a scan has. Pose, unit,
outliers and rounding are those of the scanner's clouds.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from .clouds import SyntheticCloud
from .noise import sigma_weights
from .recipes import KINDS, ForeignRecipe, Range, ScannerRecipe
from .scanner import (
    MOST_DOMINANT_NEIGHBOUR,
    STANDOFF,
    STEEPEST,
    Sight,
    counts,
    deliver,
    log_uniform,
    random_rotation,
    views_of,
)

Array = NDArray[np.float64]
Surface = tuple[Array, Array]

STATIONS = 3
TOLERABLE = 0.01
"""The largest noise and the coarsest rounding, as a share of the extent."""
LARGEST_PART = 1.0 - MOST_DOMINANT_NEIGHBOUR
"""Most points on one surface of a shape of several: beside more, the others could be a scan's neighbours."""
TRIES = 50
"""Views of a shape at most, until one shows enough of a second surface: all of a corner do, of a capped
cylinder 93 in 100."""
SECOND_SIZE = Range(0.4, 1.0)
SECOND_SHARE = Range(0.3, 0.7)
"""Of two primitives: extent of the second over that of the first, and its share of the points."""


def accepted(rng: Generator, weights: Array) -> NDArray[np.intp]:
    """Places kept with probabilities in proportion to their weights."""
    return np.flatnonzero(rng.random(len(weights)) * weights.max() < weights)


def directions(rng: Generator, count: int) -> Array:
    """Uniform on the unit sphere."""
    vectors = rng.standard_normal((count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def ellipsoid(rng: Generator, count: int) -> Surface:
    """Semi-axes 1, b and c that differ by a fifth at least."""
    middle = rng.uniform(0.4, 0.8)
    axes = np.array([1.0, middle, rng.uniform(0.25, 0.8 * middle)])
    sphere = directions(rng, count)
    # The area of the sphere is stretched by abc |x / axes|.
    chosen = sphere[accepted(rng, np.linalg.norm(sphere / axes, axis=1))]
    normals = chosen / axes
    return chosen * axes, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def corner(rng: Generator, count: int) -> Surface:
    """Three faces of a box that meet in a vertex, seen from outside or from within."""
    sides = rng.uniform(0.5, 1.0, 3)
    areas = sides.prod() / sides
    face = rng.choice(3, count, p=areas / areas.sum())
    points = rng.random((count, 3)) * sides
    points[np.arange(count), face] = 0.0
    return points, -np.eye(3)[face] * rng.choice([-1.0, 1.0])


def capped_cylinder(rng: Generator, count: int) -> Surface:
    """A cylinder of radius 1 with both ends, flat or half spheres."""
    half = rng.uniform(0.5, 2.5)
    sphere = directions(rng, count)
    normals = sphere.copy()
    if rng.random() < 0.5:
        on_side = rng.random(count) < half / (half + 1.0)
        caps = sphere + np.sign(sphere[:, 2:]) * [0.0, 0.0, half]
    else:
        on_side = rng.random(count) < 2 * half / (2 * half + 1.0)
        normals[:, :2], normals[:, 2] = 0.0, np.sign(sphere[:, 2])
        caps = np.sqrt(rng.random((count, 1))) * sphere / np.linalg.norm(sphere[:, :2], axis=1, keepdims=True)
        caps[:, 2] = half * normals[:, 2]
    around = sphere.copy()
    around[:, 2] = 0.0
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    side = around + [0.0, 0.0, 1.0] * rng.uniform(-half, half, (count, 1))
    return np.where(on_side[:, None], side, caps), np.where(on_side[:, None], around, normals)


def saddle(rng: Generator, count: int) -> Surface:
    """z = a x^2 - b y^2 over a square."""
    a, b = rng.uniform(0.3, 1.0, 2)
    x, y = rng.uniform(-1.0, 1.0, (2, count))
    normals = np.column_stack([-2 * a * x, 2 * b * y, np.ones_like(x)])
    area = np.linalg.norm(normals, axis=1)
    chosen = accepted(rng, area)
    points = np.column_stack([x, y, a * x**2 - b * y**2])
    return points[chosen], normals[chosen] / area[chosen, None]


def blob(rng: Generator, count: int) -> Surface:
    """A sphere with six waves of random directions on it, star-shaped."""
    waves = directions(rng, 6) * rng.uniform(2.0, 5.0, (6, 1))
    phases, heights = rng.uniform(0.0, 2 * np.pi, 6), rng.uniform(0.04, 0.12, 6)
    sphere = directions(rng, count)
    angles = sphere @ waves.T + phases
    radius = 1.0 + np.cos(angles) @ heights
    # With r = f(u): the normal is along  u - grad f / r,  with grad f tangential at the unit vector u.
    slope = -(np.sin(angles) * heights) @ waves
    slope -= np.einsum("ij,ij->i", slope, sphere)[:, None] * sphere
    normals = sphere - slope / radius[:, None]
    return sphere * radius[:, None], normals / np.linalg.norm(normals, axis=1, keepdims=True)


@dataclass(frozen=True, eq=False)
class Seen:
    """Points with their unit rays, distances and cosines of the incidence, and the stations that saw them."""

    points: Array
    rays: Array
    distances: Array
    cosines: Array
    stations: Array
    station: NDArray[np.intp]

    def __getitem__(self, chosen: NDArray[np.intp]) -> "Seen":
        return Seen(
            self.points[chosen],
            self.rays[chosen],
            self.distances[chosen],
            self.cosines[chosen],
            self.stations,
            self.station[chosen],
        )


def seen(rng: Generator, shape: str, count: int) -> Seen:
    """`count` points of a shape that face one of a few stations, at most `LARGEST_PART` of several on one."""
    for _ in range(TRIES):
        view = looked_at(rng, shape, count)
        if shape not in PARTS or largest_share(PARTS[shape](view.points)) <= LARGEST_PART:
            return view
    raise RuntimeError(f"no {shape} showed a second surface")


def largest_share(part: NDArray[np.intp]) -> float:
    return float(np.unique(part, return_counts=True)[1].max() / len(part))


def looked_at(rng: Generator, shape: str, count: int) -> Seen:
    """`count` points of a shape that face one of a few stations."""
    for drawn in count * 12 * 4 ** np.arange(6) + 400:
        view = facing(rng, *SURFACES[shape](rng, int(drawn)), FRONTS.get(shape, 0.0 * ONES))
        if len(view.points) >= count:
            return view[np.sort(rng.permutation(len(view.points))[:count])]
    raise RuntimeError(f"no {shape} was seen with {count} points")


def facing(rng: Generator, points: Array, normals: Array, front: Array) -> Seen:
    """What one to three stations see of these points; each point is seen by one of those that it faces.

    All stations stand about `front` (in the signs of the mean normal) where it is not 0, so that they see
    what makes the shape foreign; else the first stands about the normal of a random point.
    """
    radius = np.linalg.norm(points, axis=1).max()
    ways = directions(rng, int(rng.integers(1, STATIONS, endpoint=True)))
    front = front * np.where(normals.mean(axis=0) < 0.0, -1.0, 1.0)
    if front.any():
        ways = 0.25 * ways + front
    else:
        ways[0] = 0.5 * ways[0] + normals[rng.integers(len(normals))]
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    stations = radius * log_uniform(rng, STANDOFF) * ways
    rays = points - stations[:, None]
    distances = np.linalg.norm(rays, axis=2)
    cosines = -np.einsum("snj,nj->sn", rays, normals) / distances
    density = np.where(cosines > np.cos(STEEPEST), cosines, 0.0)
    station = np.argmax(density * rng.random(density.shape), axis=0)
    at = station, np.arange(len(points))
    view = Seen(points, rays[at] / distances[at][:, None], distances[at], cosines[at], stations, station)
    return view[accepted(rng, density[at])]


def two_primitives(rng: Generator, count: int) -> Seen:
    """Two pieces of primitives, each as a scanner sees it, the second beside the first and turned."""
    share = rng.uniform(SECOND_SHARE.low, SECOND_SHARE.high)
    one, other = piece(rng, count - round(share * count)), piece(rng, round(share * count))
    turn, size = random_rotation(rng), rng.uniform(SECOND_SIZE.low, SECOND_SIZE.high)
    touched = one.points[rng.integers(len(one.points))]
    shift = touched * (1.0 + 0.3 * size / max(float(np.linalg.norm(touched)), 0.1))
    return Seen(
        np.concatenate([one.points, size * other.points @ turn.T + shift]),
        np.concatenate([one.rays, other.rays @ turn.T]),
        np.concatenate([one.distances, size * other.distances]),
        np.concatenate([one.cosines, other.cosines]),
        np.concatenate([one.stations, size * other.stations @ turn.T + shift]),
        np.concatenate([one.station, other.station + 1]),
    )


def piece(rng: Generator, count: int) -> Seen:
    """`count` points of a primitive from one station, centred, of extent 1."""
    _, (view, *_) = views_of(rng, ScannerRecipe(stations=1), str(rng.choice(KINDS)), count)
    chosen = np.sort(rng.permutation(len(view.ray))[:count])
    points = view.points[chosen]
    center, extent = points.mean(axis=0), np.linalg.norm(np.ptp(points, axis=0))
    return Seen(
        (points - center) / extent,
        view.directions[chosen],
        view.distance[chosen] / extent,
        view.cosine[chosen],
        (view.origin - center)[None] / extent,
        np.zeros(count, dtype=np.intp),
    )


ONES = np.ones(3)
FRONTS = {"corner": ONES / np.sqrt(3.0), "capped_cylinder": np.array([0.6, 0.0, 0.8])}
SURFACES: dict[str, Callable[[Generator, int], Surface]] = {
    "ellipsoid": ellipsoid,
    "corner": corner,
    "capped_cylinder": capped_cylinder,
    "saddle": saddle,
    "blob": blob,
}


def face_of(points: Array) -> NDArray[np.intp]:
    """Of a corner."""
    return np.argmin(np.abs(points), axis=1)


def side_or_cap(points: Array) -> NDArray[np.intp]:
    """Of a capped cylinder: 0 on its side, -1 and 1 on its ends."""
    on_side = np.isclose(np.hypot(points[:, 0], points[:, 1]), 1.0, rtol=0.0, atol=1e-12)
    return np.where(on_side, 0, np.sign(points[:, 2]).astype(np.intp))


PARTS: dict[str, Callable[[Array], NDArray[np.intp]]] = {"corner": face_of, "capped_cylinder": side_or_cap}
"""Of shapes of several surfaces: the number of the one that each point is on."""


def foreign_cloud(recipe: ForeignRecipe, index: int) -> SyntheticCloud:
    """Cloud `index` of a recipe, whatever was drawn before it; its primitive is None."""
    return cloud_and_shape(recipe, index)[0]


def cloud_and_shape(recipe: ForeignRecipe, index: int) -> tuple[SyntheticCloud, Array]:
    """The same, and the points of the shape that it is made of, without noise, in a unit of their own."""
    rng = np.random.default_rng([recipe.seed, index, 2])
    shape = recipe.shapes[index % len(recipe.shapes)]
    count, strays = counts(rng, recipe)
    view = two_primitives(rng, count) if shape == "two_primitives" else seen(rng, shape, count)
    extent = float(np.linalg.norm(np.ptp(view.points, axis=0)))
    noise = extent * log_uniform(rng, recipe.noise)
    along = noise * sigma_weights(view.distances, view.cosines) * rng.standard_normal(count)
    sight = Sight(
        shape,
        None,
        view.points + along[:, None] * view.rays,
        np.zeros(count, dtype=bool),
        view.stations,
        view.station,
        noise,
        extent,
        TOLERABLE * extent,
    )
    return deliver(rng, recipe.size, sight, strays, family="foreign"), view.points
