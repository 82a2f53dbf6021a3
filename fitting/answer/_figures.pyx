# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What distances are like, in one pass over them."""

from libc.math cimport sqrt
from libc.stdlib cimport free

cdef extern from "answer/figures.h" nogil:
    ctypedef struct Figures:
        double squares, sum, largest, lowest, highest, near_squares, near_lowest, near_highest
        Py_ssize_t near

    Figures figures_of(const double *signed_, const double *judged, Py_ssize_t n, double reach, double *absolute)
    double quantile(double *values, Py_ssize_t n, double share)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


def figures(const double[::1] distance, const double[::1] judged, double reach, double share):
    """Numbers of signed distances (N,), N > 0.

    Their root mean square, mean magnitude, quantile of the magnitudes at `share`, and largest magnitude; the largest
    less the smallest distance; the root mean square of those that `judged` (N,) has within `reach`, and their largest
    less smallest, of all where there are none; and the share of these.
    """
    cdef Py_ssize_t n = distance.shape[0]
    cdef Figures found
    cdef double tail
    if not n or judged.shape[0] != n:
        raise ValueError(f"{n} distances, and {judged.shape[0]} that tell which belong to the surface")
    cdef double *absolute = room_for(n)
    with nogil:
        found = figures_of(&distance[0], &judged[0], n, reach, absolute)
        tail = quantile(absolute, n, share)
    free(absolute)
    rms = sqrt(found.squares / n)
    zone = found.highest - found.lowest
    near = sqrt(found.near_squares / found.near) if found.near else rms
    near_zone = found.near_highest - found.near_lowest if found.near else zone
    return rms, found.sum / n, tail, found.largest, zone, near, near_zone, found.near / <double>n
