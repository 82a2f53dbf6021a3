# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""A surface and the scale of its noise, each at rest given the other.

Refining the surface at a scale and estimating the scale from what is left over, in turn, comes nearer by a
constant factor a round, which is hardly below 1 where a surface bends away from its cloud. Anderson's method goes on
from there: the last rounds tell how parameters and scale answer to each other, and the next step goes where a linear
map would be at rest.
Source: Anderson, "Iterative procedures for nonlinear integral equations", J. ACM 12, 1965; Walker and Ni,
"Anderson acceleration for fixed-point iterations", SIAM J. Numer. Anal. 49, 2011.
"""

from libc.math cimport INFINITY, exp, fabs, isfinite, log, sqrt
from libc.stdlib cimport free
from libc.string cimport memcpy

import numpy as np

from ..solver._descent cimport BLOCK, assemble, columns, descend, load, store
from ..trial._limits cimport KINDS, MOST, Bounds, Held, Points, Surface, basis, dot, held_by, linearize

cdef extern from "geometry/small.h" nogil:
    void least_squares(double *columns, int n, int k, double *right, double least, double *solution)
    bint factor(const double *normal, int n, double least, double *scales, double *lower)

cdef extern from "noise/kernels.h" nogil:
    enum:
        TUKEY
    double cost_of(int kernel, double scale, const double *distance, Py_ssize_t n)

cdef extern from "noise/scale.h" nogil:
    bint absolutes(const double *distance, Py_ssize_t n, double *absolute)
    double core_from(
        double scale, const double *absolute, Py_ssize_t n, double core, double deviation, double rest
    )
    double core_of(
        const double *absolute, Py_ssize_t n, double *scratch, double core, double deviation, double rest
    )

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef double SCALE_AT_REST = 1e-12
"""Rounds end when the scale changes by less than this, relatively: then the path to it has no say."""

cdef double NEARLY = 0.03
"""A round that changes the scale by less than this, relatively, is followed by Anderson's method; should that fail,
the next one that changes it by less than this share of that."""

cdef int ROUNDS = 40
"""Rounds after which rest is given up: of eight numbers a linear map needs nine, and a bent one some more."""

cdef double GAIN = 0.1
"""As many rounds as there are numbers, and one, must make the moves smaller by this factor."""

cdef double AT_REST = 1e-13
"""A round ends it all where it moves the surface by less than this share of the noise (root mean square over the
points) and the logarithm of the scale by as much."""

cdef double UNSEEN = 1e-9
cdef int STALLED = 3
"""Smaller moves are rounding if so many rounds have not made them smaller."""

cdef double FAR = 1.0
"""A step that moves the surface by more noise scales leaves what is linear."""

cdef double GROWN = 30.0
"""Moves that grow to so many times the smallest lead nowhere."""

cdef double AGREED = 1e-6
"""Relative difference from the scale that is found from scratch, beyond which it is another one."""

cdef double SMALLEST_CURVATURE = 1e-13
"""Of the cost along a direction, over that along others, below which rounding hides it."""

cdef double DEPENDENT = 1e-12
"""Moves that others explain but for this share tell nothing new."""


cdef struct Core:
    # The numbers of `fitting.noise.scale`, and the smallest scale.
    double width, deviation, rest, smallest


cdef struct Way:
    # A pair of surface and scale that places are measured from, in noise scales, and rooms for its points.
    Surface start
    Points points
    Core core
    double scale, unit
    double scales[MOST]
    double lower[MOST * MOST]
    const long long *across
    int pairs, size
    double *distance
    double *absolute
    double *room


cdef void pair_at(const Way *way, const double *place, Surface *surface, double *scale) noexcept nogil:
    """The surface and the scale at a place."""
    cdef double step[MOST]
    cdef int i, k, dof = way.size - 1
    for i in range(dof - 1, -1, -1):
        step[i] = place[i]
        for k in range(i + 1, dof):
            step[i] -= way.lower[k * MOST + i] * step[k]
        step[i] /= way.lower[i * MOST + i]
    for i in range(dof):
        step[i] *= way.unit / way.scales[i]
    surface[0] = way.start
    KINDS[surface.kind].step(surface, step)
    scale[0] = way.scale * exp(place[dof])


cdef void turn_back(const Way *way, const Surface *surface, double *gradient) noexcept nogil:
    """Let a gradient be along the basis of the start: that of a turned axis is another one."""
    cdef double theirs[6]
    cdef double ours[6]
    cdef double one, other
    cdef int pair, first
    basis(way.start.axis, theirs, theirs + 3)
    basis(surface.axis, ours, ours + 3)
    for pair in range(way.pairs):
        first = <int> way.across[2 * pair]
        one, other = gradient[first], gradient[first + 1]
        gradient[first] = one * dot(ours, theirs) + other * dot(ours + 3, theirs)
        gradient[first + 1] = one * dot(ours, theirs + 3) + other * dot(ours + 3, theirs + 3)


cdef void move_from(const Way *way, const double *place, double *move) noexcept nogil:
    """Where one round leads from a place, less the place: a Gauss-Newton step, and the scale of what is left over."""
    cdef double normal[MOST * MOST]
    cdef double gradient[MOST]
    cdef double scale, found = 0.0
    cdef Surface surface
    cdef int i, k, dof = way.size - 1
    pair_at(way, place, &surface, &scale)
    assemble(&surface, way.points, TUKEY, scale, way.distance, way.room, normal, gradient)
    turn_back(way, &surface, gradient)
    for i in range(dof):
        move[i] = gradient[i] / way.scales[i]
        for k in range(i):
            move[i] -= way.lower[i * MOST + k] * move[k]
        move[i] /= way.lower[i * MOST + i]
    for i in range(dof):
        move[i] /= -way.unit
    if absolutes(way.distance, way.points.n, way.absolute):
        found = core_from(
            scale, way.absolute, way.points.n, way.core.width, way.core.deviation, way.core.rest
        )
    move[dof] = log(max(found, way.core.smallest) / scale)


cdef double length_of(const double *vector, int size) noexcept nogil:
    cdef double total = 0.0
    cdef int i
    for i in range(size):
        total += vector[i] * vector[i]
    return sqrt(total)


cdef void mix(const double *places, const double *moves, int count, int size, double *place) noexcept nogil:
    """The next place: where the moves (count, size) from the last places, if they are linear, vanish."""
    cdef double by[(MOST + 1) * (MOST + 1)]
    cdef double right[MOST + 1]
    cdef double share[MOST + 1]
    cdef int i, k
    cdef const double *last = moves + (count - 1) * size
    for k in range(count - 1):
        for i in range(size):
            by[k * size + i] = moves[(k + 1) * size + i] - moves[k * size + i]
    memcpy(right, last, size * sizeof(double))
    least_squares(by, size, count - 1, right, DEPENDENT, share)
    for i in range(size):
        place[i] = places[(count - 1) * size + i] + last[i]
        for k in range(count - 1):
            place[i] -= share[k] * (
                places[(k + 1) * size + i] - places[k * size + i]
                + moves[(k + 1) * size + i] - moves[k * size + i]
            )


cdef bint find_still(const Way *way, double *best) noexcept nogil:
    """The place near 0 that a round does not move; whether there is one."""
    cdef double places[(MOST + 2) * (MOST + 1)]
    cdef double moves[(MOST + 2) * (MOST + 1)]
    cdef double place[MOST + 1]
    cdef double move[MOST + 1]
    cdef double smallest = INFINITY, mark = INFINITY, length
    cdef int size = way.size, count = 0, stalled = 0, turn, i
    for i in range(size):
        place[i] = best[i] = 0.0
    for turn in range(ROUNDS):
        move_from(way, place, move)
        length = length_of(move, size)
        if not length <= GROWN * smallest:
            return False
        stalled += 1
        if length < smallest:
            stalled, smallest = 0, length
            memcpy(best, place, size * sizeof(double))
        if smallest <= AT_REST or (smallest <= UNSEEN and stalled == STALLED):
            return True
        if turn % (size + 1) == size:
            if smallest > GAIN * mark:
                return False
            mark = smallest
        if count == size + 1:
            for i in range(size * size):
                places[i], moves[i] = places[i + size], moves[i + size]
            count -= 1
        memcpy(places + count * size, place, size * sizeof(double))
        memcpy(moves + count * size, move, size * sizeof(double))
        count += 1
        mix(places, moves, count, size, place)
        for i in range(size):
            move[i] = place[i] - places[(count - 1) * size + i]
        if not length_of(move, size) <= FAR:
            return False
    return False


cdef double scale_of(const Core *core, const double *distance, Py_ssize_t n, double *room) noexcept nogil:
    """The scale of distances (n,), from scratch; the room is for (2, n)."""
    if not absolutes(distance, n, room):
        return INFINITY
    return max(core_of(room, n, room + n, core.width, core.deviation, core.rest), core.smallest)


cdef bint come_to_rest(
    Surface *surface, double *scale, Points points, const Core *core, const long long *across, int pairs,
    double *room
) noexcept nogil:
    """The pair of surface and scale that a nearby one leads to, if it costs no more; whether there is one.

    The room is for 3 numbers of each point, and that of `assemble`.
    """
    cdef Way way
    cdef double normal[MOST * MOST]
    cdef double gradient[MOST]
    cdef double place[MOST + 1]
    cdef Surface end
    cdef double size, before
    cdef Py_ssize_t n = points.n
    way.start, way.points, way.core, way.scale = surface[0], points, core[0], scale[0]
    way.unit, way.across, way.pairs = scale[0] * sqrt(<double> n), across, pairs
    way.size = KINDS[surface.kind].dof + 1
    way.distance, way.absolute, way.room = room, room + n, room + 3 * n
    assemble(surface, points, TUKEY, scale[0], way.distance, way.room, normal, gradient)
    if not factor(normal, way.size - 1, SMALLEST_CURVATURE, way.scales, way.lower):
        return False
    if not find_still(&way, place):
        return False
    pair_at(&way, place, &end, &size)
    linearize(surface, points, way.distance, NULL)
    before = cost_of(TUKEY, size, way.distance, n)
    linearize(&end, points, way.distance, NULL)
    if not fabs(scale_of(core, way.distance, n, way.absolute) - size) <= AGREED * size:
        return False
    if not cost_of(TUKEY, size, way.distance, n) <= before * (1.0 + AGREED):
        return False
    surface[0], scale[0] = end, size
    return True


cdef double settle(
    Surface *surface, Points points, int steps, int rounds, const Core *core, const long long *across, int pairs,
    const Held *limits, double *room
) noexcept nogil:
    """Refine and estimate the scale in turn, until both rest; the scale. The room is as in `come_to_rest`."""
    cdef double scale = 0.0, before, change, cost, nearly = NEARLY
    cdef double *distance = room
    cdef Py_ssize_t n = points.n
    cdef bint rest
    cdef int turn
    for turn in range(rounds):
        linearize(surface, points, distance, NULL)
        before, scale = scale, scale_of(core, distance, n, room + n)
        if not isfinite(scale):
            return scale
        rest = descend(surface, points, TUKEY, scale, steps, distance, room + 3 * n, &cost, limits)
        change = fabs(scale - before)
        if change <= SCALE_AT_REST * scale and (rest or limits != NULL):
            break
        if change <= nearly * scale and limits == NULL:
            nearly *= NEARLY
            if come_to_rest(surface, &scale, points, core, across, pairs, room):
                break
    return scale


def with_its_scale(
    int kind, const double[::1] row, const double[:, ::1] points, double smallest, int steps, int rounds,
    const long long[:, ::1] across, double width, double deviation, double rest, const double[::1] factors=None,
    Bounds limits=None
):
    """The row (9,) under a biweight, the scale of the core of its distances, at rest with each other, and these (N,).

    `smallest` is the least scale, `across` (P, 2) the pairs of components of a step along the basis of an axis, and
    `width`, `deviation`, `rest` are the numbers of `fitting.noise.scale`. So many `rounds` are taken at most, of so
    many `steps`. Within limits there are only rounds. The distances are without the `factors` (N,).
    """
    cdef Py_ssize_t n = points.shape[0]
    cdef const Held *within = held_by(limits)
    cdef int pairs = across.shape[0]
    cdef const long long *first = &across[0, 0] if pairs else NULL
    cdef Surface surface
    cdef Points seen
    cdef double scale
    cdef Core core
    core.width, core.deviation, core.rest, core.smallest = width, deviation, rest, smallest
    result, distance = np.empty(9), np.empty(n)
    cdef double[::1] view = result
    cdef double[::1] distance_view = distance
    cdef double *room = room_for(6 * n + (2 + MOST) * BLOCK)
    load(&surface, kind, &row[0])
    with nogil:
        seen = columns(points, room)
        if factors is not None:
            seen.factor = &factors[0]
        scale = settle(&surface, seen, steps, rounds, &core, first, pairs, within, room + 3 * n)
        seen.factor = NULL
        linearize(&surface, seen, &distance_view[0], NULL)
    free(room)
    store(&surface, &view[0])
    return result, scale, distance
