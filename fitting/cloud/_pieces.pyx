# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Halves of halves of a cloud: its pieces, and a tree that finds neighbours."""

from libc.math cimport INFINITY, sqrt
from libc.stdlib cimport free

import numpy as np

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef extern from "cloud/jacobi.h" nogil:
    void eigen(double (*matrix)[3], double *values, double (*vectors)[3])

cdef enum:
    LEVELS = 48  # of halving, at most


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
    # The k nearest places so far, the nearest first, and their squared distances.
    Py_ssize_t k
    Py_ssize_t *place
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


cdef int widest(const double[:, ::1] points, const Py_ssize_t *order, Py_ssize_t n) noexcept nogil:
    """The coordinate that n points of this order differ most in."""
    cdef double least, most, width = -1.0
    cdef Py_ssize_t i
    cdef int axis, along = 0
    for axis in range(3):
        least, most = INFINITY, -INFINITY
        for i in range(n):
            least, most = min(least, points[order[i], axis]), max(most, points[order[i], axis])
        if most - least > width:
            width, along = most - least, axis
    return along


cdef void halve(
    const double[:, ::1] points, Py_ssize_t *order, Py_ssize_t n, int times, double *keys, double *room
) noexcept nogil:
    """Order n points as halves of halves, so many times; there is room for n keys, and for twice as many."""
    cdef Py_ssize_t *upper = <Py_ssize_t *> room
    cdef Py_ssize_t i, place, low, high, equal, half = n // 2
    cdef double middle, key
    cdef int along
    cdef bint lower
    if times == 0:
        return
    along = widest(points, order, n)
    for i in range(n):
        keys[i] = room[i] = points[order[i], along]
    middle = of_rank(room, n, half, room + n)
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
    cdef double total = 0.0, off
    cdef int axis
    for axis in range(3):
        off = max(max(box[axis] - point[axis], point[axis] - box[3 + axis]), 0.0)
        total += off * off
    return total


cdef void admit(const Tree *tree, Py_ssize_t first, Py_ssize_t n, const double *point, Near *near) noexcept nogil:
    """Let n points of a piece come among the nearest; of those at one distance the earlier places are nearer."""
    cdef Py_ssize_t i, j, place, last = near.k - 1
    cdef double x, y, z, squared
    for i in range(first, first + n):
        x, y, z = tree.x[i] - point[0], tree.y[i] - point[1], tree.z[i] - point[2]
        squared = x * x + y * y + z * z
        if squared > near.squared[last]:
            continue
        place = tree.place[i]
        if squared == near.squared[last] and place > near.place[last]:
            continue
        j = last
        while j > 0 and (near.squared[j - 1] > squared or (near.squared[j - 1] == squared and near.place[j - 1] > place)):
            near.squared[j], near.place[j] = near.squared[j - 1], near.place[j - 1]
            j -= 1
        near.squared[j], near.place[j] = squared, place


cdef void search(
    const Tree *tree, Py_ssize_t piece, Py_ssize_t first, Py_ssize_t n, int times, const double *point, Near *near
) noexcept nogil:
    """Let the points of a piece come among the nearest, those of the nearer half before the others."""
    cdef double left, right
    cdef Py_ssize_t half = n // 2
    if times == 0:
        admit(tree, first, n, point, near)
        return
    left = to_box(tree.boxes + 12 * piece, point)
    right = to_box(tree.boxes + 12 * piece + 6, point)
    if left <= right:
        if left <= near.squared[near.k - 1]:
            search(tree, 2 * piece, first, half, times - 1, point, near)
        if right <= near.squared[near.k - 1]:
            search(tree, 2 * piece + 1, first + half, n - half, times - 1, point, near)
    else:
        if right <= near.squared[near.k - 1]:
            search(tree, 2 * piece + 1, first + half, n - half, times - 1, point, near)
        if left <= near.squared[near.k - 1]:
            search(tree, 2 * piece, first, half, times - 1, point, near)


cdef double plane_through(const double[:, ::1] points, const Near *near, double *normal) noexcept nogil:
    """Normal of the plane through the nearest points, and the sum of their squared distances from it."""
    cdef double middle[3]
    cdef double off[3]
    cdef double values[3]
    cdef double scatter[3][3]
    cdef double vectors[3][3]
    cdef Py_ssize_t i
    cdef int j, l
    for j in range(3):
        middle[j] = 0.0
        for i in range(near.k):
            middle[j] += points[near.place[i], j]
        middle[j] /= near.k
        for l in range(3):
            scatter[j][l] = 0.0
    for i in range(near.k):
        for j in range(3):
            off[j] = points[near.place[i], j] - middle[j]
        for j in range(3):
            for l in range(j + 1):
                scatter[j][l] += off[j] * off[l]
    for j in range(3):
        for l in range(j):
            scatter[l][j] = scatter[j][l]
    eigen(scatter, values, vectors)
    for j in range(3):
        normal[j] = vectors[j][0]
    return max(values[0], 0.0)


def local_planes(
    const double[:, ::1] points, const Py_ssize_t[::1] order, int times, const double[:, ::1] at, Py_ssize_t k
):
    """Unit normals (M, 3) of planes through the k nearest of points (N, 3) to places (M, 3), and the scatter (M,).

    The points are in this order (N,) halved so many times; 3 <= k <= N. See `fitting.cloud.normals`.
    """
    cdef Py_ssize_t i, m, n = points.shape[0], pieces = 2 << times
    if times > LEVELS or not 3 <= k <= n or order.shape[0] != n:
        raise ValueError("there are at least 3 neighbours, and not more than points")
    normals, scatter = np.empty((at.shape[0], 3)), np.empty(at.shape[0])
    cdef double[:, ::1] normal = normals
    cdef double[::1] deviation = scatter
    cdef double *room = room_for(3 * n + 6 * pieces + 2 * k)
    cdef Tree tree
    cdef Near near
    tree.n, tree.times, tree.place = n, times, &order[0]
    tree.x, tree.y, tree.z, tree.boxes = room, room + n, room + 2 * n, room + 3 * n
    near.k, near.squared, near.place = k, tree.boxes + 6 * pieces, <Py_ssize_t *> (tree.boxes + 6 * pieces + k)
    with nogil:
        for i in range(n):
            tree.x[i], tree.y[i], tree.z[i] = points[order[i], 0], points[order[i], 1], points[order[i], 2]
        enclose(&tree, 1, 0, n, times)
        for m in range(at.shape[0]):
            for i in range(k):
                near.squared[i], near.place[i] = INFINITY, n
            search(&tree, 1, 0, n, times, &at[m, 0], &near)
            deviation[m] = sqrt(plane_through(points, &near, &normal[m, 0]) / max(k - 3, 1))
    free(room)
    return normals, scatter
