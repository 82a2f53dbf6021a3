# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Bounds of many points, and the triangle that their principal axes come from."""

from libc.math cimport INFINITY, sqrt
from libc.stdlib cimport free

import numpy as np

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


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
