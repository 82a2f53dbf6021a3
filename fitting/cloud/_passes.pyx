# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What a few passes over all points of a cloud tell: moments, keys, and an order by them."""

from libc.math cimport llrint, sqrt
from libc.stdlib cimport free
from libc.string cimport memset

import numpy as np

ctypedef unsigned long long Key

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef enum:
    DIGIT_BITS = 11  # of a key that are sorted by at once ...
    DIGITS = 6  # ... and how many digits of that many bits a key has
    RADIX = 2048

cdef double TINY = 1e-300


def moments(const double[:, ::1] points, const double[::1] middle, double half):
    """Mean (3,) of the offsets (x - middle) / half of points (N, 3), and their mean square distance from it."""
    cdef Py_ssize_t i, n = points.shape[0]
    cdef double total[3]
    cdef double off, squares = 0.0
    cdef int axis
    mean = np.empty(3)
    cdef double[::1] view = mean
    with nogil:
        for axis in range(3):
            total[axis] = 0.0
        for i in range(n):
            for axis in range(3):
                off = (points[i, axis] - middle[axis]) / half
                total[axis] += off
                squares += off * off
        squares /= n
        for axis in range(3):
            view[axis] = total[axis] / n
            squares -= view[axis] * view[axis]
    return mean, squares


def normalized(const double[:, ::1] points, const double[::1] center, double scale):
    """(x - center) / scale  of points (N, 3); the scale is a power of two."""
    cdef Py_ssize_t i
    cdef int axis
    cdef double inverse = 1.0 / scale
    cdef double origin[3]
    result = np.empty((points.shape[0], 3))
    cdef double[:, ::1] view = result
    with nogil:
        for axis in range(3):
            origin[axis] = center[axis]
        for i in range(points.shape[0]):
            for axis in range(3):
                view[i, axis] = inverse * (points[i, axis] - origin[axis])
    return result


cdef inline double offset(
    const double *point, const double *origin, double extent, const double *mean, double *off
) noexcept nogil:
    """Fill in where a point is from the mean (3,), in extents; the squared distance."""
    cdef int axis
    for axis in range(3):
        off[axis] = point[axis] / extent - origin[axis] - mean[axis]
    return off[0] * off[0] + off[1] * off[1] + off[2] * off[2]


cdef void measure_distances(
    const double[:, ::1] points, const double[:, ::1] box, double resolved, Key *keys
) noexcept nogil:
    """Fill in keys (N,); see `fitting.cloud.order.distance_keys`."""
    cdef double low[3]
    cdef double mean[3]
    cdef double aside[3]
    cdef double off[3]
    cdef double extent = TINY, squared, second, unit, largest = 0.0, total = 0.0
    cdef Py_ssize_t i, n = points.shape[0]
    cdef int axis
    for axis in range(3):
        extent = max(extent, box[1, axis] / 2.0 - box[0, axis] / 2.0)
    for axis in range(3):
        low[axis] = box[0, axis] / extent
        mean[axis] = aside[axis] = 0.0
    for i in range(n):
        for axis in range(3):
            mean[axis] += points[i, axis] / extent - low[axis]
    for axis in range(3):
        mean[axis] /= n
    for i in range(n):
        squared = offset(&points[i, 0], low, extent, mean, off)
        largest = max(largest, squared)
        total += squared
        for axis in range(3):
            aside[axis] += squared * off[axis]
    for axis in range(3):
        aside[axis] /= max(total, TINY)
    unit = resolved * max(largest, TINY)
    for i in range(n):
        squared = offset(&points[i, 0], low, extent, mean, off)
        for axis in range(3):
            off[axis] -= aside[axis]
        second = off[0] * off[0] + off[1] * off[1] + off[2] * off[2]
        keys[i] = (<Key> llrint(squared / unit) << 32) + <Key> llrint(second / unit)


def distance_keys(const double[:, ::1] points, const double[:, ::1] box, double resolved):
    """Keys (N,) of points (N, 3) in a box (2, 3); see `fitting.cloud.order`."""
    keys = np.empty(points.shape[0], np.uint64)
    cdef Key[::1] view = keys
    if points.shape[0]:
        with nogil:
            measure_distances(points, box, resolved, &view[0])
    return keys


cdef void sort_by(
    Key *keys, Py_ssize_t *places, Py_ssize_t n, Key *keys_room, Py_ssize_t *places_room
) noexcept nogil:
    """Sort keys (n,), and places along with them; equal ones stay in their order. Digit by digit, the last first."""
    cdef unsigned int counts[DIGITS * RADIX]
    cdef unsigned int *count
    cdef unsigned int begin, many
    cdef Py_ssize_t i, to
    cdef Key key
    cdef int digit, value
    cdef bint away = False
    memset(counts, 0, sizeof(counts))
    for i in range(n):
        key = keys[i]
        for digit in range(DIGITS):
            counts[digit * RADIX + ((key >> (digit * DIGIT_BITS)) & (RADIX - 1))] += 1
    for digit in range(DIGITS):
        count = counts + digit * RADIX
        if n == 0 or count[(keys[0] >> (digit * DIGIT_BITS)) & (RADIX - 1)] == n:
            continue
        begin = 0
        for value in range(RADIX):
            many = count[value]
            count[value] = begin
            begin += many
        for i in range(n):
            value = (keys[i] >> (digit * DIGIT_BITS)) & (RADIX - 1)
            to = count[value]
            count[value] += 1
            keys_room[to], places_room[to] = keys[i], places[i]
        keys, keys_room = keys_room, keys
        places, places_room = places_room, places
        away = not away
    if away:
        for i in range(n):
            keys_room[i], places_room[i] = keys[i], places[i]


def sorted_places(const Key[::1] keys):
    """Places (N,) that sort keys (N,), equal ones in their order; and whether there are equal ones."""
    cdef Py_ssize_t i, n = keys.shape[0]
    cdef bint equal = False
    order = np.arange(n, dtype=np.intp)
    cdef Py_ssize_t[::1] view = order
    cdef Key *room = <Key *> room_for(3 * n)
    with nogil:
        for i in range(n):
            room[i] = keys[i]
        if n:
            sort_by(room, &view[0], n, room + n, <Py_ssize_t *> (room + 2 * n))
        for i in range(1, n):
            equal |= room[i] == room[i - 1]
    free(room)
    return order, equal


def hashed(const Key[::1] keys, Key multiplier):
    """Hashes (N,) of keys (N,); see `fitting.cloud.order`."""
    cdef Py_ssize_t i
    cdef Key mixed
    hashes = np.empty(keys.shape[0], np.uint64)
    cdef Key[::1] view = hashes
    with nogil:
        for i in range(keys.shape[0]):
            mixed = keys[i] * multiplier
            mixed = (mixed ^ (mixed >> 33)) * 0xFF51AFD7ED558CCDULL
            mixed = (mixed ^ (mixed >> 33)) * 0xC4CEB9FE1A85EC53ULL
            view[i] = mixed ^ (mixed >> 33)
    return hashes


def smallest(const Key[::1] hashes, Py_ssize_t count):
    """Places of the `count` smallest hashes (N,), all if there are fewer; ascending, equal ones in their order.

    Hashes are spread evenly, so few places are left of those below what that many, and some, should be below;
    if that is too few, all are sorted.
    """
    cdef Py_ssize_t i, found = 0, n = hashes.shape[0]
    cdef double share = (count + 8.0 * sqrt(count) + 16.0) / max(n, 1)
    cdef Key most = <Key> (share * 18446744073709551616.0) if share < 1.0 else 0xFFFFFFFFFFFFFFFFULL
    cdef Key *keys = <Key *> room_for(4 * n)
    cdef Py_ssize_t *places = <Py_ssize_t *> (keys + n)
    cdef Py_ssize_t taken
    with nogil:
        while True:
            found = 0
            for i in range(n):
                keys[found], places[found] = hashes[i], i
                found += hashes[i] <= most
            if found >= min(count, n):
                break
            most = 0xFFFFFFFFFFFFFFFFULL
        if found:
            sort_by(keys, places, found, keys + 2 * n, <Py_ssize_t *> (keys + 3 * n))
    taken = min(found, count)
    chosen = np.empty(taken, np.intp)
    cdef Py_ssize_t[::1] view = chosen
    for i in range(taken):
        view[i] = places[i]
    free(keys)
    return chosen


def told_apart(const Key[::1] keys):
    """Keys (N,) in order, and above their lowest 52 bits how many of the same stand before each."""
    cdef Py_ssize_t i
    cdef Key before = 0
    result = np.empty(keys.shape[0], np.uint64)
    cdef Key[::1] view = result
    for i in range(keys.shape[0]):
        before = before + 1 if i > 0 and keys[i] == keys[i - 1] else 0
        view[i] = keys[i] + (before << 52)
    return result


def firsts(const double[:, ::1] points):
    """Places of the points (N, 3) that are not the same as the one before."""
    cdef Py_ssize_t i, found = 0, n = points.shape[0]
    places = np.empty(n, np.intp)
    cdef Py_ssize_t[::1] view = places
    with nogil:
        for i in range(n):
            view[found] = i
            found += i == 0 or (
                points[i, 0] != points[i - 1, 0]
                or points[i, 1] != points[i - 1, 1]
                or points[i, 2] != points[i - 1, 2]
            )
    return places[:found]
