# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Starts under robust kernels, and annealing, compiled."""

from libc.math cimport INFINITY, fabs, isfinite, log
from libc.stdlib cimport free

import numpy as np

from ..solver._descent cimport BLOCK, columns, descend, load, store
from ..trial._limits cimport MOST, Bounds, Held, Points, Surface, held_by, linearize

cdef extern from "noise/kernels.h" nogil:
    enum:
        GEMAN_MCCLURE

cdef extern from "noise/scale.h" nogil:
    bint absolutes(const double *distance, Py_ssize_t n, double *absolute)
    double median(double *values, Py_ssize_t n)
    double core_of(
        const double *absolute, Py_ssize_t n, double *scratch, double core, double deviation, double rest
    )

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef double NEARLY_AT_REST = 1e-3
"""Relative change of a scale that ends its rounds in annealing."""


cdef void step_robustly(
    Surface *surface, Points points, double smallest, double widths, int steps, double *distance,
    double *absolute, double *room, const Held *limits = NULL
) noexcept nogil:
    """Steps under Geman-McClure kernels `widths` times the median distance wide, at least `smallest`.

    A surface whose distances are not finite stays as it is. `absolute` is room for (n,), `room` as in
    `descend`; `distance` (n,) holds the last distances.
    """
    cdef double cost
    cdef int turn
    linearize(surface, points, distance, NULL)
    for turn in range(steps):
        if not absolutes(distance, points.n, absolute):
            return
        descend(
            surface, points, GEMAN_MCCLURE, max(widths * median(absolute, points.n), smallest), 1, distance,
            room, &cost, limits
        )


def settle(
    int kind, const double[:, ::1] rows, const double[:, ::1] points, double smallest, double widths, int steps,
    Bounds limits=None
):
    """Rows (K, 9) after some robust steps, and their last distances (K, N); see `fitting.search.starts.settled`."""
    cdef const Held *within = held_by(limits)
    cdef Py_ssize_t k, n = points.shape[0]
    cdef Surface surface
    cdef Points seen
    result, last = np.empty((rows.shape[0], 9)), np.empty((rows.shape[0], n))
    cdef double[:, ::1] view = result
    cdef double[:, ::1] last_view = last
    cdef double *room = room_for(4 * n + (2 + MOST) * BLOCK)
    with nogil:
        seen = columns(points, room)
        for k in range(rows.shape[0]):
            load(&surface, kind, &rows[k, 0])
            step_robustly(
                &surface, seen, smallest, widths, steps, &last_view[k, 0], room + 3 * n, room + 4 * n, within
            )
            store(&surface, &view[k, 0])
    free(room)
    return result, last


def compete(
    int kind, const double[:, ::1] rows, const double[:, ::1] points, double smallest, double widths,
    double resolved, const long long[:, ::1] stages
):
    """The best of the rows (K, 9) after some stages, and its distances (N,); see `fitting.search.starts.compete`."""
    cdef Py_ssize_t k, i, n = points.shape[0], count, left = rows.shape[0], first
    cdef Py_ssize_t most = 5 * n + (2 + MOST) * BLOCK
    cdef double *room = room_for(most + left + left * sizeof(Surface) // sizeof(double))
    cdef double *costs = room + most
    cdef Surface *surfaces = <Surface *> (costs + left)
    cdef double *distance
    cdef double cost
    cdef Surface swap
    cdef Points seen
    cdef int stage
    if left == 0:
        raise ValueError("at least one start is needed")
    result, last = np.empty(9), np.empty(n)
    cdef double[::1] view = result
    cdef double[::1] last_view = last
    with nogil:
        for k in range(left):
            load(&surfaces[k], kind, &rows[k, 0])
        for stage in range(stages.shape[0]):
            count = min(n, stages[stage, 0])
            for i in range(count):
                k = i * (n - 1) // max(count - 1, 1)
                room[i], room[count + i], room[2 * count + i] = points[k, 0], points[k, 1], points[k, 2]
            seen.x, seen.y, seen.z, seen.n, seen.factor = room, room + count, room + 2 * count, count, NULL
            distance = room + 3 * count
            for k in range(left):
                step_robustly(
                    &surfaces[k], seen, smallest, widths, stages[stage, 1], distance, room + 4 * count,
                    room + 5 * count
                )
                costs[k] = 0.0
                for i in range(count):
                    costs[k] += log(fabs(distance[i]) + resolved)
                if not isfinite(costs[k]):
                    costs[k] = INFINITY
            for i in range(min(left, stages[stage, 2])):
                first = i
                for k in range(i + 1, left):
                    if costs[k] < costs[first]:
                        first = k
                swap, cost = surfaces[first], costs[first]
                surfaces[first], costs[first] = surfaces[i], costs[i]
                surfaces[i], costs[i] = swap, cost
            left = min(left, stages[stage, 2])
        store(&surfaces[0], &view[0])
        linearize(&surfaces[0], columns(points, room), &last_view[0], NULL)
    free(room)
    return result, last


def anneal(
    int kind, const double[::1] row, const double[:, ::1] points, double tolerance, double shrink, double locked,
    double at_noise, Py_ssize_t need, double core, double deviation, Bounds limits=None
):
    """Steps under a Geman-McClure kernel whose scale shrinks; see `fitting.search.anneal.anneal`.

    `shrink`, `locked` and `at_noise` are constants of `fitting.search.kind`, `core` and `deviation` of
    `fitting.noise.scale`. It ends at the tolerance, or where fewer than `need` points are within the scale. Returned
    are the last row (9,), and the row at the scale of the noise, or None where that was not reached.
    """
    cdef Py_ssize_t i, count, n = points.shape[0]
    cdef const Held *within = held_by(limits)
    cdef Surface surface, noisy
    cdef Points seen
    cdef double cost = 0.0, scale
    cdef bint reached = False
    cdef double *room = room_for(6 * n + (2 + MOST) * BLOCK)
    cdef double *distance = room + 3 * n
    cdef double *absolute = room + 4 * n
    cdef double *scratch = room + 5 * n
    load(&surface, kind, &row[0])
    with nogil:
        seen = columns(points, room)
        linearize(&surface, seen, distance, NULL)
        if absolutes(distance, n, absolute):
            scale = max(2.0 * median(absolute, n), tolerance)
            while True:
                descend(&surface, seen, GEMAN_MCCLURE, scale, 2, distance, room + 6 * n, &cost, within)
                if not absolutes(distance, n, absolute):
                    break
                if not reached and scale < at_noise * core_of(absolute, n, scratch, core, deviation, NEARLY_AT_REST):
                    noisy, reached = surface, True
                count = 0
                for i in range(n):
                    if absolute[i] < scale:
                        scratch[count] = absolute[i]
                        count += 1
                if count < need or scale <= tolerance:
                    break
                scale = max(tolerance, min(shrink * scale, locked * median(scratch, count)))
    free(room)
    result, at_scale = np.empty(9), np.empty(9)
    cdef double[::1] view = result
    store(&surface, &view[0])
    if not reached:
        return result, None
    view = at_scale
    store(&noisy, &view[0])
    return result, at_scale
