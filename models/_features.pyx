# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Features of a cloud that need no fit, each block in one pass; see `models.features`."""

from libc.math cimport INFINITY, fabs, log10, sqrt

import numpy as np

cdef extern from "cloud/jacobi.h" nogil:
    double dot(const double *a, const double *b)
    void eigen(double *entries, Py_ssize_t n, double *vectors)

cdef extern from "geometry/median.h" nogil:
    double selected(double *values, Py_ssize_t n, Py_ssize_t rank)


cdef inline Py_ssize_t evenly(Py_ssize_t i, Py_ssize_t count, Py_ssize_t n) noexcept nogil:
    """The i-th of `count` places that are evenly spread over n, the last one included."""
    if n <= count:
        return i
    return n - 1 if i + 1 == count else <Py_ssize_t> (i * ((n - 1.0) / (count - 1.0)))


cdef inline Py_ssize_t bin_of(double position, Py_ssize_t bins) noexcept nogil:
    """The unit bin of a position, the first or the last one if it is outside."""
    return 0 if not position > 0.0 else (bins - 1 if position >= bins else <Py_ssize_t> position)


cdef void axes_of(const double[:, ::1] vectors, double *values, double *axes) noexcept nogil:
    """Eigenvalues (3,), not negative, ascending, of the mean square of vectors (N, 3), and eigenvectors (3, 3)."""
    cdef double entries[6]
    cdef Py_ssize_t i, n = vectors.shape[0]
    cdef int j
    for j in range(6):
        entries[j] = 0.0
    for i in range(n):
        for j in range(3):
            entries[j] += vectors[i, j] * vectors[i, j]
        entries[3] += vectors[i, 0] * vectors[i, 1]
        entries[4] += vectors[i, 0] * vectors[i, 2]
        entries[5] += vectors[i, 1] * vectors[i, 2]
    for j in range(6):
        entries[j] /= n
    eigen(entries, 1, axes)
    for j in range(3):
        values[j] = max(entries[j], 0.0)


def radii(const double[:, ::1] points, const double[::1] center):
    """Points (N, 3) relative to a center, and their distances from it (N,)."""
    cdef Py_ssize_t i
    cdef int axis
    relative, distances = np.empty((points.shape[0], 3)), np.empty(points.shape[0])
    cdef double[:, ::1] off = relative
    cdef double[::1] radius = distances
    for i in range(points.shape[0]):
        for axis in range(3):
            off[i, axis] = points[i, axis] - center[axis]
        radius[i] = sqrt(dot(&off[i, 0], &off[i, 0]))
    return relative, distances


def chosen(const double[:, ::1] points, const double[:, ::1] normals, const Py_ssize_t[::1] order, Py_ssize_t most):
    """At most so many of the points (N, 3), evenly over their order (N,), centered, in rms radii; and their normals.

    With the center (3,) and the rms radius that they had.
    """
    cdef Py_ssize_t i, place, n = order.shape[0], count = min(n, most)
    cdef double squares = 0.0
    cdef double mean[3]
    cdef int axis
    center = np.empty(3)
    cdef double[::1] middle = center
    few, few_normals = np.empty((count, 3)), np.empty((count, 3))
    cdef double[:, ::1] off = few
    cdef double[:, ::1] normal = few_normals
    mean[0] = mean[1] = mean[2] = 0.0
    for i in range(count):
        place = order[evenly(i, count, n)]
        for axis in range(3):
            off[i, axis], normal[i, axis] = points[place, axis], normals[place, axis]
            mean[axis] += off[i, axis]
    for axis in range(3):
        middle[axis] = mean[axis] / count
    for i in range(count):
        for axis in range(3):
            off[i, axis] -= middle[axis]
        squares += dot(&off[i, 0], &off[i, 0])
    if squares > 0.0:
        squares = sqrt(squares / count)
        for i in range(count):
            for axis in range(3):
                off[i, axis] /= squares
    return few, few_normals, center, squares


def shape(const double[:, ::1] points):
    """Standard deviations (3,) along the principal axes, ascending."""
    cdef double values[3]
    cdef double axes[9]
    axes_of(points, values, axes)
    return np.array([sqrt(values[0]), sqrt(values[1]), sqrt(values[2])])


def gauss_map(const double[:, ::1] normals, Py_ssize_t bins):
    """Eigenvalues (3,) of the scatter of normals (N, 3), and the logarithm of the smallest; shares (3, bins)."""
    cdef Py_ssize_t i, n = normals.shape[0]
    cdef double values[3]
    cdef double axes[9]
    cdef int k
    cdef double cosine
    shares = np.zeros((3, bins))
    cdef double[:, ::1] share = shares
    axes_of(normals, values, axes)
    for i in range(n):
        for k in range(3):
            cosine = fabs(dot(&normals[i, 0], axes + 3 * k))
            share[k, bin_of(cosine * bins, bins)] += 1.0
    shares /= n
    return np.array([values[0], values[1], values[2], log10(values[0] + 1e-4)]), shares


def pairs(
    const double[:, ::1] points, const double[:, ::1] normals, Py_ssize_t most, Py_ssize_t bins,
    Py_ssize_t distance_bins, double width
):
    """Shares (bins, distance_bins) of all pairs of at most so many points (N, 3), evenly over their order.

    By |n1 . n2| and distance, and by the larger |d . n| of the two ends and distance.
    """
    cdef Py_ssize_t i, j, near, n = points.shape[0], count = min(n, most)
    cdef const double *normal
    cdef const double *other
    cdef double between[3]
    cdef double distance, direction
    cdef int axis
    cdef double[:, ::1] few = np.empty((count, 6))
    alike, across = np.zeros((bins, distance_bins)), np.zeros((bins, distance_bins))
    cdef double[:, ::1] share_alike = alike
    cdef double[:, ::1] share_across = across
    for i in range(count):
        for axis in range(3):
            few[i, axis] = points[evenly(i, count, n), axis]
            few[i, 3 + axis] = normals[evenly(i, count, n), axis]
    for i in range(count):
        normal = &few[i, 3]
        for j in range(i + 1, count):
            other = &few[j, 3]
            for axis in range(3):
                between[axis] = few[j, axis] - few[i, axis]
            distance = sqrt(dot(between, between))
            direction = max(fabs(dot(between, normal)), fabs(dot(between, other))) / max(distance, 1e-12)
            near = bin_of(distance / width, distance_bins)
            share_alike[bin_of(fabs(dot(normal, other)) * bins, bins), near] += 1.0
            share_across[bin_of(direction * bins, bins), near] += 1.0
    alike /= count * (count - 1) // 2
    across /= count * (count - 1) // 2
    return alike, across


def compared(const double[:, ::1] distances, double floor, double spread, double outlying):
    """Medians and means of the magnitudes of distances (K, N), at most 1 each, and what they cost, (K,) each.

    Costs are halves of the sums of squares over the square of `spread` times the smallest median, at least the floor,
    each counted up to `outlying`. Distances that are no numbers are 1.
    """
    cdef Py_ssize_t k, i, n = distances.shape[1]
    cdef double scale = INFINITY, total, share
    medians, means, costs = (np.zeros(distances.shape[0]) for _ in range(3))
    cdef double[::1] middle = medians
    cdef double[::1] mean = means
    cdef double[::1] cost = costs
    cdef double[::1] sizes = np.empty(n)
    with nogil:
        for k in range(distances.shape[0]):
            total = 0.0
            for i in range(n):
                sizes[i] = fabs(distances[k, i]) if fabs(distances[k, i]) < 1.0 else 1.0
                total += sizes[i]
            mean[k], middle[k] = total / n, selected(&sizes[0], n, n // 2)
            scale = min(scale, middle[k])
        scale = max(spread * scale, floor)
        for k in range(distances.shape[0]):
            for i in range(n):
                share = fabs(distances[k, i]) if fabs(distances[k, i]) < 1.0 else 1.0
                cost[k] += min(share * share / (scale * scale), outlying) / 2.0
    return medians, means, costs
