# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""What goes over all points, patches and explanations where the covariance of a step is made."""

from libc.math cimport atan2, exp, fabs, lgamma, sqrt
from libc.stdlib cimport free
from libc.string cimport memset

import numpy as np

from ..solver._descent cimport columns, load
from ..trial._limits cimport KINDS, MOST, Points, Surface, linearize

cdef extern from "noise/kernels.h" nogil:
    double weight_of(int kernel, double squared)
    double slope_of(int kernel, double squared)

cdef extern from "solver/equations.h" nogil:
    void inner(const double *a, const double **b, Py_ssize_t n, double *sums)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef double PI = 3.141592653589793

cdef enum:
    DISTANCE, PULL, SLOPE, GAIN, FOOT, COLUMNS = 7
"""What `linearized` says of each point beside its derivatives, the foot in three rows."""

cdef int MOST_STEPS = 200
"""Newton's steps to a quantile, which comes from below, and no nearer than rounding lets it."""
cdef int MOST_SWEEPS = 40
cdef double SLIGHT = 1e-33
"""A square off the diagonal below this share of the product of those beside it turns nothing any more."""
cdef double EPS = 2.220446049250313e-16


def linearized(
    int kind, const double[::1] row, const double[:, ::1] points, int kernel, double scale,
    const double[::1] factors=None
):
    """A table (dof + 7, N) of a cost about a surface, one point a column.

    Derivatives (dof) of the distance by a step, times the factor of the point; the distance times that; the pull
    under the kernel, its slope, and what it grows by with the distance; the closest point (3) of the surface.
    """
    cdef Py_ssize_t n = points.shape[0], i
    cdef int dof = KINDS[kind].dof, k
    cdef Surface surface
    cdef Points seen
    cdef double squared, factor
    cdef double[3] outward
    table = np.empty((dof + COLUMNS, n))
    if not n:
        return table
    cdef double[:, ::1] view = table
    cdef double *jacobian = &view[0, 0]
    cdef double *distance = &view[dof + DISTANCE, 0]
    cdef double *room = room_for(3 * n)
    load(&surface, kind, &row[0])
    with nogil:
        seen = columns(points, room)
        linearize(&surface, seen, distance, jacobian)
        for i in range(n):
            KINDS[kind].outward(&surface, jacobian + i, n, outward)
            for k in range(3):
                view[dof + FOOT + k, i] = points[i, k] - distance[i] * outward[k]
            if factors is not None:
                factor = factors[i]
                distance[i] *= factor
                for k in range(dof):
                    view[k, i] *= factor
            else:
                factor = 1.0
            squared = distance[i] / scale * (distance[i] / scale)
            view[dof + PULL, i] = weight_of(kernel, squared) * distance[i]
            view[dof + SLOPE, i] = slope_of(kernel, squared)
            view[dof + GAIN, i] = factor * view[dof + SLOPE, i]
    free(room)
    return table


cdef void products(
    const double[:, ::1] rows, const double *weight, double *weighted, double[:, ::1] result
) noexcept nogil:
    """rows diag(weight) rows^T (k, k) of rows (k, N); `weighted` is a room of N numbers."""
    cdef Py_ssize_t n = rows.shape[1], i
    cdef int k = rows.shape[0], a, b, first
    cdef const double* beside[4]
    cdef double[4] sums
    for a in range(k):
        for i in range(n):
            weighted[i] = weight[i] * rows[a, i]
        for first in range(0, a + 1, 4):
            for b in range(4):
                beside[b] = &rows[min(first + b, a), 0]
            inner(weighted, beside, n, sums)
            for b in range(first, min(first + 4, a + 1)):
                result[a, b] = result[b, a] = sums[b - first]


def weighted_products(const double[:, ::1] rows, const double[::1] weight):
    """rows diag(weight) rows^T, (k, k), of rows (k, N)."""
    cdef Py_ssize_t n = rows.shape[1]
    cdef double *room = room_for(n)
    result = np.zeros((rows.shape[0], rows.shape[0]))
    cdef double[:, ::1] view = result
    if n:
        with nogil:
            products(rows, &weight[0], room, view)
    free(room)
    return result


cdef void diagonalize(double *matrix, int n, double *vectors) noexcept nogil:
    """Let a symmetric matrix (n, MOST) be diagonal, seen along the columns of `vectors` (n, MOST).

    By Jacobi's rotations, of which small eigenvalues come out as precisely as the diagonal shows them: Demmel and
    Veselic, "Jacobi's method is more accurate than QR", SIAM J. Matrix Anal. Appl. 13, 1992.
    """
    cdef int p, q, i, turn
    cdef double slant, t, c, s, one, other
    cdef bint rests
    for p in range(n):
        for q in range(n):
            vectors[p * MOST + q] = 1.0 if p == q else 0.0
    for turn in range(MOST_SWEEPS):
        rests = True
        for p in range(n):
            for q in range(p):
                one = matrix[p * MOST + q]
                if not one * one > SLIGHT * fabs(matrix[p * MOST + p] * matrix[q * MOST + q]):
                    continue
                rests = False
                slant = 0.5 * (matrix[q * MOST + q] - matrix[p * MOST + p]) / one
                t = (1.0 if slant >= 0.0 else -1.0) / (fabs(slant) + sqrt(slant * slant + 1.0))
                c = 1.0 / sqrt(t * t + 1.0)
                s = t * c
                for i in range(n):
                    one, other = matrix[i * MOST + p], matrix[i * MOST + q]
                    matrix[i * MOST + p], matrix[i * MOST + q] = c * one - s * other, s * one + c * other
                for i in range(n):
                    one, other = matrix[p * MOST + i], matrix[q * MOST + i]
                    matrix[p * MOST + i], matrix[q * MOST + i] = c * one - s * other, s * one + c * other
                    one, other = vectors[i * MOST + p], vectors[i * MOST + q]
                    vectors[i * MOST + p], vectors[i * MOST + q] = c * one - s * other, s * one + c * other
                matrix[p * MOST + q] = matrix[q * MOST + p] = 0.0
        if rests:
            return


cdef bint scaled(const double[:, ::1] matrix, double *sizes, double *result) noexcept nogil:
    """A symmetric matrix (k, k) in units in which its diagonal is 1, (k, MOST); False where it is not positive."""
    cdef int k = matrix.shape[0], a, b
    for a in range(k):
        if not matrix[a, a] > 0.0:
            return False
        sizes[a] = sqrt(matrix[a, a])
    for a in range(k):
        for b in range(k):
            result[a * MOST + b] = 0.5 * (matrix[a, b] + matrix[b, a]) / (sizes[a] * sizes[b])
    return True


def inverted(const double[:, ::1] square, double least):
    """The inverse (k, k) of a symmetric matrix, or None where it is hardly positive definite.

    That is where, in units in which its diagonal is 1, an eigenvalue is not above the least.
    """
    cdef int k = square.shape[0], a, b, c
    cdef double[MOST] sizes
    cdef double[MOST * MOST] matrix
    cdef double[MOST * MOST] vectors
    cdef double total
    if not scaled(square, sizes, matrix):
        return None
    diagonalize(matrix, k, vectors)
    for c in range(k):
        if not matrix[c * (MOST + 1)] > least:
            return None
    result = np.empty((k, k))
    cdef double[:, ::1] view = result
    for a in range(k):
        for b in range(a + 1):
            total = 0.0
            for c in range(k):
                total += vectors[a * MOST + c] * vectors[b * MOST + c] / matrix[c * (MOST + 1)]
            view[a, b] = view[b, a] = total / (sizes[a] * sizes[b])
    return result


def uneven(
    const double[:, ::1] rows, const double[::1] pull, const double[::1] slope, const double[:, ::1] bread,
    double copies, double most_leverage
):
    """rows diag(p^2 / (1 - leverage)) rows^T, (k, k), of rows (k, N), and the mean of p^2 / (1 - leverage).

    The leverage of a point is  copies slope r^T bread r, taken for between 0 and the most.
    """
    cdef Py_ssize_t n = rows.shape[1], i
    cdef int k = rows.shape[0], a, b
    cdef double total = 0.0, entry
    cdef double *room = room_for(2 * n)
    result = np.zeros((k, k))
    cdef double[:, ::1] view = result
    with nogil:
        memset(room, 0, n * sizeof(double))
        for a in range(k):
            for b in range(a + 1):
                entry = copies * (bread[a, b] if a == b else bread[a, b] + bread[b, a])
                for i in range(n):
                    room[i] += entry * rows[a, i] * rows[b, i]
        for i in range(n):
            room[i] = pull[i] * pull[i] / (1.0 - min(max(slope[i] * room[i], 0.0), most_leverage))
            total += room[i]
        if n:
            products(rows, room, room + n, view)
    free(room)
    return result, total / n


cdef int gather(
    const double[:, ::1] rows, const double[::1] gain, const double[:, ::1] feet, const long long[::1] patch,
    const unsigned char[::1] seen, double *sums, Py_ssize_t patches
) noexcept nogil:
    """Of the seen points of each patch: how many, the mean of the feet (3), the sum of gain times rows (k).

    These are rows (patches, 4 + k) of `sums`, of patches that have any; returned is how many have.
    """
    cdef Py_ssize_t i, p
    cdef int k = rows.shape[0], a, found = 0
    cdef double *mine
    memset(sums, 0, patches * (4 + k) * sizeof(double))
    for i in range(patch.shape[0]):
        if not seen[i]:
            continue
        mine = sums + patch[i] * (4 + k)
        mine[0] += 1.0
        for a in range(3):
            mine[1 + a] += feet[a, i]
        for a in range(k):
            mine[4 + a] += gain[i] * rows[a, i]
    for p in range(patches):
        mine = sums + p * (4 + k)
        if mine[0] == 0.0:
            continue
        for a in range(3):
            mine[1 + a] /= mine[0]
        for a in range(4 + k):
            sums[found * (4 + k) + a] = mine[a]
        found += 1
    return found


cdef void measure(
    const double *sums, Py_ssize_t patches, int width, double extent, double *apart
) noexcept nogil:
    """Distances over the extent between each patch and those before it, one row after the other."""
    cdef Py_ssize_t p, q, place = 0
    cdef double x, y, z
    for p in range(patches):
        for q in range(p):
            x = sums[p * width + 1] - sums[q * width + 1]
            y = sums[p * width + 2] - sums[q * width + 2]
            z = sums[p * width + 3] - sums[q * width + 3]
            apart[place] = sqrt(x * x + y * y + z * z) / extent
            place += 1


cdef void level(double *sums, Py_ssize_t patches, int k) noexcept nogil:
    """Take from the sums of each patch its share, by points, of their total."""
    cdef Py_ssize_t p
    cdef int a, width = 4 + k
    cdef double count = 0.0, total
    for p in range(patches):
        count += sums[p * width]
    for a in range(4, width):
        total = 0.0
        for p in range(patches):
            total += sums[p * width + a]
        for p in range(patches):
            sums[p * width + a] -= sums[p * width] / count * total


cdef void add_field(
    const double *sums, const double *apart, Py_ssize_t patches, int k, double span, bint smooth,
    double[:, ::1] result
) noexcept nogil:
    """G^T C G of a field of variance 1, with the correlations C of the patches and their sums G (patches, k)."""
    cdef Py_ssize_t p, q
    cdef int a, b, width = 4 + k
    cdef double share
    cdef const double *one
    cdef const double *other
    cdef double[MOST] total
    for p in range(patches):
        one = sums + p * width + 4
        for a in range(k):  # half of what p itself adds, then those before it, each of which counts twice
            total[a] = 0.5 * one[a]
        for q in range(p):
            other = sums + q * width + 4
            share = apart[q] / span
            share = exp(-0.5 * share * share) if smooth else exp(-share)
            for a in range(k):
                total[a] += share * other[a]
        apart += p
        for a in range(k):
            for b in range(k):
                result[a, b] += one[a] * total[b]
                result[b, a] += one[a] * total[b]


def fields(
    const double[:, ::1] rows, const double[::1] gain, const double[:, ::1] feet, const long long[::1] patch,
    const unsigned char[::1] seen, double extent, const double[::1] rough, const double[::1] smooth
):
    """Covariances (R, k, k) of the sum of  gain r  over the seen points under fields of variance 1.

    Parameters
    ----------
    rows, gain, feet : (k, N), (N,), (3, N) of the points
    patch, seen : (N,) number of the patch of each, and whether it counts
    rough, smooth : ranges over the extent of the fields, rough ones first in the result; patch means of the
        feet that are h apart have the correlation exp(-h / range), or exp(-h^2 / 2 range^2). A smooth field
        as wide as the cloud, of which there is one at most and the last, has no mean: the part deviates by 0
        in the mean over the points
    """
    cdef Py_ssize_t patches = 1 + int(np.max(patch)), i
    cdef int k = rows.shape[0], found
    cdef double *sums = room_for(patches * (4 + k) + patches * (patches - 1) // 2)
    cdef double *apart = sums + patches * (4 + k)
    result = np.zeros((rough.shape[0] + smooth.shape[0], k, k))
    cdef double[:, :, ::1] view = result
    with nogil:
        found = gather(rows, gain, feet, patch, seen, sums, patches)
        measure(sums, found, 4 + k, extent, apart)
        for i in range(rough.shape[0]):
            add_field(sums, apart, found, k, rough[i], False, view[i])
        for i in range(smooth.shape[0]):
            if smooth[i] >= 1.0:
                level(sums, found, k)
            add_field(sums, apart, found, k, smooth[i], True, view[rough.shape[0] + i])
    free(sums)
    return result


cdef void within(
    double end, const double *deviation, const double *weight, Py_ssize_t parts, int free, double unit, double *room,
    double *share, double *density
) noexcept nogil:
    """The share of the cases of a mixture that is within +- end, and its derivative.

    Parts are of Student's t with integer degrees of freedom. Source: Abramowitz and Stegun, "Handbook of
    mathematical functions", 1964, 26.7.3 and 26.7.4, with  cos^2 = free / (free + t^2)  from the last term on.
    """
    cdef double *cosine2 = room
    cdef double *series = room + parts
    cdef double *power = room + 2 * parts
    cdef double ratio, t, c, sine, inside
    cdef bint odd = free % 2
    cdef int j, terms = (free - 3 if odd else free - 2) // 2
    cdef Py_ssize_t i
    for i in range(parts):
        t = end / deviation[i]
        cosine2[i], series[i], power[i] = free / (free + t * t), 1.0, 1.0
    for j in range(terms, 0, -1):
        ratio = 2.0 * j / (2.0 * j + 1.0) if odd else (2.0 * j - 1.0) / (2.0 * j)
        for i in range(parts):
            series[i] = 1.0 + ratio * cosine2[i] * series[i]
            power[i] *= cosine2[i]
    share[0], density[0] = 0.0, 0.0
    for i in range(parts):
        t, c = end / deviation[i], sqrt(cosine2[i])
        sine = t / sqrt(free + t * t)
        if odd:
            inside = atan2(sine, c) + (sine * c * series[i] if free > 1 else 0.0)
            inside *= 2.0 / PI
            power[i] *= cosine2[i] * cosine2[i] if free > 1 else cosine2[i]
        else:
            inside = sine * series[i]
            power[i] *= cosine2[i] * c
        share[0] += weight[i] * inside
        density[0] += weight[i] * unit * power[i] / deviation[i]


cdef void find_ends(
    const double *deviations, const double *weights, int k, Py_ssize_t parts, int free_squares, double share,
    double *room, double *ends
) noexcept nogil:
    """As `mixture_ends`; the room is for 5 numbers of each part."""
    cdef double *deviation = room + 3 * parts
    cdef double *weight = room + 4 * parts
    cdef double unit = 2.0 * exp(lgamma(0.5 * (free_squares + 1)) - lgamma(0.5 * free_squares))
    cdef double certain, held, density, end, grown
    cdef Py_ssize_t i, some
    cdef int a, turn
    unit /= sqrt(free_squares * PI)
    for a in range(k):
        some, certain, end = 0, 0.0, 0.0
        for i in range(parts):
            if deviations[a * parts + i] > 0.0:
                deviation[some], weight[some] = deviations[a * parts + i], weights[i]
                some += 1
            else:
                certain += weights[i]
        for turn in range(MOST_STEPS if certain < share else 0):
            within(end, deviation, weight, some, free_squares, unit, room, &held, &density)
            grown = (share - certain - held) / density
            end += grown
            if not grown > 1e-15 * end:
                break
        ends[a] = end


def mixture_ends(
    const double[:, ::1] deviations, const double[::1] weights, int free_squares, double share
):
    """Ends (k,) of the intervals about 0 that hold this share of mixtures of standard deviations (k, T).

    Parts, of weights (T,), are of Student's t with so many degrees of freedom; deviations of 0 are certain.
    The share is a concave function of the end, so that Newton's method comes from below.
    """
    cdef Py_ssize_t parts = deviations.shape[1]
    cdef int k = deviations.shape[0]
    cdef double *room = room_for(5 * parts)
    result = np.zeros(k)
    cdef double[::1] view = result
    if parts and k:
        with nogil:
            find_ends(&deviations[0, 0], &weights[0], k, parts, free_squares, share, room, &view[0])
    free(room)
    return result


cdef bint principal(
    const double[:, :, ::1] meats, const double[:, ::1] shares, const double[::1] weights,
    const double[:, ::1] bread, double *directions
) noexcept nogil:
    """Directions D (k, MOST), in columns:  bread = D D^T,  and D^T meat D is diagonal for the mean of the meats.

    False where the bread is not positive. Along D, which is the bread times what measures a step along each, the
    variance of an explanation is d^T meat d: the inverse of the bread is not needed.
    """
    cdef int k = bread.shape[0], a, b, c, r
    cdef Py_ssize_t t
    cdef double share
    cdef double[MOST] sizes
    cdef double[MOST * MOST] mean
    cdef double[MOST * MOST] root
    cdef double[MOST * MOST] some
    cdef double[MOST * MOST] turn
    if not scaled(bread, sizes, mean):
        return False
    diagonalize(mean, k, turn)
    for a in range(k):
        for b in range(k):
            root[a * MOST + b] = sizes[a] * turn[a * MOST + b] * sqrt(max(mean[b * (MOST + 1)], EPS))
    for a in range(k):
        for b in range(k):
            mean[a * MOST + b] = 0.0
    for r in range(shares.shape[1]):
        share = 0.0
        for t in range(shares.shape[0]):
            share += weights[t] * shares[t, r]
        for a in range(k):
            for b in range(k):
                mean[a * MOST + b] += share * meats[r, a, b]
    for a in range(k):
        for b in range(k):
            some[a * MOST + b] = 0.0
            for c in range(k):
                some[a * MOST + b] += mean[a * MOST + c] * root[c * MOST + b]
    for a in range(k):
        for b in range(a + 1):
            mean[a * MOST + b] = 0.0
            for c in range(k):
                mean[a * MOST + b] += root[c * MOST + a] * some[c * MOST + b]
            mean[b * MOST + a] = mean[a * MOST + b]
    diagonalize(mean, k, turn)
    for a in range(k):
        for b in range(k):
            directions[a * MOST + b] = 0.0
            for c in range(k):
                directions[a * MOST + b] += root[a * MOST + c] * turn[c * MOST + b]
    return True


cdef void spread_along(
    const double[:, :, ::1] meats, const double[:, ::1] shares, const double *directions, double *deviations
) noexcept nogil:
    """Standard deviations (k, T) of the explanations along directions (k, MOST) of `principal`."""
    cdef int k = meats.shape[1], a, b, c, r, parts = shares.shape[1]
    cdef Py_ssize_t t, explanations = shares.shape[0]
    cdef double square
    for c in range(k):
        for t in range(explanations):
            deviations[c * explanations + t] = 0.0
        for r in range(parts):
            square = 0.0
            for a in range(k):
                for b in range(k):
                    square += directions[a * MOST + c] * meats[r, a, b] * directions[b * MOST + c]
            for t in range(explanations):
                deviations[c * explanations + t] += shares[t, r] * square
        for t in range(explanations):
            deviations[c * explanations + t] = sqrt(max(deviations[c * explanations + t], 0.0))


def mixed(
    const double[:, :, ::1] meats, const double[:, ::1] shares, const double[::1] weights,
    const double[:, ::1] bread, int free_squares, double share, double quantile
):
    """The covariance whose intervals are those of a mixture; see `fitting.uncertainty.covariance.mixed`.

    And the variance of steps under the first meat alone over what this is, in the mean over the directions.
    """
    cdef int k = bread.shape[0], a, b, c
    cdef double alone = 0.0, found = 0.0
    cdef Py_ssize_t parts = shares.shape[0]
    cdef double[MOST] ends
    cdef double[MOST * MOST] directions
    cdef double *room = room_for((k + 5) * parts)
    result = np.zeros((k, k))
    cdef double[:, ::1] view = result
    with nogil:
        if principal(meats, shares, weights, bread, directions):
            spread_along(meats, shares, directions, room)
            find_ends(room, &weights[0], k, parts, free_squares, share, room + k * parts, ends)
            for a in range(k):
                for b in range(k):
                    for c in range(k):
                        view[a, b] += directions[a * MOST + c] * directions[b * MOST + c] * ends[c] * ends[c]
                    view[a, b] /= quantile * quantile
            for c in range(k):
                found += ends[c] * ends[c] / (quantile * quantile)
                for a in range(k):
                    for b in range(k):
                        alone += directions[a * MOST + c] * meats[0, a, b] * directions[b * MOST + c]
    free(room)
    return result, alone / found if found > 0.0 else 1.0
