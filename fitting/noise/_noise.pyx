# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What residuals cost, the scale of their core, and which are outliers."""

from libc.math cimport fabs, llrint, rint
from libc.stdlib cimport free

import numpy as np

cdef extern from "noise/kernels.h" nogil:
    double rho_of(int kernel, double squared)
    double weight_of(int kernel, double squared)

cdef extern from "noise/scale.h" nogil:
    double core_of(
        const double *absolute, Py_ssize_t n, double *scratch, double core, double deviation, double rest
    )

cdef extern from "noise/mixture.h" nogil:
    Py_ssize_t noise_among(
        const double *squared, Py_ssize_t n, const double *logs, double smallest, double width, double *scale
    )
    double mixed_likelihood(const double *squared, Py_ssize_t n, double scale, double share, double width)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


def costs(int kernel, const double[::1] squared):
    """Costs rho and weights (N,) of squared residuals (N,) in units of the scale."""
    cdef Py_ssize_t i
    cost, weight = np.empty(squared.shape[0]), np.empty(squared.shape[0])
    cdef double[::1] cost_view = cost
    cdef double[::1] weight_view = weight
    for i in range(squared.shape[0]):
        cost_view[i] = rho_of(kernel, squared[i])
        weight_view[i] = weight_of(kernel, squared[i])
    return cost, weight


def core_scale(const double[::1] absolute, double core, double deviation, double rest):
    """The scale of absolute values (N,); see `fitting.noise.scale.core_scale`."""
    cdef Py_ssize_t n = absolute.shape[0]
    cdef double scale
    cdef double *room = room_for(n)
    with nogil:
        scale = core_of(&absolute[0], n, room, core, deviation, rest) if n else 0.0
    free(room)
    return scale


cdef inline bint is_multiple(double value, double unit, double rounding) noexcept nogil:
    return fabs(value - unit * rint(value / unit)) <= rounding


def are_float32(const double[:, ::1] points):
    """Whether every coordinate of points (N, 3) is a float32 number."""
    cdef Py_ssize_t i
    cdef int axis
    for i in range(points.shape[0]):
        for axis in range(3):
            if <double> <float> points[i, axis] != points[i, axis]:
                return False
    return True


def common_unit(const double[:, ::1] points, const double[::1] units, double rounding):
    """Place of the first of the units that all coordinates of points (N, 3) are multiples of, within their rounding;
    the number of units if none is."""
    cdef Py_ssize_t i, which = 0
    with nogil:
        while which < units.shape[0]:
            for i in range(points.shape[0]):
                if not (
                    is_multiple(points[i, 0], units[which], rounding)
                    and is_multiple(points[i, 1], units[which], rounding)
                    and is_multiple(points[i, 2], units[which], rounding)
                ):
                    break
            else:
                break
            which += 1
    return which


def common_divisor(const double[:, ::1] points, double unit):
    """The greatest common divisor of the differences of points (N, 3), in units; 0 where there are none."""
    cdef long long divisor = 0, other
    cdef long long origin[3]
    cdef Py_ssize_t i
    cdef int axis
    with nogil:
        for axis in range(3):
            origin[axis] = llrint(points[0, axis] / unit)
        for i in range(points.shape[0]):
            for axis in range(3):
                other = llrint(points[i, axis] / unit) - origin[axis]
                while other:
                    divisor, other = other, divisor % other
            if divisor == 1 or divisor == -1:
                break
    return abs(divisor)


def mixture(const double[::1] squared, const double[::1] logs, double smallest, double width):
    """The scale of noise, the share of outliers, and the log-likelihood; see `fitting.noise.outliers`.

    Of squared distances (N,) in ascending order, and the logarithms of 1 to N or more.
    """
    cdef Py_ssize_t n = squared.shape[0], noise
    cdef double scale = smallest, share, likelihood
    if not n or logs.shape[0] < n:
        raise ValueError(f"{logs.shape[0]} logarithms do not do for {n} distances")
    with nogil:
        noise = noise_among(&squared[0], n, &logs[0], smallest, width, &scale)
        share = <double>(n - noise) / n
        likelihood = mixed_likelihood(&squared[0], n, scale, share, width)
    return scale, share, likelihood
