# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Halves of halves of a cloud: its pieces, and a tree that finds neighbors."""

from libc.math cimport INFINITY, sqrt
from libc.stdlib cimport free

import numpy as np

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef extern from "cloud/jacobi.h" nogil:
    void eigen(double *entries, Py_ssize_t n, double *vectors)

cdef enum:
    LEVELS = 48  # of halving, at most
    TRIALS = 8  # of a number that so many values are below


cdef struct Tree:
    # Points (n,) in order, piece by piece, and the boxes of the pieces: that of piece i is halved into 2 i, 2 i + 1.
    Py_ssize_t n
    int times
    double *x
    double *y
    double *z
    const Py_ssize_t *place
    double *boxes


cdef struct Near:
    # Which of the points of the tree are near, and their squared distances; there is room for all.
    Py_ssize_t count
    Py_ssize_t *which
    double *squared


cdef double of_rank(double *values, Py_ssize_t n, Py_ssize_t rank, double *room) noexcept nogil:
    """The value (n,) of this rank; the values and the room (n,) are lost.

    Quickselect that writes each value to both sides and counts it on one: no branch is there to be guessed.
    """
    cdef double pivot, value
    cdef double *lower
    cdef Py_ssize_t i, below, rest
    while True:
        pivot = values[n // 2]
        pivot = max(min(values[0], pivot), min(max(values[0], pivot), values[n - 1]))
        below, rest = 0, 0
        for i in range(n):
            value = values[i]
            room[below] = value
            values[rest] = value
            below += value < pivot
            rest += not value < pivot
        if rank < below:
            lower = room
            room, values, n = values, lower, below
            continue
        rank, n, rest = rank - below, rest, 0
        for i in range(n):
            value = values[i]
            values[rest] = value
            rest += value > pivot
        if rank < n - rest:
            return pivot
        rank, n = rank - (n - rest), rest


cdef double parting(
    const double *values, Py_ssize_t n, Py_ssize_t rank, double low, double high, double *room
) noexcept nogil:
    """A number that so many of the values (n,) are below, and some at it; all are from low to high, 0 < rank < n.

    Where values are spread as evenly as coordinates mostly are, few trials find a number between two of them. If
    not, it is the value of that rank. Twice as many numbers as values have room.
    """
    cdef Py_ssize_t i, count, below = 0, within = n
    cdef double guess, share
    cdef int trial
    for trial in range(TRIALS):
        share = 0.5 if trial % 3 == 2 else <double> (rank - below) / (within - below)
        guess = low + (high - low) * share
        count = 0
        for i in range(n):
            count += values[i] <= guess
        if count == rank:
            return guess
        if count < rank:
            low, below = guess, count
        else:
            high, within = guess, count
    for i in range(n):
        room[i] = values[i]
    return of_rank(room, n, rank, room + n)


cdef int enclose_widest(
    const double[:, ::1] points, const Py_ssize_t *order, Py_ssize_t n, double *low, double *high
) noexcept nogil:
    """The coordinate that n points of this order differ most in, and from where to where it goes."""
    cdef double least[3]
    cdef double most[3]
    cdef const double *point
    cdef Py_ssize_t i
    cdef int axis, along = 0
    for axis in range(3):
        least[axis], most[axis] = INFINITY, -INFINITY
    for i in range(n):
        point = &points[order[i], 0]
        for axis in range(3):
            least[axis] = point[axis] if point[axis] < least[axis] else least[axis]
            most[axis] = point[axis] if point[axis] > most[axis] else most[axis]
    for axis in range(1, 3):
        if most[axis] - least[axis] > most[along] - least[along]:
            along = axis
    low[0], high[0] = least[along], most[along]
    return along


cdef void halve(
    const double[:, ::1] points, Py_ssize_t *order, Py_ssize_t n, int times, double *keys, double *room
) noexcept nogil:
    """Order n points as halves of halves, so many times; there is room for n keys, and for twice as many."""
    cdef Py_ssize_t *upper = <Py_ssize_t *> room
    cdef Py_ssize_t i, place, low, high, equal, half = n // 2
    cdef double middle, key, least, most
    cdef int along
    cdef bint lower
    if times == 0 or n < 2:
        return
    along = enclose_widest(points, order, n, &least, &most)
    for i in range(n):
        keys[i] = points[order[i], along]
    middle = parting(keys, n, half, least, most, room)
    equal = half
    for i in range(n):
        equal -= keys[i] < middle
    low, high = 0, 0
    for i in range(n):
        place, key = order[i], keys[i]
        lower = (key < middle) | ((key == middle) & (equal > 0))
        equal -= key == middle
        order[low] = place
        upper[high] = place
        low += lower
        high += not lower
    for i in range(high):
        order[half + i] = upper[i]
    halve(points, order, half, times - 1, keys, room)
    halve(points, order + half, n - half, times - 1, keys, room)


def halves(const double[:, ::1] points, int times):
    """Places (N,) of points (N, 3), piece by piece, as halving so many times leaves them; see `fitting.cloud.patches`."""
    cdef Py_ssize_t i, n = points.shape[0]
    order = np.arange(n, dtype=np.intp)
    cdef Py_ssize_t[::1] view = order
    cdef double *keys = room_for(3 * n)
    with nogil:
        halve(points, &view[0], n, times, keys, keys + n)
    free(keys)
    return order


cdef void number(const Py_ssize_t *order, Py_ssize_t n, int times, Py_ssize_t first, Py_ssize_t[::1] numbers) noexcept nogil:
    """Number the pieces that halving so many times leaves of n places."""
    cdef Py_ssize_t i
    if times == 0:
        for i in range(n):
            numbers[order[i]] = first
        return
    number(order, n // 2, times - 1, 2 * first, numbers)
    number(order + n // 2, n - n // 2, times - 1, 2 * first + 1, numbers)


def numbered(const Py_ssize_t[::1] order, int times):
    """Number (N,) of the piece of each place, of those that halving so many times leaves in this order (N,)."""
    numbers = np.empty(order.shape[0], np.intp)
    cdef Py_ssize_t[::1] view = numbers
    with nogil:
        number(&order[0], order.shape[0], times, 0, view)
    return numbers


cdef void enclose(Tree *tree, Py_ssize_t piece, Py_ssize_t first, Py_ssize_t n, int times) noexcept nogil:
    """Fill the boxes (6,), lowest and highest corner, of a piece of n points from the first, and of its halves."""
    cdef double *box = tree.boxes + 6 * piece
    cdef const double *left
    cdef const double *right
    cdef const double *values
    cdef Py_ssize_t i
    cdef int axis
    if times == 0:
        for axis in range(3):
            values = tree.x if axis == 0 else (tree.y if axis == 1 else tree.z)
            box[axis], box[3 + axis] = INFINITY, -INFINITY
            for i in range(first, first + n):
                box[axis], box[3 + axis] = min(box[axis], values[i]), max(box[3 + axis], values[i])
        return
    enclose(tree, 2 * piece, first, n // 2, times - 1)
    enclose(tree, 2 * piece + 1, first + n // 2, n - n // 2, times - 1)
    left = tree.boxes + 12 * piece
    right = left + 6
    for axis in range(3):
        box[axis], box[3 + axis] = min(left[axis], right[axis]), max(left[3 + axis], right[3 + axis])


cdef inline double to_box(const double *box, const double *point) noexcept nogil:
    """Squared distance of a point from a box."""
    cdef double x = max(max(box[0] - point[0], point[0] - box[3]), 0.0)
    cdef double y = max(max(box[1] - point[1], point[1] - box[4]), 0.0)
    cdef double z = max(max(box[2] - point[2], point[2] - box[5]), 0.0)
    return x * x + y * y + z * z


cdef void admit(
    const Tree *tree, Py_ssize_t first, Py_ssize_t n, const double *point, double most, Near *near
) noexcept nogil:
    """Add those of n points of a piece that are not farther than this squared distance."""
    cdef Py_ssize_t i, count = 0
    cdef const double *x = tree.x + first
    cdef const double *y = tree.y + first
    cdef const double *z = tree.z + first
    cdef double px = point[0], py = point[1], pz = point[2], squared
    cdef double *found = near.squared + near.count
    cdef Py_ssize_t *which = near.which + near.count
    for i in range(n):
        found[i] = (x[i] - px) * (x[i] - px) + (y[i] - py) * (y[i] - py) + (z[i] - pz) * (z[i] - pz)
    for i in range(n):
        squared = found[i]
        found[count], which[count] = squared, first + i
        count += squared <= most
    near.count += count


cdef void search(
    const Tree *tree, Py_ssize_t piece, Py_ssize_t first, Py_ssize_t n, int times, const double *point,
    double most, Near *near
) noexcept nogil:
    """Add those points of a piece that are not farther than this squared distance."""
    if times == 0:
        admit(tree, first, n, point, most, near)
        return
    if to_box(tree.boxes + 12 * piece, point) <= most:
        search(tree, 2 * piece, first, n // 2, times - 1, point, most, near)
    if to_box(tree.boxes + 12 * piece + 6, point) <= most:
        search(tree, 2 * piece + 1, first + n // 2, n - n // 2, times - 1, point, most, near)


cdef double reach(const Tree *tree, Py_ssize_t k, const double *point, Near *near, double *room) noexcept nogil:
    """A squared distance within which k points are: those of a near piece, the smallest that has as many."""
    cdef Py_ssize_t i, piece = 1, first = 0, n = tree.n
    cdef double most = 0.0
    cdef int level
    for level in range(tree.times):
        if n // 2 < 2 * k:
            break
        piece = 2 * piece
        if to_box(tree.boxes + 6 * piece, point) > to_box(tree.boxes + 6 * piece + 6, point):
            piece, first, n = piece + 1, first + n // 2, n - n // 2
        else:
            n = n // 2
    near.count = 0
    admit(tree, first, n, point, INFINITY, near)
    for i in range(n):
        most = max(most, near.squared[i])
    return parting(near.squared, n, k, 0.0, most, room) if k < n else most


cdef void nearest(const Tree *tree, Py_ssize_t k, const double *point, Near *near, double *room) noexcept nogil:
    """Leave the k points nearest to a point; of those at one distance the earlier places are nearer."""
    cdef Py_ssize_t *kept = <Py_ssize_t *> room
    cdef Py_ssize_t i, count, next_place, last_place = -1, within = 0
    cdef double most = reach(tree, k, point, near, room)
    near.count = 0
    search(tree, 1, 0, tree.n, tree.times, point, most, near)
    count, near.count = near.count, k
    if count == k:
        return
    most = parting(near.squared, count, k, 0.0, most, room)
    for i in range(count):
        kept[within] = near.which[i]
        within += near.squared[i] < most
    while within < k:  # of those at that distance
        next_place = tree.n
        for i in range(count):
            if near.squared[i] == most and last_place < tree.place[near.which[i]] < next_place:
                next_place, kept[within] = tree.place[near.which[i]], near.which[i]
        last_place = next_place
        within += 1
    for i in range(k):
        near.which[i] = kept[i]


cdef void scatter_of(const Tree *tree, const Near *near, double *entries, Py_ssize_t stride) noexcept nogil:
    """Fill in the scatter xx, yy, zz, xy, xz, yz of the near points about their mean, so far apart."""
    cdef double x, y, z, mean_x = 0.0, mean_y = 0.0, mean_z = 0.0
    cdef double xx = 0.0, yy = 0.0, zz = 0.0, xy = 0.0, xz = 0.0, yz = 0.0
    cdef Py_ssize_t i, which
    for i in range(near.count):
        which = near.which[i]
        mean_x += tree.x[which]
        mean_y += tree.y[which]
        mean_z += tree.z[which]
    mean_x, mean_y, mean_z = mean_x / near.count, mean_y / near.count, mean_z / near.count
    for i in range(near.count):
        which = near.which[i]
        x, y, z = tree.x[which] - mean_x, tree.y[which] - mean_y, tree.z[which] - mean_z
        xx += x * x
        yy += y * y
        zz += z * z
        xy += x * y
        xz += x * z
        yz += y * z
    entries[0], entries[stride], entries[2 * stride] = xx, yy, zz
    entries[3 * stride], entries[4 * stride], entries[5 * stride] = xy, xz, yz


def local_planes(
    const double[:, ::1] points, const Py_ssize_t[::1] order, int times, const double[:, ::1] at, Py_ssize_t k
):
    """Planes through the k nearest of points (N, 3) to places (M, 3): unit normals (M, 3), and the scatter (M,) about
    them and along them in the narrower direction.

    The points are in this order (N,) halved so many times; 3 <= k <= N. See `fitting.cloud.normals`.
    """
    cdef Py_ssize_t i, n = points.shape[0], m = at.shape[0], pieces = 2 << times
    if times > LEVELS or not 3 <= k <= n or order.shape[0] != n:
        raise ValueError("there are at least 3 neighbors, and not more than points")
    normals, scatter, breadth = np.empty((m, 3)), np.empty(m), np.empty(m)
    cdef double[:, ::1] normal = normals
    cdef double[::1] deviation = scatter
    cdef double[::1] narrower = breadth
    cdef double *room = room_for(7 * n + 6 * pieces + 15 * m)
    cdef double *entries = room + 7 * n + 6 * pieces
    cdef double *vectors = entries + 6 * m
    cdef Tree tree
    cdef Near near
    tree.n, tree.times, tree.place = n, times, &order[0]
    tree.x, tree.y, tree.z, tree.boxes = room, room + n, room + 2 * n, room + 3 * n
    near.squared = tree.boxes + 6 * pieces
    near.which = <Py_ssize_t *> (near.squared + n)
    with nogil:
        for i in range(n):
            tree.x[i], tree.y[i], tree.z[i] = points[order[i], 0], points[order[i], 1], points[order[i], 2]
        enclose(&tree, 1, 0, n, times)
        for i in range(m):
            nearest(&tree, k, &at[i, 0], &near, near.squared + 2 * n)
            scatter_of(&tree, &near, entries + i, m)
        eigen(entries, m, vectors)
        for i in range(m):
            normal[i, 0], normal[i, 1], normal[i, 2] = vectors[i], vectors[m + i], vectors[2 * m + i]
            deviation[i] = sqrt(max(entries[i], 0.0) / max(k - 3, 1))
            narrower[i] = sqrt(max(entries[m + i], 0.0) / max(k - 3, 1))
    free(room)
    return normals, scatter, breadth
