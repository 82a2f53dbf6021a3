# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Halves of halves of a cloud."""

from libc.math cimport INFINITY
from libc.stdlib cimport free

import numpy as np

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


cdef void lower_half(double *keys, Py_ssize_t *order, Py_ssize_t n) noexcept nogil:
    """Let the n // 2 smallest keys (n,), and their places, come first; of equal keys those of lower places."""
    cdef Py_ssize_t low = 0, high = n - 1, rank = n // 2, i, j, place
    cdef double pivot, swap
    while low < high:
        pivot, place = keys[(low + high) // 2], order[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while keys[i] < pivot or (keys[i] == pivot and order[i] < place):
                i += 1
            while keys[j] > pivot or (keys[j] == pivot and order[j] > place):
                j -= 1
            if i <= j:
                swap = keys[i]
                keys[i] = keys[j]
                keys[j] = swap
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if rank <= j:
            high = j
        elif rank >= i:
            low = i
        else:
            break


cdef void halve(
    const double[:, ::1] points, Py_ssize_t *order, double *keys, Py_ssize_t n, int times, long long number,
    long long[::1] numbers
) noexcept nogil:
    """Number the n points of this order as halves of halves, so many times; keys (n,) is room."""
    cdef double least, most, widest = -1.0
    cdef Py_ssize_t i
    cdef int axis, along = 0
    if times == 0:
        for i in range(n):
            numbers[order[i]] = number
        return
    for axis in range(3):
        least, most = INFINITY, -INFINITY
        for i in range(n):
            least, most = min(least, points[order[i], axis]), max(most, points[order[i], axis])
        if most - least > widest:
            widest, along = most - least, axis
    for i in range(n):
        keys[i] = points[order[i], along]
    lower_half(keys, order, n)
    halve(points, order, keys, n // 2, times - 1, 2 * number, numbers)
    halve(points, order + n // 2, keys, n - n // 2, times - 1, 2 * number + 1, numbers)


def halves(const double[:, ::1] points, int times):
    """Numbers (N,) of the pieces of points (N, 3) that halving so many times leaves; see `fitting.cloud.patches`."""
    cdef Py_ssize_t i, n = points.shape[0]
    numbers = np.empty(n, np.int64)
    cdef long long[::1] view = numbers
    cdef double *keys = room_for(2 * n)
    cdef Py_ssize_t *order = <Py_ssize_t *> (keys + n)
    with nogil:
        for i in range(n):
            order[i] = i
        halve(points, order, keys, n, times, 0, view)
    free(keys)
    return numbers
