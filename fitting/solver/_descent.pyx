# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The inner loops of refinement, compiled: distances, their derivatives, Levenberg-Marquardt.

`geometry/surface.h` says what the row of a surface and a step hold, `primitives/KIND.h` has the formulas.
"""

from libc.math cimport fabs, isfinite, sqrt
from libc.stdlib cimport free
from libc.string cimport memcpy

import numpy as np

from ..trial._limits cimport (
    COUNT, KINDS, MOST, Bounds, Held, Points, Surface, held_by, keep_within, linearize, solve, solve_within
)

cdef extern from "noise/kernels.h" nogil:
    double cost_of(int kernel, double scale, const double *distance, Py_ssize_t n)

cdef extern from "solver/equations.h" nogil:
    void normal_equations(
        int kernel, double scale, const double *distance, const double *jacobian, Py_ssize_t n, int dof,
        double *scratch, double *normal, int width, double *gradient
    )

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

NAMES = tuple(KINDS[code].name.decode() for code in range(COUNT))
"""Of the kinds, by their numbers."""

cdef double SMALLEST_STEP = 1e-15
"""Steps below this length, in a frame of extent near 1, change nothing any more."""
cdef double UNSEEN = 1e-13
cdef int LAST_STEPS = 3
"""Relative gains below this drown in the rounding of the cost: such steps are trusted, and so many of them in a row
are the last ones. They bring the digits that the cost does not show."""
cdef double LARGEST_DAMPING = 1e8


cdef void load(Surface *surface, int kind, const double *row) noexcept nogil:
    surface.kind = kind
    memcpy(surface.axis, row, 3 * sizeof(double))
    memcpy(surface.anchor, row + 3, 3 * sizeof(double))
    memcpy(surface.numbers, row + 6, 3 * sizeof(double))


cdef void store(const Surface *surface, double *row) noexcept nogil:
    memcpy(row, surface.axis, 3 * sizeof(double))
    memcpy(row + 3, surface.anchor, 3 * sizeof(double))
    memcpy(row + 6, surface.numbers, 3 * sizeof(double))


cdef Points columns(const double[:, ::1] points, double *room) noexcept nogil:
    """The points (N, 3) as three arrays in a room of 3 N numbers."""
    cdef Py_ssize_t i, n = points.shape[0]
    cdef Points result
    for i in range(n):
        room[i], room[n + i], room[2 * n + i] = points[i, 0], points[i, 1], points[i, 2]
    result.x, result.y, result.z, result.n, result.factor = room, room + n, room + 2 * n, n, NULL
    return result


cdef void assemble(
    const Surface *surface, Points points, int kernel, double scale, double *distance, double *room,
    double *normal, double *gradient
) noexcept nogil:
    """Distances (n,), and the sums of `normal_equations`, by blocks whose derivatives stay in the cache.

    The room is for (2 + dof) numbers of each point of a block.
    """
    cdef int dof = KINDS[surface.kind].dof, i, j
    cdef double part[MOST * MOST]
    cdef double pull[MOST]
    cdef ptrdiff_t start = 0, n = points.n
    cdef Points block = points
    for i in range(dof):
        gradient[i] = 0.0
        for j in range(i + 1):
            normal[i * MOST + j] = 0.0
    while start < n:
        block.n = min(BLOCK, n - start)
        block.x, block.y, block.z = points.x + start, points.y + start, points.z + start
        if points.factor != NULL:
            block.factor = points.factor + start
        linearize(surface, block, distance + start, room)
        normal_equations(
            kernel, scale, distance + start, room, block.n, dof, room + dof * block.n, part, MOST, pull
        )
        for i in range(dof):
            gradient[i] += pull[i]
            for j in range(i + 1):
                normal[i * MOST + j] += part[i * MOST + j]
        start += block.n


cdef bint descend(
    Surface *surface, Points points, int kernel, double scale, int max_iterations, double *distance,
    double *room, double *cost, const Held *limits = NULL
) noexcept nogil:
    """Levenberg-Marquardt, within the limits if there are any; whether it came to rest.

    `distance` (n,) is that of the surface, before and after; the room is as in `assemble`.
    """
    cdef int dof = KINDS[surface.kind].dof
    cdef Py_ssize_t n = points.n
    cdef double normal[MOST * MOST]
    cdef double gradient[MOST]
    cdef double scales[MOST]
    cdef double step[MOST]
    cdef double damping = 1e-12, largest, promised, new_cost, gain
    cdef bint solved = False
    cdef int unseen = 0
    cdef Surface candidate
    cdef int iteration, j
    cost[0] = cost_of(kernel, scale, distance, n)
    for iteration in range(max_iterations):
        assemble(surface, points, kernel, scale, distance, room, normal, gradient)
        largest = 1e-300
        for j in range(dof):
            if not isfinite(normal[j * MOST + j]) or not isfinite(gradient[j]):
                return False
            largest = max(largest, normal[j * MOST + j])
        for j in range(dof):
            scales[j] = normal[j * MOST + j] + 1e-14 * largest
        KINDS[surface.kind].level(scales)
        for j in range(dof):
            scales[j] = sqrt(scales[j])
        while True:
            if (
                solve(normal, gradient, scales, damping, dof, step) if limits == NULL
                else solve_within(surface, limits, normal, gradient, scales, damping, dof, step)
            ):
                solved = True
                largest = 0.0
                for j in range(dof):
                    largest = max(largest, fabs(step[j]))
                if largest <= SMALLEST_STEP:
                    linearize(surface, points, distance, NULL)
                    return True
                candidate = surface[0]
                KINDS[surface.kind].step(&candidate, step)
                if limits != NULL:
                    keep_within(&candidate, limits)
                linearize(&candidate, points, distance, NULL)
                new_cost = cost_of(kernel, scale, distance, n)
                if new_cost < cost[0]:
                    break
                promised = 0.0
                for j in range(dof):
                    promised -= 0.5 * gradient[j] * step[j] / (scale * scale)
                if promised <= UNSEEN * cost[0] and new_cost <= (1.0 + UNSEEN) * cost[0]:
                    break
            damping = max(damping * 64.0, 1e-4)
            if damping > LARGEST_DAMPING:
                linearize(surface, points, distance, NULL)
                return solved
        gain = cost[0] - new_cost
        surface[0] = candidate
        cost[0] = new_cost
        unseen = unseen + 1 if gain <= UNSEEN * new_cost else 0
        if unseen == LAST_STEPS:
            return True
        damping = max(damping * 0.1, 1e-12)
    return False


def distances(int kind, const double[::1] row, const double[:, ::1] points):
    """Signed distances (N,) of points (N, 3) from a surface (9,)."""
    cdef Py_ssize_t n = points.shape[0]
    cdef Surface surface
    distance = np.empty(n)
    cdef double[::1] view = distance
    cdef double *room = room_for(3 * n)
    if n:
        load(&surface, kind, &row[0])
        with nogil:
            linearize(&surface, columns(points, room), &view[0], NULL)
    free(room)
    return distance


def derivatives(int kind, const double[::1] row, const double[:, ::1] points):
    """Signed distances (N,) of points (N, 3) from a surface (9,), and their derivatives (N, dof) by a step."""
    cdef Py_ssize_t n = points.shape[0]
    cdef Surface surface
    distance, jacobian = np.empty(n), np.empty((KINDS[kind].dof, n))
    cdef double[::1] distance_view = distance
    cdef double[:, ::1] jacobian_view = jacobian
    cdef double *room = room_for(3 * n)
    if n:
        load(&surface, kind, &row[0])
        linearize(&surface, columns(points, room), &distance_view[0], &jacobian_view[0, 0])
    free(room)
    return distance, jacobian.T


def stepped(int kind, const double[::1] row, const double[::1] step):
    """The row (9,) after a step (dof,)."""
    cdef Surface surface
    result = np.empty(9)
    cdef double[::1] view = result
    if step.shape[0] != KINDS[kind].dof:
        raise ValueError(f"a step of {KINDS[kind].dof} components is needed, not {step.shape[0]}")
    load(&surface, kind, &row[0])
    KINDS[kind].step(&surface, &step[0])
    store(&surface, &view[0])
    return result


def refine(
    int kind, const double[::1] row, const double[:, ::1] points, int kernel, double scale, int max_iterations,
    const double[::1] factors=None, Bounds limits=None
):
    """The row (9,) that minimizes  sum rho(d / scale)  near the given one, the cost, and whether it is at rest.

    Distances are multiplied by `factors` (N,), where given.
    """
    cdef Py_ssize_t n = points.shape[0]
    cdef const Held *within = held_by(limits)
    cdef Surface surface
    cdef Points seen
    cdef double cost = 0.0
    cdef bint rest
    result = np.empty(9)
    cdef double[::1] view = result
    cdef double *room = room_for(4 * n + (2 + MOST) * BLOCK)
    cdef double *distance = room + 3 * n
    load(&surface, kind, &row[0])
    with nogil:
        seen = columns(points, room)
        if factors is not None:
            seen.factor = &factors[0]
        linearize(&surface, seen, distance, NULL)
        rest = descend(&surface, seen, kernel, scale, max_iterations, distance, distance + n, &cost, within)
    free(room)
    store(&surface, &view[0])
    return result, cost, bool(rest)

