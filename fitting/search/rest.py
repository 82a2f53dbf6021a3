"""A surface and the scale of its noise, each at rest given the other, by Anderson's method.

Refining the surface at a scale and estimating the scale from what is left over, in turn, comes nearer by a
constant factor a round, which is hardly below 1 where a surface bends away from its cloud. The last rounds
tell how parameters and scale answer to each other: the next step goes where a linear map would be at rest.
Source: Anderson, "Iterative procedures for nonlinear integral equations", J. ACM 12, 1965; Walker and Ni,
"Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 2011.
"""

import math
from collections.abc import Callable

import numpy as np

from ..geometry.vectors import Array
from ..noise.kernels import Kernel
from ..noise.scale import CORE, CORE_DEVIATION, SCALE_AT_REST, core_scale
from ..primitives.primitive import Primitive
from ..solver import _descent
from ..solver.refine import CODES, refine, turn_back

ROUNDS = 40
"""Rounds after which rest is given up: of eight numbers a linear map needs nine, and a bent one some more."""

GAIN = 0.1
"""As many rounds as there are numbers, and one, must make the moves smaller by this factor."""

AT_REST = 1e-13
"""A round ends it all where it moves the surface by less than this share of the noise (root mean square over
the points) and the logarithm of the scale by as much."""

UNSEEN, STALLED = 1e-9, 3
"""Smaller moves are rounding if so many rounds have not made them smaller."""

FAR = 1.0
"""A step that moves the surface by more noise scales leaves what is linear."""

GROWN = 30.0
"""Moves that grow to so many times the smallest lead nowhere."""

AGREED = 1e-6
"""Relative difference from the scale that is found from scratch, beyond which it is another one."""

SMALLEST_CURVATURE = 1e-13
"""Of the cost along a direction, over that along others, below which rounding hides it."""


def at_rest(
    primitive: Primitive, scale: float, points: Array, smallest: float, factors: Array | None = None
) -> tuple[Primitive, float] | None:
    """The surface under a biweight, and the scale of the core of its distances, that a nearby pair leads to.

    The scale is at least the `smallest`. None where the pair leads to none, or not to one that costs less.
    """
    code, points, start = CODES[primitive.kind], np.ascontiguousarray(points), primitive.row()

    def pull(row: Array, scale: float) -> tuple[Array, Array, float]:
        return _descent.pull(
            code, row, points, Kernel.TUKEY, scale, CORE, CORE_DEVIATION, SCALE_AT_REST, factors
        )

    directions = _directions(pull(start, scale)[0])
    if directions is None:
        return None
    unit = scale * float(np.sqrt(len(points)))

    def pair(place: Array) -> tuple[Array, float]:
        row = _descent.stepped(code, start, unit * (directions @ place[:-1]))
        return row, scale * math.exp(place[-1])

    def move(place: Array) -> Array:
        row, size = pair(place)
        _, gradient, found = pull(row, size)
        turn_back(gradient, primitive.chart, start, row)
        return np.append(-(directions.T @ gradient / unit), math.log(max(found, smallest) / size))

    place = _still(move, primitive.dof + 1)
    if place is None:
        return None
    row, size = pair(place)
    end = type(primitive).from_row(row)
    return (end, size) if _agree(primitive, end, size, points, smallest, factors) else None


def _agree(
    before: Primitive, after: Primitive, scale: float, points: Array, smallest: float, factors: Array | None
) -> bool:
    """Whether a scale is what a surface leaves over, found from scratch, and the one before costs no less."""
    distance = np.abs(after.signed_distance(points))
    found = max(core_scale(distance if factors is None else factors * distance), smallest)
    costs = [
        refine(each, points, Kernel.TUKEY, scale, max_iterations=0, factors=factors).cost
        for each in (before, after)
    ]
    return abs(found - scale) <= AGREED * scale and costs[1] <= costs[0] * (1.0 + AGREED)


def _directions(normal: Array) -> Array | None:
    """Directions (dof, dof), in columns, in which J^T W J (dof, dof) is the identity; None if it has none."""
    sizes = np.sqrt(np.diagonal(normal))
    if not (np.all(np.isfinite(normal)) and sizes.min() > 0.0):
        return None
    values, vectors = np.linalg.eigh(normal / np.outer(sizes, sizes))
    if values[0] < SMALLEST_CURVATURE * values[-1]:
        return None
    return np.asarray(vectors / np.sqrt(values) / sizes[:, None])


def _still(move: Callable[[Array], Array], size: int) -> Array | None:
    """The place (size,) near 0 that `move` does not move, or None."""
    place, best, smallest, stalled, mark = np.zeros(size), np.zeros(size), np.inf, 0, np.inf
    places: list[Array] = []
    moves: list[Array] = []
    for turn in range(ROUNDS):
        step = move(place)
        length = float(np.linalg.norm(step))
        if not length <= GROWN * smallest:
            return None
        stalled = 0 if length < smallest else stalled + 1
        if length < smallest:
            best, smallest = place, length
        if smallest <= AT_REST or (smallest <= UNSEEN and stalled == STALLED):
            return best
        if turn % (size + 1) == size:
            if smallest > GAIN * mark:
                return None
            mark = smallest
        places, moves = [*places[-size:], place], [*moves[-size:], step]
        place = _mixed(places, moves)
        if not np.linalg.norm(place - places[-1]) <= FAR:
            return None
    return None


def _mixed(places: list[Array], moves: list[Array]) -> Array:
    """The next place: where the moves from the last places, if they are linear, vanish."""
    if len(moves) == 1:
        return places[0] + moves[0]
    places_by, moves_by = np.diff(places, axis=0).T, np.diff(moves, axis=0).T
    share = np.linalg.lstsq(moves_by, moves[-1], rcond=1e-12)[0]
    return np.asarray(places[-1] + moves[-1] - (places_by + moves_by) @ share)
