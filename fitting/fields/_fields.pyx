# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Residuals patch by patch, and what white noise and random fields make of them."""

from libc.math cimport INFINITY, fabs, sqrt
from libc.stdlib cimport free
from libc.string cimport memcpy, memset

import numpy as np

cdef extern from "fields/weighing.h" nogil:
    enum:
        MOST

    ctypedef struct Patches:
        Py_ssize_t n
        int dof
        const double *mean
        const double *count
        const double *whitened
        double scatter, spare, prior, least

    ctypedef struct Fields:
        double size[2]
        const double *bell[2]

    ctypedef struct Weighed:
        double evidence, white, rough, smooth

    Py_ssize_t padded(Py_ssize_t n)
    double *aligned(double *room)
    void bell_of(const double *apart, Py_ssize_t n, Py_ssize_t m, double span, bint smooth, double *bell)
    void whiten(const double *jacobian, Py_ssize_t n, int dof, double *columns, double *directions)
    Weighed weigh(
        const Patches *p, const Fields *f, Py_ssize_t m, Py_ssize_t width, double *room, double *normal
    )
    double weigh_apart(const Patches *p, double *rest, double *white)
    void spread_of(const double *normal, int dof, const double *directions, double white, double *spread)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef enum:
    EVIDENCE, WHITE, ROUGH, ROUGH_RANGE, SMOOTH, SMOOTH_RANGE, ROUGH_SIZE, SMOOTH_SIZE, COLUMNS


cdef class Grid:
    """Sizes and ranges of fields that are looked at, by themselves and in pairs.

    Sizes (T, 2) of the rough and the smooth field, over the white noise, 0 where there is none, and numbers (T, 2)
    of their ranges (B,), over the extent, of which the first `rough` ones are those of rough fields. The last of
    them are pairs of the others, of the numbers (T - S, 2).
    """

    cdef double[::1] ranges
    cdef Py_ssize_t rough
    cdef double[:, ::1] sizes
    cdef long long[:, ::1] which, pairs

    def __init__(self, ranges, rough, sizes, which, pairs):
        self.ranges, self.rough = np.array(ranges, np.float64), rough
        self.sizes, self.which = np.array(sizes, np.float64), np.array(which, np.int64)
        self.pairs = np.array(pairs, np.int64)


cdef struct Best:
    double evidence
    double white
    double normal[MOST * MOST]


cdef void write(
    Grid grid, Py_ssize_t t, const Patches *patches, const double *bells, Py_ssize_t m, Py_ssize_t width, double *room,
    double[:, ::1] table, Py_ssize_t row, Best *best
) noexcept nogil:
    """What pair t of the grid makes of the residuals, in a column of the table; the best so far is kept."""
    cdef double normal[MOST * MOST]
    cdef Fields fields
    cdef Weighed found
    cdef int part
    for part in range(2):
        fields.size[part] = grid.sizes[t, part]
        fields.bell[part] = bells + grid.which[t, part] * m * m
    found = weigh(patches, &fields, m, width, room, normal)
    table[EVIDENCE, row], table[WHITE, row] = found.evidence, found.white
    table[ROUGH, row], table[SMOOTH, row] = found.rough, found.smooth
    for part in range(2):
        table[ROUGH_SIZE + part, row] = fields.size[part]
        if fields.size[part] > 0.0:
            table[ROUGH_RANGE + 2 * part, row] = grid.ranges[grid.which[t, part]]
    if found.evidence > best.evidence:
        best.evidence, best.white = found.evidence, found.white
        memcpy(best.normal, normal, sizeof(normal))


cdef void fill(
    Grid grid, const Patches *patches, const double *apart, double *room, double[:, ::1] table, Best *best
) noexcept nogil:
    """All columns of the table: fields alone, then pairs that both help, then those that do not."""
    cdef Py_ssize_t n = patches.n, m = padded(n), width = m + padded(patches.dof + 1), kinds = grid.ranges.shape[0]
    cdef Py_ssize_t alone = grid.sizes.shape[0] - grid.pairs.shape[0], t, row = alone
    cdef double *bells = room
    cdef double *rest = bells + kinds * m * m
    for t in range(kinds):
        bell_of(apart, n, m, grid.ranges[t], t >= grid.rough, bells + t * m * m)
    for t in range(alone):
        write(grid, t, patches, bells, m, width, rest, table, t, best)
    for t in range(grid.pairs.shape[0]):
        if (
            table[EVIDENCE, grid.pairs[t, 0]] > table[EVIDENCE, 0]
            and table[EVIDENCE, grid.pairs[t, 1]] > table[EVIDENCE, 0]
        ):
            write(grid, alone + t, patches, bells, m, width, rest, table, row, best)
            row += 1
    for t in range(row, table.shape[1]):
        table[EVIDENCE, t], table[WHITE, t] = -INFINITY, best.white


def explained(
    Grid grid, const double[::1] mean, const double[:, ::1] jacobian, const double[::1] count,
    const double[:, ::1] apart, double scatter, double spare, double prior, double least
):
    """What fields make of residuals by patches; see `fitting.fields.fields`, whose `Patched` they are from.

    `prior` is the variance by which a step may move the surface, `least` the smallest noise of a point. Returned
    are the eight columns (T,) of `Explanations`, in their order, then `apart`, `apart_white`, and `spread`.
    """
    cdef Py_ssize_t n = mean.shape[0], m = padded(n), kinds = grid.ranges.shape[0]
    cdef int dof = jacobian.shape[1]
    cdef Py_ssize_t width = m + padded(dof + 1)
    table, spread = np.zeros((COLUMNS, grid.sizes.shape[0])), np.zeros(dof)
    cdef double[:, ::1] view = table
    cdef double[::1] spread_view = spread
    cdef double directions[MOST * MOST]
    cdef double apart_white, evidence
    cdef Patches patches
    cdef Best best
    cdef double *room
    cdef double *rows
    if dof > MOST:
        raise ValueError(f"a surface has {MOST} parameters at most, not {dof}")
    if n <= dof:
        raise ValueError(f"{n} patches do not tell {dof} parameters from noise")
    room = room_for(8 + kinds * m * m + width * width + 4 * m + dof * n)
    rows = aligned(room)
    with nogil:
        patches.n, patches.dof, patches.mean, patches.count = n, dof, &mean[0], &count[0]
        patches.scatter, patches.spare, patches.prior, patches.least = scatter, spare, prior, least
        patches.whitened = rows + kinds * m * m + width * width + 4 * m
        if dof:
            whiten(&jacobian[0, 0], n, dof, <double *>patches.whitened, directions)
        best.evidence, best.white = -INFINITY, 0.0
        fill(grid, &patches, &apart[0, 0], rows, view, &best)
        evidence = weigh_apart(&patches, rows, &apart_white)
        if dof:
            spread_of(best.normal, dof, directions, best.white, &spread_view[0])
    free(room)
    return tuple(table), evidence, apart_white, spread


cdef Py_ssize_t highest(const Py_ssize_t[::1] number) noexcept nogil:
    """One more than the largest of some numbers (N,) from 0."""
    cdef Py_ssize_t i, most = 0
    for i in range(number.shape[0]):
        if number[i] >= most:
            most = number[i] + 1
    return most


cdef double scatter_of(
    const Py_ssize_t[::1] number, const double[::1] residual, Py_ssize_t groups, double *sums, double *spare
) noexcept nogil:
    """Standard deviation of residuals (N,) about the means of equal numbers, and how many are free.

    The room is for two numbers a group.
    """
    cdef Py_ssize_t i, n = number.shape[0], found = 0
    cdef double *count = sums + groups
    cdef double off, squares = 0.0
    memset(sums, 0, 2 * groups * sizeof(double))
    for i in range(n):
        sums[number[i]] += residual[i]
        count[number[i]] += 1.0
    for i in range(groups):
        if count[i] > 0.0:
            sums[i] /= count[i]
            found += 1
    for i in range(n):
        off = residual[i] - sums[number[i]]
        squares += off * off
    spare[0] = <double>(n - found)
    return sqrt(squares / spare[0]) if found < n else 0.0


cdef void add_up(
    const Py_ssize_t[::1] number, const double[::1] residual, const double[:, :] jacobian, const double[:, :] place,
    Py_ssize_t width, double *sums
) noexcept nogil:
    """Rows of sums over equal numbers: of ones, of residuals, of derivatives and of places."""
    cdef Py_ssize_t i, k, dof = jacobian.shape[1]
    cdef double *row
    for i in range(number.shape[0]):
        row = sums + number[i] * width
        row[0] += 1.0
        row[1] += residual[i]
        for k in range(dof):
            row[2 + k] += jacobian[i, k]
        for k in range(place.shape[1]):
            row[2 + dof + k] += place[i, k]


cdef Py_ssize_t averaged(double *sums, Py_ssize_t groups, Py_ssize_t width) noexcept nogil:
    """Means in the place of sums, of the groups that have points, one after the other; how many have."""
    cdef Py_ssize_t i, k, found = 0
    cdef double count
    for i in range(groups):
        count = sums[i * width]
        if count == 0.0:
            continue
        sums[found * width] = count
        for k in range(1, width):
            sums[found * width + k] = sums[i * width + k] / count
        found += 1
    return found


cdef double between(const double *one, const double *other, Py_ssize_t k, double turn) noexcept nogil:
    """Distance of places (k,); with a turn, those that differ by it are the same."""
    cdef Py_ssize_t i
    cdef double off, square = 0.0
    for i in range(k):
        off = fabs(one[i] - other[i])
        if turn > 0.0 and turn - off < off:
            off = turn - off
        square += off * off
    return sqrt(square)


def patched(
    const Py_ssize_t[::1] patch, const Py_ssize_t[::1] grain, const double[::1] residual,
    const double[:, :] jacobian, const double[:, :] place, double turn
):
    """What `Patched` holds, in the order of its fields, of points with the numbers (N,) of their patches and grains."""
    cdef Py_ssize_t groups = highest(patch), grains = highest(grain), i, j, k, found, dof = jacobian.shape[1]
    cdef Py_ssize_t width = 2 + dof + place.shape[1]
    cdef double within, scatter, free_within, free_scatter
    cdef double *sums = room_for(groups * width + 2 * (groups if groups > grains else grains))
    cdef double *rest = sums + groups * width
    with nogil:
        within = scatter_of(patch, residual, groups, rest, &free_within)
        scatter = scatter_of(grain, residual, grains, rest, &free_scatter)
        memset(sums, 0, groups * width * sizeof(double))
        add_up(patch, residual, jacobian, place, width, sums)
        found = averaged(sums, groups, width)
    means, slopes = np.empty(found), np.empty((found, dof))
    counts, distances = np.empty(found), np.empty((found, found))
    cdef double[::1] mean = means, count = counts
    cdef double[:, ::1] slope = slopes, apart = distances
    for i in range(found):
        count[i], mean[i] = sums[i * width], sums[i * width + 1]
        for k in range(dof):
            slope[i, k] = sums[i * width + 2 + k]
        for j in range(i + 1):
            apart[i, j] = apart[j, i] = between(
                sums + i * width + 2 + dof, sums + j * width + 2 + dof, place.shape[1], turn
            )
    free(sums)
    hidden = sqrt(max(within * within - scatter * scatter, 0.0)) if free_within > 0.0 else 0.0
    return means, slopes, counts, distances, scatter, min(free_scatter, <double>found), hidden
