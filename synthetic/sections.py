"""Bars with the sections that are rolled, drawn and extruded: all sides, no ends, as clouds of points.

A section is an outline in the plane: a closed polygon, curves as many short sides. Two draws of a sort differ
in what makers vary (legs, walls, corners). Shapes after EN 10056 (angles), EN 10279 (channels), EN 10055
(tees) and EN 10365 (beams), with thicker walls.
"""

from collections.abc import Callable

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.distance import pdist

from .canonical import TURN
from .recipes import Range

Array = NDArray[np.float64]

ARC_SIDES = 360
"""Sides for a turn of a curve: they are at most 4e-5 radii off it."""
WALL = Range(0.1, 0.2)
"""Thickness of a wall over the longer leg."""
LEGS = Range(0.5, 1.0)
"""The shorter leg over the longer one."""
CORNERS = Range(0.2, 0.5)
"""Radius of rounded corners over the distance of the sides from the middle."""
STADIUM = Range(1.3, 2.0)
"""Length of a stadium over its width."""
STAR_POINTS, STAR_DEPTH = (5, 6, 8), Range(0.4, 0.7)
"""And the radius of a star's inner corners over that of its points."""
DENSE = 4000
"""Points of an outline that its deviations are computed from: three digits."""


def regular(faces: int) -> Array:
    """The corners (F, 2) of a regular polygon."""
    return circle_part(0.0, TURN, faces)[:-1]


def rectangle(width: float, height: float) -> Array:
    return np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]])


def circle_part(start: float, end: float, sides: int | None = None) -> Array:
    """Corners of the arc of the unit circle from one angle [rad] to another, both ends included."""
    sides = sides or max(2, round(ARC_SIDES * abs(end - start) / TURN))
    angles = np.linspace(start, end, sides + 1)
    return np.column_stack([np.cos(angles), np.sin(angles)])


def ellipse(ratio: float) -> Array:
    return circle_part(0.0, TURN)[:-1] * [ratio, 1.0]


def angle(rng: Generator) -> Array:
    """L"""
    leg, wall = uniform(rng, LEGS), uniform(rng, WALL)
    return np.array([[0, 0], [1, 0], [1, wall], [wall, wall], [wall, leg], [0, leg]], float)


def channel(rng: Generator) -> Array:
    """U"""
    leg, wall = uniform(rng, LEGS), uniform(rng, WALL)
    left = [[0, 0], [1, 0], [1, leg], [1 - wall, leg], [1 - wall, wall], [wall, wall], [wall, leg], [0, leg]]
    return np.array(left, float)


def tee(rng: Generator) -> Array:
    """T"""
    leg, wall = uniform(rng, LEGS), uniform(rng, WALL)
    right = np.array([[wall / 2, 0], [wall / 2, leg - wall], [0.5, leg - wall], [0.5, leg]])
    return mirrored(right)


def beam(rng: Generator) -> Array:
    """I"""
    flange, wall = uniform(rng, LEGS) / 2, uniform(rng, WALL)
    lower = [[flange, 0], [flange, wall], [wall / 2, wall]]
    upper = [[wall / 2, 1 - wall], [flange, 1 - wall], [flange, 1]]
    return mirrored(np.array(lower + upper))


def lipped_channel(rng: Generator) -> Array:
    """C: a channel whose legs end in lips"""
    leg, wall = uniform(rng, LEGS), uniform(rng, WALL)
    lip = wall + (0.5 - wall) * uniform(rng, LEGS) / 2
    outer = [[leg, 1 - lip], [leg, 1], [0, 1], [0, 0], [leg, 0], [leg, lip]]
    inner = [[leg - wall, wall], [wall, wall], [wall, 1 - wall], [leg - wall, 1 - wall]]
    return np.array([*outer, [leg - wall, lip], *inner, [leg - wall, 1 - lip]], float)


def mirrored(right: Array) -> Array:
    """An outline and its image at the y axis, closed; the right half is given from below."""
    return np.concatenate([right, right[::-1] * [-1.0, 1.0]])


def rounded_bar(rng: Generator, faces: int) -> Array:
    """A regular polygon at distance 1 from the middle, with round corners."""
    radius = uniform(rng, CORNERS)
    corners = regular(faces) * (1.0 - radius) / np.cos(np.pi / faces)
    arcs = [circle_part((k - 0.5) * TURN / faces, (k + 0.5) * TURN / faces) for k in range(faces)]
    return np.concatenate([corner + radius * arc for corner, arc in zip(corners, arcs, strict=True)])


def stadium(rng: Generator) -> Array:
    """Two half circles, joined by straight sides."""
    reach = np.array([uniform(rng, STADIUM) - 1.0, 0.0])
    right, left = circle_part(-TURN / 4, TURN / 4), circle_part(TURN / 4, 3 * TURN / 4)
    return np.concatenate([right + reach, left - reach])


def half_round(rng: Generator) -> Array:
    return circle_part(0.0, TURN / 2)


def star(rng: Generator) -> Array:
    points = int(rng.choice(STAR_POINTS))
    corners = regular(2 * points)
    corners[1::2] *= uniform(rng, STAR_DEPTH)
    return corners


def uniform(rng: Generator, law: Range) -> float:
    return float(rng.uniform(law.low, law.high))


SECTIONS: dict[str, Callable[[Generator], Array]] = {
    "3 faces": lambda rng: regular(3),
    "4 faces": lambda rng: regular(4),
    "5 faces": lambda rng: regular(5),
    "6 faces": lambda rng: regular(6),
    "7 faces": lambda rng: regular(7),
    "8 faces": lambda rng: regular(8),
    "6 faces, round corners": lambda rng: rounded_bar(rng, 6),
    "rectangle 1:1.5": lambda rng: rectangle(1.5, 1.0),
    "rectangle 1:2": lambda rng: rectangle(2.0, 1.0),
    "rectangle 1:3": lambda rng: rectangle(3.0, 1.0),
    "stadium": stadium,
    "ellipse 1:1.2": lambda rng: ellipse(1.2),
    "ellipse 1:1.5": lambda rng: ellipse(1.5),
    "half-round": half_round,
    "L": angle,
    "U": channel,
    "T": tee,
    "I": beam,
    "C": lipped_channel,
    "star": star,
}
"""The corners (C, 2) of an outline, by sort, counter-clockwise, in any size."""


def section(rng: Generator, sort: str) -> Array:
    """The corners (C, 2) of an outline of this sort whose largest width is 1."""
    corners = SECTIONS[sort](rng)
    return corners / pdist(corners).max()


def along(corners: Array, shares: Array) -> tuple[Array, Array]:
    """Points (N, 2) of a closed outline at these shares of its length, and unit vectors across it there."""
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    ends = np.cumsum(lengths)
    at = shares * ends[-1]
    side = np.minimum(np.searchsorted(ends, at, side="right"), len(sides) - 1)
    directions = sides[side] / lengths[side, None]
    points = corners[side] + (at - (ends - lengths)[side])[:, None] * directions
    return points, directions @ np.array([[0.0, -1.0], [1.0, 0.0]])


def bar(rng: Generator, corners: Array, length: float, count: int) -> tuple[Array, Array]:
    """Points (N, 3), uniform in area, of a bar along z with this outline, and unit normals."""
    points, normals = along(corners, rng.random(count))
    height = length * rng.uniform(-0.5, 0.5, count)
    return np.column_stack([points, height]), np.column_stack([normals, np.zeros(count)])


def deviation(corners: Array) -> float:
    """Root mean square distance of an outline from the circle or the line that is nearest: of the bar from
    the nearest cylinder along it, or the nearest plane."""
    points, _ = along(corners, (np.arange(DENSE) + 0.5) / DENSE)
    return min(from_circle(points), from_line(points))


def from_circle(points: Array) -> float:
    """Of points (N, 2), by least squares."""
    middle = points.mean(axis=0)
    start = [*middle, np.linalg.norm(points - middle, axis=1).mean()]
    found = least_squares(lambda circle: np.linalg.norm(points - circle[:2], axis=1) - circle[2], start)
    return float(np.sqrt(2.0 * found.cost / len(points)))


def from_line(points: Array) -> float:
    centered = points - points.mean(axis=0)
    return float(np.sqrt(max(np.linalg.eigvalsh(centered.T @ centered)[0], 0.0) / len(points)))
