# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What residuals cost, the scale of their core, and what random fields make of them."""

from libc.math cimport INFINITY, fabs, llrint, log, rint
from libc.stdlib cimport free
from libc.string cimport memcpy

import numpy as np

cdef extern from "noise/kernels.h" nogil:
    double rho_of(int kernel, double squared)
    double weight_of(int kernel, double squared)

cdef extern from "noise/scale.h" nogil:
    double core_of(
        const double *absolute, Py_ssize_t n, double *scratch, double core, double deviation, double rest
    )

cdef extern from "noise/factors.h" nogil:
    bint eliminate(double *rows, Py_ssize_t n, Py_ssize_t width)
    void substitute(double *rows, Py_ssize_t n, Py_ssize_t width)

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


cdef void covariance_beside(
    const double *white, const double *bells, const long long *which, const double *sizes, int parts,
    const double *columns, Py_ssize_t n, Py_ssize_t k, double *rows
) noexcept nogil:
    """Rows (n, n + k): the upper triangle of  diag(white) + sum sizes^2 bells[which],  and the columns beside it."""
    cdef Py_ssize_t i, j, width = n + k
    cdef int part
    cdef const double *bell
    cdef double square
    for i in range(n):
        for j in range(i, n):
            rows[i * width + j] = 0.0
        for part in range(parts):
            square = sizes[part] * sizes[part]
            if square > 0.0:
                bell = bells + (which[part] * n + i) * n
                for j in range(i, n):
                    rows[i * width + j] += square * bell[j]
        rows[i * width + i] += white[i]
        memcpy(rows + i * width + n, columns + i * k, k * sizeof(double))


def solve_fields(
    const double[::1] white, const double[:, :, ::1] bells, const long long[:, ::1] which,
    const double[:, ::1] sizes, const double[:, ::1] columns
):
    """Columns (P, K) solved by each covariance  C = diag(white) + sum sizes^2 bells[which]  of fields on P patches.

    A field is a row of `which` (T, parts) of the bells (B, P, P), and one of their sizes; size 0 leaves a part
    out. With Cholesky's factor C = L L^T returned are  L^-1 columns  and  C^-1 columns, (T, P, K),  and the
    logarithm of the determinant of L (T,), which is infinite where a covariance is not positive definite.
    """
    cdef Py_ssize_t t, i, n = columns.shape[0], k = columns.shape[1], fields = which.shape[0], width = n + k
    cdef int parts = which.shape[1]
    halves, solved, root = np.zeros((fields, n, k)), np.zeros((fields, n, k)), np.zeros(fields)
    cdef double[:, :, ::1] half = halves
    cdef double[:, :, ::1] whole = solved
    cdef double[::1] log_root = root
    cdef double *rows = room_for(n * width)
    with nogil:
        for t in range(fields):
            covariance_beside(
                &white[0], &bells[0, 0, 0], &which[t, 0], &sizes[t, 0], parts, &columns[0, 0], n, k, rows
            )
            if not eliminate(rows, n, width):
                log_root[t] = INFINITY
                continue
            for i in range(n):
                log_root[t] += log(rows[i * width + i])
                memcpy(&half[t, i, 0], rows + i * width + n, k * sizeof(double))
            substitute(rows, n, width)
            for i in range(n):
                memcpy(&whole[t, i, 0], rows + i * width + n, k * sizeof(double))
    free(rows)
    return halves, solved, root
