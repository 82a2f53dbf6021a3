# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Overdetermined linear systems, reweighted: many small ones at once. Bounds and axes of many points."""

from libc.math cimport INFINITY, sqrt
from libc.stdlib cimport free

import numpy as np

cdef extern from "geometry/median.h" nogil:
    bint absolutes(const double *distance, Py_ssize_t n, double *absolute)
    double median(double *values, Py_ssize_t n)

cdef extern from "geometry/small.h" nogil:
    double TINY
    enum:
        MOST
    bint solve(
        const double *normal, const double *gradient, const double *scales, double damping, int dof, double *step
    )

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


cdef void solve_overdetermined(
    const double *design, const double *target, Py_ssize_t n, int m, int rounds, double *room, double *solution
) noexcept nogil:
    """Reweighted least squares for  design (n, m) . solution = target (n,);  the room is (3, n).

    Weights are 1 / (1 + (residual / median)^2) after the first round.
    """
    cdef double normal[MOST * MOST]
    cdef double right[MOST]
    cdef double scales[MOST]
    cdef double *weight = room
    cdef double *residual = room + n
    cdef double *scratch = room + 2 * n
    cdef double weighted, trace, ridge, middle
    cdef const double *row
    cdef Py_ssize_t i
    cdef int j, l, turn
    for j in range(m):
        solution[j] = 0.0
    for i in range(n):
        weight[i] = 1.0
    for turn in range(rounds):
        for j in range(m):
            right[j] = 0.0
            for l in range(j + 1):
                normal[j * MOST + l] = 0.0
        for i in range(n):
            row = design + i * m
            for j in range(m):
                weighted = weight[i] * row[j]
                right[j] -= weighted * target[i]
                for l in range(j + 1):
                    normal[j * MOST + l] += weighted * row[l]
        trace = 0.0
        for j in range(m):
            trace += normal[j * MOST + j]
        for j in range(m):
            normal[j * MOST + j] += 1e-13 * trace + TINY
            scales[j] = sqrt(normal[j * MOST + j])
        ridge = 0.0
        while not solve(normal, right, scales, ridge, m, solution) and ridge < 1.0:
            ridge = max(1e3 * ridge, 1e-15)
        if turn + 1 == rounds:
            return
        for i in range(n):
            residual[i] = -target[i]
            row = design + i * m
            for j in range(m):
                residual[i] += row[j] * solution[j]
        if not absolutes(residual, n, scratch):
            return
        middle = median(scratch, n) + 1e-12
        for i in range(n):
            weight[i] = 1.0 / (1.0 + residual[i] / middle * (residual[i] / middle))


def solve_linear(const double[:, :, ::1] design, const double[:, ::1] target, int rounds):
    """Solutions (K, m) of  design (K, N, m) . x = target (K, N);  see `fitting.geometry.axes.robust_linear_solve`."""
    cdef Py_ssize_t k, n = design.shape[1]
    cdef int m = design.shape[2]
    if m > MOST:
        raise ValueError(f"at most {MOST} unknowns, not {m}")
    result = np.empty((design.shape[0], m))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(3 * n)
    with nogil:
        for k in range(design.shape[0]):
            solve_overdetermined(&design[k, 0, 0], &target[k, 0], n, m, rounds, room, &view[k, 0])
    free(room)
    return result


cdef bint enclose(const double[:, ::1] points, double *low, double *high) noexcept nogil:
    """The least and the greatest coordinates (3,) of points (N, 3); whether all are finite."""
    cdef double least[3]
    cdef double most[3]
    cdef double nothing[3]
    cdef double value
    cdef Py_ssize_t i
    cdef int axis
    for axis in range(3):
        least[axis], most[axis], nothing[axis] = INFINITY, -INFINITY, 0.0
    for i in range(points.shape[0]):
        for axis in range(3):
            value = points[i, axis]
            least[axis] = value if value < least[axis] else least[axis]
            most[axis] = value if value > most[axis] else most[axis]
            nothing[axis] += 0.0 * value
    for axis in range(3):
        low[axis], high[axis] = least[axis], most[axis]
    return nothing[0] + nothing[1] + nothing[2] == 0.0


def bounds(const double[:, ::1] points):
    """The least and the greatest coordinates (2, 3) of points (N, 3); and whether all are finite."""
    result = np.empty((2, 3))
    cdef double[:, ::1] view = result
    cdef bint finite
    with nogil:
        finite = enclose(points, &view[0, 0], &view[1, 0])
    return result, finite


cdef double product(const double *a, const double *b, Py_ssize_t n) noexcept nogil:
    """The inner product of columns (n,), in four sums."""
    cdef double first = 0.0, second = 0.0, third = 0.0, fourth = 0.0
    cdef Py_ssize_t i = 0
    while i + 4 <= n:
        first += a[i] * b[i]
        second += a[i + 1] * b[i + 1]
        third += a[i + 2] * b[i + 2]
        fourth += a[i + 3] * b[i + 3]
        i += 4
    while i < n:
        first += a[i] * b[i]
        i += 1
    return (first + second) + (third + fourth)


cdef void reflect(double *columns, Py_ssize_t n, int j, double[:, ::1] triangle) noexcept nogil:
    """Clear column j of columns (3, n) below its row j by a reflection, as LAPACK's dgeqr2; fill in row j."""
    cdef double *column = columns + j * n
    cdef double *other
    cdef double below, factor, diagonal, scale
    cdef Py_ssize_t i
    cdef int l
    triangle[j, j] = column[j]
    below = product(column + j + 1, column + j + 1, n - j - 1)
    if below > 0.0:
        diagonal = sqrt(column[j] * column[j] + below)
        if column[j] > 0.0:
            diagonal = -diagonal
        triangle[j, j] = diagonal
        scale = (diagonal - column[j]) * diagonal
        column[j] -= diagonal
        for l in range(j + 1, 3):
            other = columns + l * n
            factor = product(column + j, other + j, n - j) / scale
            for i in range(j, n):
                other[i] -= factor * column[i]
    for l in range(j + 1, 3):
        triangle[j, l] = columns[l * n + j]


def triangle_of(const double[:, ::1] points):
    """R (3, 3) of the factors Q R of points (N, 3), from which their centroid is taken; of two with a row of zeros."""
    cdef Py_ssize_t i, n = points.shape[0], rows = max(n, 3)
    cdef int axis
    cdef double total
    result = np.zeros((3, 3))
    cdef double[:, ::1] triangle = result
    cdef double *columns = room_for(3 * rows)
    with nogil:
        for axis in range(3):
            total = 0.0
            for i in range(n):
                total += points[i, axis]
            for i in range(n):
                columns[axis * rows + i] = points[i, axis] - total / n
            for i in range(n, rows):
                columns[axis * rows + i] = 0.0
        for axis in range(3):
            reflect(columns, rows, axis, triangle)
    free(columns)
    return result


def solve_circles(const double[:, ::1] x, const double[:, ::1] y, int rounds):
    """Solutions (K, 3) of  x^2 + y^2 = a x + b y + c;  see `fitting.geometry.axes.circles`."""
    cdef Py_ssize_t k, i, n = x.shape[1]
    result = np.empty((x.shape[0], 3))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(7 * n)
    cdef double *design = room + 3 * n
    cdef double *target = room + 6 * n
    with nogil:
        for k in range(x.shape[0]):
            for i in range(n):
                design[3 * i], design[3 * i + 1], design[3 * i + 2] = x[k, i], y[k, i], 1.0
                target[i] = x[k, i] * x[k, i] + y[k, i] * y[k, i]
            solve_overdetermined(design, target, n, 3, rounds, room, &view[k, 0])
    free(room)
    return result
