# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Linear systems that starts come from, reweighted: many small ones at once. Bounds and axes of many points."""

from libc.math cimport INFINITY, fabs, sqrt
from libc.stdlib cimport free

import numpy as np

cdef extern from "geometry/small.h" nogil:
    void weighted_sums(
        const double *weight, const double *d, const double *columns, Py_ssize_t n, int m, double *scratch,
        double *normal, int width, double *gradient
    )
    void remainder_of(
        const double *columns, const double *target, Py_ssize_t n, int m, const double *factors, double *rest
    )
    void down_weigh(const double *rest, Py_ssize_t n, double middle, double *weight)
    void profile(
        const double *x, const double *y, const double *z, Py_ssize_t n, const double *axis, const double *foot,
        double *h, double *rho
    )

cdef extern from "geometry/median.h" nogil:
    bint absolutes(const double *distance, Py_ssize_t n, double *absolute)
    double selected(double *values, Py_ssize_t n, Py_ssize_t rank)
    double median(double *values, Py_ssize_t n)

cdef extern from "geometry/small.h" nogil:
    double TINY
    enum:
        MOST
    bint solve(
        const double *normal, const double *gradient, const double *scales, double damping, int dof, double *step
    )
    void eigen(double *matrix, double *values, double *vectors)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


cdef void solve_overdetermined(
    const double *columns, const double *target, Py_ssize_t n, int m, int rounds, double *room, double *solution
) noexcept nogil:
    """Reweighted least squares for  sum columns[k] solution[k] = target (n,);  the room is (3, n).

    Weights are 1 / (1 + (residual / median)^2) after the first round.
    """
    cdef double normal[MOST * MOST]
    cdef double right[MOST]
    cdef double scales[MOST]
    cdef double *weight = room
    cdef double *rest = room + n
    cdef double *scratch = room + 2 * n
    cdef double trace, ridge
    cdef Py_ssize_t i
    cdef int j, turn
    for j in range(m):
        solution[j] = 0.0
    for i in range(n):
        weight[i] = 1.0
    for turn in range(rounds):
        weighted_sums(weight, target, columns, n, m, scratch, normal, MOST, right)
        trace = 0.0
        for j in range(m):
            trace += normal[j * MOST + j]
            right[j] = -right[j]
        for j in range(m):
            normal[j * MOST + j] += 1e-13 * trace + TINY
            scales[j] = sqrt(normal[j * MOST + j])
        ridge = 0.0
        while not solve(normal, right, scales, ridge, m, solution) and ridge < 1.0:
            ridge = max(1e3 * ridge, 1e-15)
        if turn + 1 == rounds:
            return
        remainder_of(columns, target, n, m, solution, rest)
        if not absolutes(rest, n, scratch):
            return
        down_weigh(rest, n, median(scratch, n) + 1e-12, weight)


def solve_linear(const double[:, :, ::1] columns, const double[:, ::1] target, int rounds):
    """Solutions (K, m) for columns (K, m, N);  see `fitting.geometry.axes.robust_linear_solve`."""
    cdef Py_ssize_t k, n = columns.shape[2]
    cdef int m = columns.shape[1]
    if m > MOST:
        raise ValueError(f"at most {MOST} unknowns, not {m}")
    result = np.empty((columns.shape[0], m))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(3 * n)
    with nogil:
        for k in range(columns.shape[0]):
            solve_overdetermined(&columns[k, 0, 0], &target[k, 0], n, m, rounds, room, &view[k, 0])
    free(room)
    return result


cdef bint enclose(const double[:, ::1] points, double *low, double *high) noexcept nogil:
    """The least and the greatest coordinates (3,) of points (N, 3); whether all are finite."""
    cdef double least[3]
    cdef double most[3]
    cdef double nothing[3]
    cdef double value
    cdef Py_ssize_t i
    cdef int axis
    for axis in range(3):
        least[axis], most[axis], nothing[axis] = INFINITY, -INFINITY, 0.0
    for i in range(points.shape[0]):
        for axis in range(3):
            value = points[i, axis]
            least[axis] = value if value < least[axis] else least[axis]
            most[axis] = value if value > most[axis] else most[axis]
            nothing[axis] += 0.0 * value
    for axis in range(3):
        low[axis], high[axis] = least[axis], most[axis]
    return nothing[0] + nothing[1] + nothing[2] == 0.0


def bounds(const double[:, ::1] points):
    """The least and the greatest coordinates (2, 3) of points (N, 3); and whether all are finite."""
    result = np.empty((2, 3))
    cdef double[:, ::1] view = result
    cdef bint finite
    with nogil:
        finite = enclose(points, &view[0, 0], &view[1, 0])
    return result, finite


cdef double product(const double *a, const double *b, Py_ssize_t n) noexcept nogil:
    """The inner product of columns (n,), in four sums."""
    cdef double first = 0.0, second = 0.0, third = 0.0, fourth = 0.0
    cdef Py_ssize_t i = 0
    while i + 4 <= n:
        first += a[i] * b[i]
        second += a[i + 1] * b[i + 1]
        third += a[i + 2] * b[i + 2]
        fourth += a[i + 3] * b[i + 3]
        i += 4
    while i < n:
        first += a[i] * b[i]
        i += 1
    return (first + second) + (third + fourth)


cdef void reflect(double *columns, Py_ssize_t n, int j, double[:, ::1] triangle) noexcept nogil:
    """Clear column j of columns (3, n) below its row j by a reflection, as LAPACK's dgeqr2; fill in row j."""
    cdef double *column = columns + j * n
    cdef double *other
    cdef double below, factor, diagonal, scale
    cdef Py_ssize_t i
    cdef int l
    triangle[j, j] = column[j]
    below = product(column + j + 1, column + j + 1, n - j - 1)
    if below > 0.0:
        diagonal = sqrt(column[j] * column[j] + below)
        if column[j] > 0.0:
            diagonal = -diagonal
        triangle[j, j] = diagonal
        scale = (diagonal - column[j]) * diagonal
        column[j] -= diagonal
        for l in range(j + 1, 3):
            other = columns + l * n
            factor = product(column + j, other + j, n - j) / scale
            for i in range(j, n):
                other[i] -= factor * column[i]
    for l in range(j + 1, 3):
        triangle[j, l] = columns[l * n + j]


def triangle_of(const double[:, ::1] points):
    """R (3, 3) of the factors Q R of points (N, 3), from which their centroid is taken; of two with a row of zeros."""
    cdef Py_ssize_t i, n = points.shape[0], rows = max(n, 3)
    cdef int axis
    cdef double total
    result = np.zeros((3, 3))
    cdef double[:, ::1] triangle = result
    cdef double *columns = room_for(3 * rows)
    with nogil:
        for axis in range(3):
            total = 0.0
            for i in range(n):
                total += points[i, axis]
            for i in range(n):
                columns[axis * rows + i] = points[i, axis] - total / n
            for i in range(n, rows):
                columns[axis * rows + i] = 0.0
        for axis in range(3):
            reflect(columns, rows, axis, triangle)
    free(columns)
    return result


cdef void solve_circle(double *columns, Py_ssize_t n, int rounds, double *room, double *solution) noexcept nogil:
    """For  x^2 + y^2 = a x + b y + c  with columns (4, n): x, y, and room; the other room is (3, n)."""
    cdef Py_ssize_t i
    for i in range(n):
        columns[2 * n + i] = 1.0
        columns[3 * n + i] = columns[i] * columns[i] + columns[n + i] * columns[n + i]
    solve_overdetermined(columns, columns + 3 * n, n, 3, rounds, room, solution)


def solve_circles(const double[:, ::1] x, const double[:, ::1] y, int rounds):
    """Solutions (K, 3) of  x^2 + y^2 = a x + b y + c;  see `fitting.geometry.axes.circles`."""
    cdef Py_ssize_t k, i, n = x.shape[1]
    result = np.empty((x.shape[0], 3))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(7 * n)
    cdef double *columns = room + 3 * n
    with nogil:
        for k in range(x.shape[0]):
            for i in range(n):
                columns[i], columns[n + i] = x[k, i], y[k, i]
            solve_circle(columns, n, rounds, room, &view[k, 0])
    free(room)
    return result


def solve_profiles(const double[:, ::1] points, const double[:, ::1] axes, const double[:, ::1] feet, int rounds):
    """The same of the profiles (rho, h) of points (N, 3) about K axes (K, 3) through feet (K, 3)."""
    cdef Py_ssize_t k, i, n = points.shape[0]
    result = np.empty((axes.shape[0], 3))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(10 * n)
    cdef double *columns = room + 3 * n
    cdef double *x = room + 7 * n
    with nogil:
        for i in range(n):
            x[i], x[n + i], x[2 * n + i] = points[i, 0], points[i, 1], points[i, 2]
        for k in range(axes.shape[0]):
            profile(x, x + n, x + 2 * n, n, &axes[k, 0], &feet[k, 0], columns + n, columns)
            solve_circle(columns, n, rounds, room, &view[k, 0])
    free(room)
    return result


def solve_cones(const double[:, ::1] x, const double[:, ::1] y, const double[:, ::1] height, int rounds):
    """Solutions (K, 5) of  x^2 + y^2 = a x + b y + m h^2 + e h + f,  and the median heights (K,)."""
    cdef Py_ssize_t k, i, n = x.shape[1]
    result, middle = np.empty((x.shape[0], 5)), np.empty(x.shape[0])
    cdef double[:, ::1] view = result
    cdef double[::1] middle_view = middle
    cdef double *room = room_for(9 * n)
    cdef double *columns = room + 3 * n
    cdef double *target = room + 8 * n
    with nogil:
        for k in range(x.shape[0]):
            for i in range(n):
                columns[i], columns[n + i], columns[3 * n + i] = x[k, i], y[k, i], height[k, i]
                columns[2 * n + i], columns[4 * n + i] = height[k, i] * height[k, i], 1.0
                target[i] = x[k, i] * x[k, i] + y[k, i] * y[k, i]
                room[i] = height[k, i]
            middle_view[k] = median(room, n)
            solve_overdetermined(columns, target, n, 5, rounds, room, &view[k, 0])
    free(room)
    return result, middle


cdef Py_ssize_t find_spine(
    const double[::1] cylinder, const double[:, ::1] points, const double[:, ::1] normals, double *spine, double *off,
    double *scratch
) noexcept nogil:
    """Where points (N, 3) near a cylinder lead back along their normals by its radius, (3, count); the count.

    The rooms are for (3, n), n and n numbers; points farther off than twice the median are left out.
    """
    cdef Py_ssize_t i, n = points.shape[0], count = 0
    cdef double x[3]
    cdef double height, side, reach
    cdef int axis
    for i in range(n):
        for axis in range(3):
            x[axis] = points[i, axis] - cylinder[3 + axis]
        height = x[0] * cylinder[0] + x[1] * cylinder[1] + x[2] * cylinder[2]
        side = 0.0
        for axis in range(3):
            x[axis] -= height * cylinder[axis]
            side += x[axis] * normals[i, axis]
        off[i] = scratch[i] = fabs(sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]) - cylinder[8])
        for axis in range(3):
            spine[axis * n + i] = points[i, axis] - (-cylinder[8] if side < 0.0 else cylinder[8]) * normals[i, axis]
    reach = 2.0 * median(scratch, n)
    for i in range(n):
        if off[i] <= reach:
            for axis in range(3):
                spine[axis * n + count] = spine[axis * n + i]
            count += 1
    return count


def solve_spine(
    const double[::1] cylinder, const double[:, ::1] points, const double[:, ::1] normals, int rounds
):
    """Axis (3,), centre (3,) and radius of the circle that a cylinder's spine is; see `Torus.rows_along`."""
    cdef Py_ssize_t i, n = points.shape[0], count
    cdef double center[3]
    cdef double scatter[9]
    cdef double values[3]
    cdef double axes[9]
    cdef double circle[3]
    cdef double x, y
    cdef int a, b
    axis, middle = np.empty(3), np.empty(3)
    cdef double[::1] axis_view = axis
    cdef double[::1] middle_view = middle
    cdef double *spine = room_for(12 * n)
    cdef double *columns = spine + 3 * n
    with nogil:
        count = find_spine(cylinder, points, normals, spine, columns, columns + n)
        for a in range(3):
            center[a] = 0.0
            for i in range(count):
                center[a] += spine[a * n + i] / count
            for i in range(count):
                spine[a * n + i] -= center[a]
        for a in range(3):
            for b in range(a + 1):
                x = 0.0
                for i in range(count):
                    x += spine[a * n + i] * spine[b * n + i]
                scatter[3 * a + b] = scatter[3 * b + a] = x
        eigen(scatter, values, axes)
        for i in range(count):
            columns[i] = columns[count + i] = 0.0
            for a in range(3):
                columns[i] += spine[a * n + i] * axes[6 + a]
                columns[count + i] += spine[a * n + i] * axes[3 + a]
        solve_circle(columns, count, rounds, columns + 4 * n, circle)
        x, y = circle[0] / 2.0, circle[1] / 2.0
        for a in range(3):
            axis_view[a], middle_view[a] = axes[a], center[a] + x * axes[6 + a] + y * axes[3 + a]
    free(spine)
    return axis, middle, sqrt(max(circle[2] + x * x + y * y, 1e-12))


cdef void reduced_scatter(const double *scatter, double *coupling, double *reduced) noexcept nogil:
    """Of the lower triangle of a scatter (6, 6) of moments and normals: C = N^-1 K and M - K^T C, (3, 3) each."""
    cdef double lower[3 * MOST]
    cdef double right[3]
    cdef double scales[3]
    cdef double column[3]
    cdef double trace = 0.0
    cdef int i, j, k
    for i in range(6):
        trace += scatter[i * MOST + i]
    for i in range(3):
        for j in range(i + 1):
            lower[i * MOST + j] = scatter[(3 + i) * MOST + 3 + j]
        lower[i * MOST + i] += 1e-12 * trace
        scales[i] = sqrt(lower[i * MOST + i])
    for j in range(3):
        for i in range(3):
            right[i] = -scatter[(3 + i) * MOST + j]
        solve(lower, right, scales, 0.0, 3, column)
        for i in range(3):
            coupling[3 * i + j] = column[i]
    for i in range(3):
        for j in range(i + 1):
            reduced[3 * i + j] = scatter[i * MOST + j]
            for k in range(3):
                reduced[3 * i + j] -= scatter[(3 + k) * MOST + i] * coupling[3 * k + j]
            reduced[3 * j + i] = reduced[3 * i + j]


def revolution_axis(const double[:, ::1] points, const double[:, ::1] normals, int rounds):
    """Direction (3,), moment (3,) and eigenvalues (3,); see `fitting.geometry.axes.revolution_axis`."""
    cdef Py_ssize_t i, n = points.shape[0]
    cdef int j, turn
    cdef double scatter[MOST * MOST]
    cdef double unused[MOST]
    cdef double line[6]
    cdef double coupling[9]
    cdef double reduced[9]
    cdef double vectors[9]
    cdef double middle, total
    direction, moment, eigenvalues = np.empty(3), np.empty(3), np.empty(3)
    cdef double[::1] direction_view = direction
    cdef double[::1] moment_view = moment
    cdef double[::1] values = eigenvalues
    cdef double *lines = room_for(9 * n)
    cdef double *weight = lines + 6 * n
    cdef double *rest = lines + 7 * n
    cdef double *scratch = lines + 8 * n
    with nogil:
        for i in range(n):
            lines[i] = points[i, 1] * normals[i, 2] - points[i, 2] * normals[i, 1]
            lines[n + i] = points[i, 2] * normals[i, 0] - points[i, 0] * normals[i, 2]
            lines[2 * n + i] = points[i, 0] * normals[i, 1] - points[i, 1] * normals[i, 0]
            for j in range(3):
                lines[(3 + j) * n + i] = normals[i, j]
            weight[i], scratch[i] = 1.0 / n, 0.0
        for turn in range(rounds):
            weighted_sums(weight, scratch, lines, n, 6, rest, scatter, MOST, unused)
            reduced_scatter(scatter, coupling, reduced)
            eigen(reduced, &values[0], vectors)
            for j in range(3):
                line[j] = direction_view[j] = vectors[j]
            for j in range(3):
                line[3 + j] = moment_view[j] = -(
                    coupling[3 * j] * line[0] + coupling[3 * j + 1] * line[1] + coupling[3 * j + 2] * line[2]
                )
            for i in range(n):
                scratch[i] = 0.0
            remainder_of(lines, scratch, n, 6, line, rest)
            for i in range(n):
                rest[i] = scratch[i] = fabs(rest[i])
            middle = 0.5 * selected(scratch, n, n // 2) + 1e-12
            total = 0.0
            for i in range(n):
                weight[i] = 1.0 / (rest[i] + middle)
                total += weight[i]
            for i in range(n):
                weight[i] /= total
    free(lines)
    return direction, moment, eigenvalues
