# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What residuals cost, the scale of their core, and what random fields make of them."""

from libc.math cimport INFINITY, log
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
