# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What goes over all points where a surface is weighed."""

from libc.stdlib cimport free
from libc.string cimport memset

import numpy as np

from ..solver._descent cimport load
from ..trial._limits cimport KINDS, Points, Surface, linearize

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


def linear(int kind, const double[::1] row, const double[:, ::1] points, const double[::1] pivot=None):
    """Distances (N,) of points (N, 3), their derivatives (N, dof) by a step, and their feet (N, 3).

    The row (9,) is relative to the pivot (3,), the origin where there is none, about which the steps turn; points and
    feet are not.
    """
    cdef Py_ssize_t i, n = points.shape[0]
    cdef int k
    cdef Surface surface
    cdef Points seen
    cdef double[3] outward
    cdef double[3] origin = [0.0, 0.0, 0.0]
    residual, jacobian, feet = np.empty(n), np.empty((KINDS[kind].dof, n)), np.empty((n, 3))
    if not n:
        return residual, jacobian.T, feet
    cdef double[::1] distance = residual
    cdef double[:, ::1] slopes = jacobian, foot = feet
    cdef double *room = room_for(3 * n)
    load(&surface, kind, &row[0])
    if pivot is not None:
        origin = [pivot[0], pivot[1], pivot[2]]
    with nogil:
        for i in range(n):
            for k in range(3):
                room[k * n + i] = points[i, k] - origin[k]
        seen.x, seen.y, seen.z, seen.n, seen.factor = room, room + n, room + 2 * n, n, NULL
        linearize(&surface, seen, &distance[0], &slopes[0, 0])
        for i in range(n):
            KINDS[kind].outward(&surface, &slopes[0, i], n, outward)
            for k in range(3):
                foot[i, k] = points[i, k] - distance[i] * outward[k]
    free(room)
    return residual, jacobian.T, feet


def mostly(const Py_ssize_t[::1] patch, const unsigned char[::1] inlier):
    """Which of the inliers (N,), as 0 or 1, are in patches at least half of whose points are; patches have numbers."""
    cdef Py_ssize_t i, n = patch.shape[0], patches = 0
    cdef double *balance
    found = np.empty(n, np.uint8)
    cdef unsigned char[::1] mask = found
    for i in range(n):
        if patch[i] >= patches:
            patches = patch[i] + 1
    balance = room_for(patches)
    memset(balance, 0, patches * sizeof(double))
    for i in range(n):
        balance[patch[i]] += 1.0 if inlier[i] else -1.0
    for i in range(n):
        mask[i] = inlier[i] and balance[patch[i]] >= 0.0
    free(balance)
    return found
