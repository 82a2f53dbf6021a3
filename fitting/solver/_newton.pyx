# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Newton's method on the gradient of a cost, compiled; see `fitting.solver.newton`.

Coordinates are those in which the weighted derivatives are orthonormal: J = Q R, y = R step. There the
gradient is  g = R^-T J^T W d,  and its derivative, taken by central differences, is near the identity even on
short arcs.
"""

from libc.math cimport INFINITY, sqrt
from libc.stdlib cimport free

import numpy as np

from ..trial._limits cimport KINDS, MOST, TINY, Points, Surface, basis, dot, linearize
from ._descent cimport columns, load, store

cdef extern from "noise/kernels.h" nogil:
    double cost_of(int kernel, double scale, const double *distance, Py_ssize_t n)
    void weigh(int kernel, double scale, const double *distance, Py_ssize_t n, double *weight)

cdef extern from "solver/equations.h" nogil:
    void inner(const double *a, const double **b, Py_ssize_t n, double *sums)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef int ROUNDS = 6, STEPS = 12
"""Times at most that curvature is taken, and steps by each; where it is known well, one and three."""
cdef double AT_REST = 1e-9
"""A round whose first step is shorter than this, in norms of the distances, is the last one."""
cdef Py_ssize_t CURVATURE_POINTS = 20_000
"""Curvature is taken on every k-th point of a cloud of more: an error in it only costs steps."""
cdef double[2] DIFFERENCES = [1e-3, 1e-5]
"""Widths of the differences, in rms distances: under noise the first is well within what is linear, but for
directions that points determine very weakly. There the second is taken, if the curvature by the first is
that of no minimum."""
cdef double UNCURVED = 1e-9
"""Below this rms distance, in the normalized frame, curvature is neither seen nor needed."""
cdef double UNSEEN = 1e-12, UNSEEN_DISTANCE = 1e-15, MOST_UNSEEN = 1e-9
"""Growth that is rounding: of the cost, relatively, and of the distances; they add so much to it at most."""
cdef double SMALLEST_PIVOT = 1e-12
"""Relative size of a direction below which the points do not determine the surface."""


cdef struct Chart:
    int pairs
    int first[2]
"""How many pairs of components of a step are along the basis of the axis, and where each begins."""


cdef struct Problem:
    Surface surface
    Points points
    Points some
    Py_ssize_t every
    int kernel
    double scale
    Chart chart
    double whitening[MOST * MOST]
    double *distance
    double *weight
    double *jacobian
"""A surface, all points and every k-th of them, a kernel, and the inverse of R, rows of MOST numbers; distances and
weights (n,) and derivatives (dof, n)."""


cdef bint whiten(Problem *problem) noexcept nogil:
    """The inverse of R, where  sqrt(weight) jacobian = Q R;  False where the points leave a direction open.

    By the modified method of Gram and Schmidt, whose R is as good as that of Householder's reflections
    (Bjorck, BIT 7, 1967). The derivatives are destroyed.
    """
    cdef int dof = KINDS[problem.surface.kind].dof, i, j, k
    cdef Py_ssize_t n = problem.points.n, p
    cdef double[MOST * MOST] triangle
    cdef double smallest = INFINITY, largest = 0.0
    cdef const double* beside[4]
    cdef double[4] sums
    cdef double *column
    cdef double *other
    cdef double total, size, share
    for i in range(dof):
        column = problem.jacobian + i * n
        for p in range(n):
            column[p] *= sqrt(problem.weight[p])
    for i in range(dof):
        column = problem.jacobian + i * n
        for k in range(i, dof, 4):
            for j in range(4):
                beside[j] = problem.jacobian + min(k + j, dof - 1) * n
            inner(column, beside, n, sums)
            for j in range(k, min(k + 4, dof)):
                triangle[i * MOST + j] = sums[j - k]
        size = sqrt(triangle[i * MOST + i])
        smallest, largest = min(smallest, size), max(largest, size)
        if not size > 0.0:
            return False
        for j in range(i + 1, dof):
            other = problem.jacobian + j * n
            share = triangle[i * MOST + j] / (size * size)
            for p in range(n):
                other[p] -= share * column[p]
        for j in range(i, dof):
            triangle[i * MOST + j] /= size
    if not smallest > SMALLEST_PIVOT * largest:
        return False
    for j in range(dof):
        for i in range(dof - 1, -1, -1):
            total = 1.0 if i == j else 0.0
            for k in range(i + 1, j + 1):
                total -= triangle[i * MOST + k] * problem.whitening[k * MOST + j]
            problem.whitening[i * MOST + j] = total / triangle[i * MOST + i] if i <= j else 0.0
    return True


cdef void moved(const Problem *problem, const double *y, Surface *surface) noexcept nogil:
    """The surface at coordinates y (dof,)."""
    cdef int dof = KINDS[problem.surface.kind].dof, i, k
    cdef double[MOST] step
    for i in range(dof):
        step[i] = 0.0
        for k in range(i, dof):
            step[i] += problem.whitening[i * MOST + k] * y[k]
    surface[0] = problem.surface
    KINDS[surface.kind].step(surface, step)


cdef void turn_back(const Problem *problem, const Surface *surface, double *slopes) noexcept nogil:
    """Let slopes (dof,) at a surface be along the basis at the nearby one of the problem.

    The basis of an axis jumps where the axis crosses the plane z = 0; this one does not.
    """
    cdef double[3] u
    cdef double[3] v
    cdef double[3] ours_u
    cdef double[3] ours_v
    cdef int k, first
    cdef double by_u, by_v
    if not problem.chart.pairs:
        return
    basis(problem.surface.axis, u, v)
    basis(surface.axis, ours_u, ours_v)
    for k in range(problem.chart.pairs):
        first = problem.chart.first[k]
        by_u, by_v = slopes[first], slopes[first + 1]
        slopes[first] = dot(ours_u, u) * by_u + dot(ours_v, u) * by_v
        slopes[first + 1] = dot(ours_u, v) * by_u + dot(ours_v, v) * by_v


cdef void gradient_at(Problem *problem, const double *y, Points points, double *gradient) noexcept nogil:
    """The gradient (dof,) at coordinates y (dof,) of the cost of some points:  R^-T J^T W d."""
    cdef int dof = KINDS[problem.surface.kind].dof, i, j, k
    cdef Py_ssize_t p
    cdef Surface there
    cdef double[MOST] slopes
    cdef const double* beside[4]
    cdef double[4] sums
    moved(problem, y, &there)
    linearize(&there, points, problem.distance, problem.jacobian)
    weigh(problem.kernel, problem.scale, problem.distance, points.n, problem.weight)
    for p in range(points.n):
        problem.weight[p] *= problem.distance[p]
    for k in range(0, dof, 4):
        for j in range(4):
            beside[j] = problem.jacobian + min(k + j, dof - 1) * points.n
        inner(problem.weight, beside, points.n, sums)
        for j in range(k, min(k + 4, dof)):
            slopes[j] = sums[j - k]
    turn_back(problem, &there, slopes)
    for i in range(dof):
        gradient[i] = 0.0
        for k in range(i + 1):
            gradient[i] += problem.whitening[k * MOST + i] * slopes[k]


cdef bint curve(Problem *problem, double width, double *factor) noexcept nogil:
    """Cholesky's factor (dof, MOST) of the curvature by differences so wide; False where it is no minimum's."""
    cdef int dof = KINDS[problem.surface.kind].dof, i, j, k
    cdef double[MOST * MOST] found
    cdef double[MOST] y
    cdef double[MOST] behind
    cdef double total, each = problem.every / (2.0 * width)
    for i in range(dof):
        for k in range(dof):
            y[k] = width if k == i else 0.0
        gradient_at(problem, y, problem.some, &found[i * MOST])
        y[i] = -width
        gradient_at(problem, y, problem.some, &behind[0])
        for k in range(dof):
            found[i * MOST + k] = each * (found[i * MOST + k] - behind[k])
    for i in range(dof):
        for j in range(i + 1):
            total = 0.5 * (found[i * MOST + j] + found[j * MOST + i])
            for k in range(j):
                total -= factor[i * MOST + k] * factor[j * MOST + k]
            if i == j and not total > 0.0:
                return False
            factor[i * MOST + j] = sqrt(total) if i == j else total / factor[j * MOST + j]
    return True


cdef double descend(Problem *problem, const double *factor, double *total) noexcept nogil:
    """Steps (dof,) with one curvature, added up while each is half as long at most; the length of the first."""
    cdef int dof = KINDS[problem.surface.kind].dof, turn, i, k
    cdef double[MOST] step
    cdef double length, last = INFINITY, first = INFINITY
    for i in range(dof):
        total[i] = 0.0
    for turn in range(STEPS):
        gradient_at(problem, total, problem.points, step)
        for i in range(dof):
            for k in range(i):
                step[i] -= factor[i * MOST + k] * step[k]
            step[i] /= factor[i * MOST + i]
        length = 0.0
        for i in range(dof - 1, -1, -1):
            for k in range(i + 1, dof):
                step[i] -= factor[k * MOST + i] * step[k]
            step[i] /= factor[i * MOST + i]
            length += step[i] * step[i]
        length = sqrt(length)
        if turn == 0:
            first = length
        if not length < 0.5 * last:
            break
        last = length
        for i in range(dof):
            total[i] -= step[i]
    return first


cdef double look(Problem *problem, const Surface *surface) noexcept nogil:
    """The cost of a surface; distances and weights are its own after that."""
    linearize(surface, problem.points, problem.distance, NULL)
    weigh(problem.kernel, problem.scale, problem.distance, problem.points.n, problem.weight)
    return cost_of(problem.kernel, problem.scale, problem.distance, problem.points.n)


cdef double go_on(Problem *problem, Surface *there) noexcept nogil:
    """The surface after steps with one curvature, and the length of the first in norms of the distances.

    Where there is no curvature of a minimum it stays, and that is 0.
    """
    cdef int dof = KINDS[problem.surface.kind].dof, i
    cdef Py_ssize_t n = problem.points.n, p
    cdef double squares = 0.0, norm
    cdef double[MOST * MOST] factor
    cdef double[MOST] total
    cdef bint found
    there[0] = problem.surface
    linearize(there, problem.points, problem.distance, problem.jacobian)
    weigh(problem.kernel, problem.scale, problem.distance, n, problem.weight)
    for p in range(n):
        squares += problem.weight[p] * problem.distance[p] * problem.distance[p]
    norm = sqrt(squares)
    if not whiten(problem):
        return 0.0
    if norm > UNCURVED * sqrt(<double>n):
        found = curve(problem, DIFFERENCES[0] * norm, factor) or curve(problem, DIFFERENCES[1] * norm, factor)
        if not found:
            return 0.0
    else:
        for i in range(MOST * MOST):
            factor[i] = 1.0 if i % (MOST + 1) == 0 else 0.0
    norm = descend(problem, factor, total) / (norm + TINY)
    moved(problem, total, there)
    return norm


cdef bint come_to_rest(Problem *problem) noexcept nogil:
    """Rounds, while they lead to no higher cost; whether any has led anywhere."""
    cdef Surface there
    cdef double length, before, distance, unseen
    cdef bint found = False
    cdef int turn
    for turn in range(ROUNDS):
        length = go_on(problem, &there)
        before = look(problem, &problem.surface)
        distance = problem.scale * sqrt(2.0 * before / problem.points.n) + TINY
        unseen = UNSEEN + min(UNSEEN_DISTANCE / distance, MOST_UNSEEN)
        if length == 0.0 or not look(problem, &there) <= before * (1.0 + unseen):
            break
        problem.surface, found = there, True
        if length <= AT_REST:
            break
    return found


def newton(int kind, const double[::1] row, const double[:, ::1] points, int kernel, double scale, pairs):
    """The row (9,) of the stationary point that the surface of a row is close to; None where it is near none.

    `pairs` are those of the components of a step that are along the basis of the axis; see
    `fitting.primitives.primitive.Chart.across`.
    """
    cdef Problem problem
    cdef Py_ssize_t n = points.shape[0], i, count
    cdef int k
    cdef bint found
    cdef double *room
    cdef double *some
    result = np.empty(9)
    cdef double[::1] view = result
    load(&problem.surface, kind, &row[0])
    problem.kernel, problem.scale, problem.chart.pairs = kernel, scale, len(pairs)
    for k in range(problem.chart.pairs):
        problem.chart.first[k] = pairs[k][0]
    problem.every = max(1, -(-n // CURVATURE_POINTS))
    count = -(-n // problem.every)
    room = room_for((5 + KINDS[kind].dof) * n + 3 * count)
    with nogil:
        problem.points = problem.some = columns(points, room)
        problem.distance, problem.weight, problem.jacobian = room + 3 * n, room + 4 * n, room + 5 * n
        if problem.every > 1:
            some = room + (5 + KINDS[kind].dof) * n
            for i in range(count):
                some[i] = points[i * problem.every, 0]
                some[count + i] = points[i * problem.every, 1]
                some[2 * count + i] = points[i * problem.every, 2]
            problem.some.x, problem.some.y, problem.some.z = some, some + count, some + 2 * count
            problem.some.n = count
        found = come_to_rest(&problem)
    free(room)
    store(&problem.surface, &view[0])
    return result if found else None
