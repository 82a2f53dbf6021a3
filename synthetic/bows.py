"""Pieces of primitives that can be told, and the smooth ways in which real parts deviate from them.

Pieces lie in canonical position (centre, apex or a point at the origin, axis z); points are uniform in area.
A deviation is a field over the surface, to be put on along the normal: a *bow* bends a flat or long part,
*lobes* go around its axis, a *barrel* bulges along it. Source of the words: Whitehouse, "Handbook of Surface
and Nanometrology", 2nd ed. 2011, 2.4 (roundness, cylindricity).
"""

from collections.abc import Callable
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

from .canonical import ORIGIN, TURN, Z_AXIS
from .recipes import Range
from .scanner import log_uniform, random_rotation

Array = NDArray[np.float64]

WHOLE_PARTS = 0.4
"""How many parts go all around; as in the recipe `scanner`."""
ARC = Range(120.0, 360.0)
"""Degrees around the axis of the others (of a sphere: of its cap): a third of a turn is not mistaken."""
SWEEP, TUBE = Range(90.0, 360.0), Range(180.0, 360.0)
"""Degrees of a torus around its axis and around its tube."""
TORUS_RATIO = Range(1.5, 5.0)
HALF_ANGLE = Range(10.0, 50.0)
RADIUS_CHANGE = Range(1.5, 4.0)
"""The larger end of a cone over the smaller."""
LENGTH = Range(1.0, 6.0)
"""Of a cylinder, in radii."""
SIDES = Range(0.25, 1.0)
"""Shorter over longer side of a plane."""
LOBES = (2, 3, 4, 5)
"""What chucks, rollers and centreless grinding leave; one lobe is a shift."""


@dataclass(frozen=True, eq=False)
class Piece:
    """Points (N, 3) of a canonical primitive with two coordinates each, which deviations are functions of.

    Attributes
    ----------
    around : azimuth [rad] about the axis; of a plane about its middle
    along : -1 to 1 from end to end: of a cone on its generatrix, of a torus in its sweep, of a sphere on a
        random diameter that reaches from -1 to 1; of a plane the distance from its middle, 1 at the corner
    """

    primitive: Primitive
    points: Array
    around: Array
    along: Array


def draw_piece(rng: Generator, kind: str, count: int) -> Piece:
    """A piece of this kind; the radius of a sphere, cylinder or tube and the side of a plane are 1."""
    return PIECES[kind](rng, count)


def plane(rng: Generator, count: int) -> Piece:
    sides = np.array([1.0, log_uniform(rng, SIDES)])
    places = sides * rng.uniform(-0.5, 0.5, (count, 2))
    along = np.linalg.norm(places, axis=1) / (np.linalg.norm(sides) / 2)
    around = np.arctan2(places[:, 1], places[:, 0])
    return Piece(Plane(Z_AXIS, ORIGIN), np.column_stack([places, np.zeros(count)]), around, along)


def sphere(rng: Generator, count: int) -> Piece:
    """A cap, with lobes and barrel about a random diameter."""
    lowest = np.cos(_arc(rng, ARC) / 2)
    polar = np.arccos(rng.uniform(lowest, 1.0, count))
    ball = Sphere(ORIGIN, 1.0)
    points = ball.surface(rng.uniform(0.0, TURN, count), polar)
    x, y, z = random_rotation(rng) @ points.T
    return Piece(ball, points, np.arctan2(y, x), z)


def cylinder(rng: Generator, count: int) -> Piece:
    around, along = _arc(rng, ARC) * rng.uniform(-0.5, 0.5, count), rng.uniform(-1.0, 1.0, count)
    tube = Cylinder(Z_AXIS, ORIGIN, 1.0)
    return Piece(tube, tube.surface(around, log_uniform(rng, LENGTH) / 2 * along), around, along)


def cone(rng: Generator, count: int) -> Piece:
    """A frustum of slant 1 to its larger end."""
    angle = np.radians(rng.uniform(HALF_ANGLE.low, HALF_ANGLE.high))
    start = 1.0 / log_uniform(rng, RADIUS_CHANGE)
    around = _arc(rng, ARC) * rng.uniform(-0.5, 0.5, count)
    slant = np.sqrt(rng.uniform(start**2, 1.0, count))
    frustum = Cone(ORIGIN, Z_AXIS, float(angle))
    along = (2.0 * slant - 1.0 - start) / (1.0 - start)
    return Piece(frustum, frustum.surface(around, slant * np.cos(angle)), around, along)


def torus(rng: Generator, count: int) -> Piece:
    ratio, sweep, tube = log_uniform(rng, TORUS_RATIO), _arc(rng, SWEEP), _arc(rng, TUBE)
    middle = rng.uniform(-np.pi, np.pi)
    angles = np.empty(0)
    while len(angles) < count:
        drawn = middle + tube * rng.uniform(-0.5, 0.5, 2 * count)
        area = (ratio + np.cos(drawn)) / (ratio + 1.0)
        angles = np.append(angles, drawn[rng.random(2 * count) < area])
    along = rng.uniform(-1.0, 1.0, count)
    ring = Torus(ORIGIN, Z_AXIS, ratio, 1.0)
    return Piece(ring, ring.surface(sweep / 2 * along, angles[:count]), sweep / 2 * along, along)


def _arc(rng: Generator, law: Range) -> float:
    """Radians; a whole turn in a share `WHOLE_PARTS` of the parts."""
    degrees = 360.0 if rng.random() < WHOLE_PARTS else rng.uniform(law.low, law.high)
    return float(np.radians(degrees))


PIECES: dict[str, Callable[[Generator, int], Piece]] = {
    "plane": plane,
    "sphere": sphere,
    "cylinder": cylinder,
    "cone": cone,
    "torus": torus,
}


def bow(rng: Generator, piece: Piece) -> Array:
    """A plane: a dome or a sag in one direction. Others: the axis bends, across a random direction.

    A bent axis moves the surface along its normal by the sag times the cosine of the azimuth; the ring of a
    torus warps out of its plane as a saddle does, which moves it as the normal has a part along the axis.
    """
    turn = piece.around - rng.uniform(0.0, TURN)
    match piece.primitive:
        case Plane():
            across = 1.0 if rng.random() < 0.5 else np.cos(turn) ** 2
            return piece.along**2 * across
        case Torus():
            return piece.primitive.gradient(piece.points) @ piece.primitive.axis * np.cos(2.0 * turn)
    return piece.along**2 * np.cos(turn)


def lobe(rng: Generator, piece: Piece) -> Array:
    """Two to five lobes around the axis; on a sphere they fade towards the poles as sin^k does."""
    lobes = int(rng.choice(LOBES))
    wave = np.cos(lobes * (piece.around - rng.uniform(0.0, TURN)))
    if isinstance(piece.primitive, Sphere):
        return wave * (1.0 - piece.along**2) ** (lobes / 2)
    return wave


def barrel(rng: Generator, piece: Piece) -> Array:
    """A bulge along the axis, highest in the middle; of a torus, along the sweep of its tube."""
    return -(piece.along**2)


def piece_of(rng: Generator, truth: Primitive, points: Array) -> Piece:
    """Any points (N, 3) of a surface as a piece, about its own axis; of a sphere about a random one."""
    frame = np.linalg.svd(_axis(rng, truth)[None])[2][[1, 2, 0]]
    at = (points - _middle(truth, points)) @ frame.T
    around = np.arctan2(at[:, 1], at[:, 0])
    match truth:
        case Plane():
            along = np.linalg.norm(at[:, :2], axis=1)
            return Piece(truth, points, around, along / along.max())
        case Sphere():
            return Piece(truth, points, around, at[:, 2] / truth.radius)
        case Torus():
            middle = at.mean(axis=0)
            around = np.mod(around - np.arctan2(middle[1], middle[0]) + np.pi, TURN) - np.pi
            return Piece(truth, points, around, _spread(around))
    return Piece(truth, points, around, _spread(at[:, 2]))


def _axis(rng: Generator, truth: Primitive) -> Array:
    match truth:
        case Plane(normal=axis) | Cylinder(axis=axis) | Cone(axis=axis) | Torus(axis=axis):
            return axis
    return rng.standard_normal(3)


def _middle(truth: Primitive, points: Array) -> Array:
    match truth:
        case Sphere(center=middle) | Torus(center=middle) | Cylinder(point=middle) | Cone(apex=middle):
            return middle
    return np.asarray(points.mean(axis=0))


def _spread(values: Array) -> Array:
    """From -1 to 1."""
    return (2.0 * values - values.max() - values.min()) / np.ptp(values)


DEVIATIONS: dict[str, Callable[[Generator, Piece], Array]] = {"bow": bow, "lobe": lobe, "barrel": barrel}
"""Each gives a field (N,) of any size."""

DEVIATIONS_OF: dict[str, tuple[str, ...]] = {
    "plane": ("bow",),
    "sphere": ("lobe", "barrel"),
    "cylinder": ("bow", "lobe", "barrel"),
    "cone": ("bow", "lobe", "barrel"),
    "torus": ("bow", "lobe", "barrel"),
}
"""A sphere has no axis to bend and a plane none to go around."""
