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
        TUKEY
    double cost_of(int kernel, double scale, const double *distance, Py_ssize_t n)

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


cdef Points spread(const double[:, ::1] points, Py_ssize_t most, double *room) noexcept nogil:
    """At most so many of the points (N, 3), evenly over their order, as columns in the room."""
    cdef Py_ssize_t i, k, n = points.shape[0], count = min(n, most)
    cdef Points seen
    for i in range(count):
        k = i * (n - 1) // max(count - 1, 1)
        room[i], room[count + i], room[2 * count + i] = points[k, 0], points[k, 1], points[k, 2]
    seen.x, seen.y, seen.z, seen.n, seen.factor = room, room + count, room + 2 * count, count, NULL
    return seen


cdef void bring_forward(Surface *surfaces, double *costs, Py_ssize_t count, Py_ssize_t best) noexcept nogil:
    """So many of the cheapest surfaces to the front, in order; of equal ones the earlier."""
    cdef Py_ssize_t i, k, first
    cdef Surface swap
    cdef double cost
    for i in range(best):
        first = i
        for k in range(i + 1, count):
            if costs[k] < costs[first]:
                first = k
        swap, cost = surfaces[first], costs[first]
        for k in range(first, i, -1):
            surfaces[k], costs[k] = surfaces[k - 1], costs[k - 1]
        surfaces[i], costs[i] = swap, cost


def race(
    int kind, const double[:, ::1] rows, const double[:, ::1] points, double smallest, double widths,
    double resolved, const long long[:, ::1] stages, Bounds limits=None
):
    """Those of the rows (K, 9) that are left after some stages, (L, 9), the best first, and their distances (L, N).

    See `fitting.search.starts.race`; all of them are finite.
    """
    cdef const Held *within = held_by(limits)
    cdef Py_ssize_t k, i, n = points.shape[0], left = rows.shape[0], most = 5 * n + (2 + MOST) * BLOCK
    cdef double *room = room_for(most + left + left * sizeof(Surface) // sizeof(double))
    cdef double *costs = room + most
    cdef Surface *surfaces = <Surface *> (costs + left)
    cdef double *distance
    cdef Points seen
    cdef int stage
    seen.n = 0
    with nogil:
        for k in range(left):
            load(&surfaces[k], kind, &rows[k, 0])
        for stage in range(stages.shape[0]):
            seen = spread(points, stages[stage, 0], room)
            distance = room + 3 * seen.n
            for k in range(left):
                step_robustly(
                    &surfaces[k], seen, smallest, widths, stages[stage, 1], distance, room + 4 * seen.n,
                    room + 5 * seen.n, within
                )
                costs[k] = 0.0
                for i in range(seen.n):
                    costs[k] += log(fabs(distance[i]) + resolved)
                if not isfinite(costs[k]):
                    costs[k] = INFINITY
            bring_forward(surfaces, costs, left, min(left, stages[stage, 2]))
            left = min(left, stages[stage, 2])
        while left > 0 and costs[left - 1] == INFINITY:
            left -= 1
    result, last = np.empty((left, 9)), np.empty((left, seen.n))
    cdef double[:, ::1] view = result
    cdef double[:, ::1] last_view = last
    for k in range(left):
        store(&surfaces[k], &view[k, 0])
        linearize(&surfaces[k], seen, &last_view[k, 0], NULL)
    free(room)
    return result, last


def distinct(const double[:, ::1] distances, double same, int most):
    """Numbers of the first rows (K, N) whose magnitudes differ from those of all before, at most so many.

    Two are the same where they differ by less than this share of the earlier one, in the mean square.
    """
    cdef Py_ssize_t n = distances.shape[1], i, j, k
    cdef double apart, size
    chosen = []
    for k in range(distances.shape[0]):
        for j in chosen:
            apart = size = 0.0
            for i in range(n):
                apart += (fabs(distances[k, i]) - fabs(distances[j, i])) ** 2
                size += distances[j, i] ** 2
            if not apart > same * same * size:
                break
        else:
            chosen.append(k)
            if len(chosen) == most:
                break
    return chosen


def cheapest(const double[:, ::1] distances, double smallest):
    """Number of the row (K, N) that costs least under a biweight, at the smallest of their median magnitudes."""
    cdef Py_ssize_t n = distances.shape[1], k, best = 0
    cdef double scale = INFINITY, cost, least = INFINITY
    cdef double *room = room_for(n)
    with nogil:
        for k in range(distances.shape[0]):
            if absolutes(&distances[k, 0], n, room):
                scale = min(scale, median(room, n))
        for k in range(distances.shape[0]):
            cost = cost_of(TUKEY, max(scale, smallest), &distances[k, 0], n)
            if cost < least:
                least, best = cost, k
    free(room)
    return best


def anneal(
    int kind, const double[::1] row, const double[:, ::1] points, double tolerance, double shrink, double locked,
    double at_noise, Py_ssize_t need, double core, double deviation, Bounds limits=None
):
    """Steps under a Geman-McClure kernel whose scale shrinks; see `fitting.search.anneal.anneal`.

    `shrink`, `locked` and `at_noise` are constants of `fitting.search.kind`, `core` and `deviation` of
    `fitting.noise.scale`. It ends at the tolerance, or where fewer than `need` points are within the scale. Returned
    are the last row and, where that was reached, the one at the scale of the noise, (1 or 2, 9); and their distances.
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
    result, distances = np.empty((2, 9)), np.empty((2, n))
    cdef double[:, ::1] view = result
    cdef double[:, ::1] distance_view = distances
    store(&surface, &view[0, 0])
    linearize(&surface, seen, &distance_view[0, 0], NULL)
    if reached:
        store(&noisy, &view[1, 0])
        linearize(&noisy, seen, &distance_view[1, 0], NULL)
    free(room)
    return result[: 1 + reached], distances[: 1 + reached]
