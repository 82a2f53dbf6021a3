# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What residuals cost, the scale of their core, and which are outliers."""

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
