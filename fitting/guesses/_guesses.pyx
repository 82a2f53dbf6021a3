# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Surfaces that linear systems lead to, one for each candidate axis, as rows of nine numbers."""

from libc.math cimport atan, fabs, sin, sqrt
from libc.stdlib cimport free

import numpy as np

cdef extern from "guesses/systems.h" nogil:
    double TINY
    enum:
        MOST
        ROOM
    void basis(const double *axis, double *u, double *v)
    void normalize(double *direction)
    double dot(const double *a, const double *b)
    double median(double *values, Py_ssize_t n)
    double selected(double *values, Py_ssize_t n, Py_ssize_t rank)
    void eigen(double *matrix, double *values, double *vectors)
    bint solve(
        const double *normal, const double *gradient, const double *scales, double damping, int dof, double *step
    )
    void weighted_sums(
        const double *weight, const double *d, const double *columns, Py_ssize_t n, int m, double *scratch,
        double *normal, int width, double *gradient
    )
    void remainder_of(
        const double *columns, const double *target, Py_ssize_t n, int m, const double *factors, double *rest
    )
    void profile(
        const double *x, const double *y, const double *z, Py_ssize_t n, const double *axis, const double *foot,
        double *h, double *rho
    )
    void solve_overdetermined(
        const double *columns, const double *target, Py_ssize_t n, int m, int rounds, double *room, double *solution
    )
    double circle_through(double *columns, Py_ssize_t n, int rounds, double *room, double *center)
    void seen_along(const double *x, Py_ssize_t n, const double *axis, double *along)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL


def solve_linear(const double[:, :, ::1] columns, const double[:, ::1] target, int rounds):
    """Solutions (K, m) for columns (K, m, N);  see `fitting.guesses.oriented.robust_linear_solve`."""
    cdef Py_ssize_t k, n = columns.shape[2]
    cdef int m = columns.shape[1]
    if m > MOST:
        raise ValueError(f"at most {MOST} unknowns, not {m}")
    result = np.empty((columns.shape[0], m))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(ROOM * n)
    with nogil:
        for k in range(columns.shape[0]):
            solve_overdetermined(&columns[k, 0, 0], &target[k, 0], n, m, rounds, room, &view[k, 0])
    free(room)
    return result


cdef void lay(const double *points, Py_ssize_t n, double *columns) noexcept nogil:
    """Points (n, 3) as columns (3, n)."""
    cdef Py_ssize_t i
    for i in range(n):
        columns[i], columns[n + i], columns[2 * n + i] = points[3 * i], points[3 * i + 1], points[3 * i + 2]


cdef void write(
    double *row, const double *axis, const double *anchor, double angle, double major, double offset
) noexcept nogil:
    """A row (9,); see `geometry/surface.h`."""
    cdef int j
    for j in range(3):
        row[j], row[3 + j] = axis[j], anchor[j]
    row[6], row[7], row[8] = angle, major, offset


cdef void place(const double *u, const double *v, double x, double y, double *point) noexcept nogil:
    """The point (3,) at x, y along two directions."""
    cdef int j
    for j in range(3):
        point[j] = x * u[j] + y * v[j]


cdef void look_along(
    const double *x, Py_ssize_t n, const double *axis, double *u, double *v, double *across
) noexcept nogil:
    """The basis u, v of an axis, and the coordinates of points (3, n) in it, (2, n)."""
    basis(axis, u, v)
    seen_along(x, n, u, across)
    seen_along(x, n, v, across + n)


def spheres(const double[:, :, ::1] groups, int rounds):
    """The algebraic sphere  |x|^2 = 2 c.x + b  of each of K groups of points (K, N, 3), as rows (K, 9)."""
    cdef Py_ssize_t k, i, n = groups.shape[1]
    cdef double[3] axis = [0.0, 0.0, 1.0]
    cdef double found[4]
    cdef int j
    result = np.empty((groups.shape[0], 9))
    cdef double[:, ::1] view = result
    cdef double *columns = room_for((5 + ROOM) * n)
    with nogil:
        for k in range(groups.shape[0]):
            lay(&groups[k, 0, 0], n, columns)
            for i in range(n):
                columns[3 * n + i] = 1.0
                columns[4 * n + i] = dot(&groups[k, i, 0], &groups[k, i, 0])
            solve_overdetermined(columns, columns + 4 * n, n, 4, rounds, columns + 5 * n, found)
            for j in range(3):
                found[j] /= 2.0
            write(&view[k, 0], axis, found, 0.0, 0.0, sqrt(max(found[3] + dot(found, found), 1e-12)))
    free(columns)
    return result


def cylinders(const double[:, ::1] axes, const double[:, ::1] points, int rounds):
    """For each axis (K, 3) the circle through points (N, 3) as seen along it, as rows (K, 9)."""
    cdef Py_ssize_t k, n = points.shape[0]
    cdef double u[3]
    cdef double v[3]
    cdef double center[2]
    cdef double foot[3]
    cdef double radius
    result = np.empty((axes.shape[0], 9))
    cdef double[:, ::1] view = result
    cdef double *x = room_for((7 + ROOM) * n)
    cdef double *columns = x + 3 * n
    with nogil:
        lay(&points[0, 0], n, x)
        for k in range(axes.shape[0]):
            look_along(x, n, &axes[k, 0], u, v, columns)
            radius = circle_through(columns, n, rounds, columns + 4 * n, center)
            place(u, v, center[0], center[1], foot)
            write(&view[k, 0], &axes[k, 0], foot, 0.0, 0.0, radius)
    free(x)
    return result


def cones(const double[:, ::1] axes, const double[:, ::1] points, int rounds):
    """For each axis (K, 3) the quadric  x^2 + y^2 = a x + b y + m h^2 + e h + f,  m = tan^2 t,  as rows (K, 9)."""
    cdef Py_ssize_t k, i, n = points.shape[0]
    cdef double u[3]
    cdef double v[3]
    cdef double axis[3]
    cdef double foot[3]
    cdef double found[5]
    cdef double steepness, apex, side, angle
    cdef int j
    result = np.empty((axes.shape[0], 9))
    cdef double[:, ::1] view = result
    cdef double *x = room_for((9 + ROOM) * n)
    cdef double *columns = x + 3 * n
    cdef double *height = columns + 3 * n
    cdef double *target = columns + 5 * n
    cdef double *room = columns + 6 * n
    with nogil:
        lay(&points[0, 0], n, x)
        for k in range(axes.shape[0]):
            look_along(x, n, &axes[k, 0], u, v, columns)
            seen_along(x, n, &axes[k, 0], height)
            for i in range(n):
                columns[2 * n + i], columns[4 * n + i] = height[i] * height[i], 1.0
                target[i] = columns[i] * columns[i] + columns[n + i] * columns[n + i]
            solve_overdetermined(columns, target, n, 5, rounds, room, found)
            steepness = min(max(found[2], 0.01), 100.0)
            apex, angle = -found[3] / (2.0 * steepness), atan(sqrt(steepness))
            side = 1.0 if median(height, n) > apex else -1.0
            for j in range(3):
                axis[j] = side * axes[k, j]
            place(u, v, found[0] / 2.0, found[1] / 2.0, foot)
            write(&view[k, 0], axis, foot, angle, 0.0, -side * apex * sin(angle))
    free(x)
    return result


cdef void torus_about(
    const double *x, Py_ssize_t n, const double *axis, double *foot, int rounds, double smallest, double *columns,
    double *row
) noexcept nogil:
    """The circle through the profile of points (3, n) about an axis through a foot; room is for (4 + ROOM, n)."""
    cdef double center[2]
    cdef double radius
    cdef int j
    profile(x, x + n, x + 2 * n, n, axis, foot, columns + n, columns)
    radius = circle_through(columns, n, rounds, columns + 4 * n, center)
    for j in range(3):
        foot[j] += center[1] * axis[j]
    write(row, axis, foot, 0.0, max(fabs(center[0]), smallest), radius)


def tori(
    const double[:, ::1] axes, const double[:, ::1] points, const double[:, ::1] normals, const double[::1] direction,
    const double[::1] point, int rounds, double smallest
):
    """For each of 2 K + 1 lines the circle through the profile (rho, h) of points (N, 3) about it, as rows (2 K + 1, 9).

    Two lines for each axis (K, 3): one passes where the normal lines meet it,  (n x a) . (x - p) = 0,  the other
    through the center of the circle that the points describe when seen along it. The last is given by its direction
    and a point. Major radii are at least the smallest.
    """
    cdef Py_ssize_t k, i, n = points.shape[0], count = axes.shape[0]
    cdef double u[3]
    cdef double v[3]
    cdef double found[2]
    cdef double foot[3]
    cdef int j
    result = np.empty((2 * count + 1, 9))
    cdef double[:, ::1] view = result
    cdef double *x = room_for((12 + ROOM) * n)
    cdef double *normal = x + 3 * n
    cdef double *seen = normal + 3 * n
    cdef double *columns = seen + 2 * n
    with nogil:
        lay(&points[0, 0], n, x)
        lay(&normals[0, 0], n, normal)
        for k in range(count):
            look_along(x, n, &axes[k, 0], u, v, seen)
            seen_along(normal, n, v, columns)
            seen_along(normal, n, u, columns + n)
            for i in range(n):
                columns[n + i] = -columns[n + i]
                columns[2 * n + i] = columns[i] * seen[i] + columns[n + i] * seen[n + i]
            solve_overdetermined(columns, columns + 2 * n, n, 2, rounds, columns + 4 * n, found)
            place(u, v, found[0], found[1], foot)
            torus_about(x, n, &axes[k, 0], foot, rounds, smallest, columns, &view[k, 0])
            for i in range(2 * n):
                columns[i] = seen[i]
            circle_through(columns, n, rounds, columns + 4 * n, found)
            place(u, v, found[0], found[1], foot)
            torus_about(x, n, &axes[k, 0], foot, rounds, smallest, columns, &view[count + k, 0])
        for j in range(3):
            foot[j] = point[j]
        torus_about(x, n, &direction[0], foot, rounds, smallest, columns, &view[2 * count, 0])
    free(x)
    return result


cdef void bend(
    const double *x, Py_ssize_t n, const double *cylinder, int rounds, double flattest, double *height, double *row
) noexcept nogil:
    """The torus (9,) that a cylinder (9,) bends into; the room is for (9 + ROOM, n)."""
    cdef Py_ssize_t i
    cdef double u[3]
    cdef double v[3]
    cdef double found[7]
    cdef double along[3]
    cdef double towards[3]
    cdef double axis[3]
    cdef double anchor[3]
    cdef double middle = 0.0, rho, major, from_u, from_v
    cdef double *columns = height + n
    cdef double *target = columns + 7 * n
    cdef int j
    look_along(x, n, cylinder, u, v, columns + 2 * n)
    from_u, from_v = dot(cylinder + 3, u), dot(cylinder + 3, v)
    seen_along(x, n, cylinder, height)
    for i in range(n):
        middle += height[i] / n
    for i in range(n):
        height[i] -= middle
        columns[2 * n + i] -= from_u
        columns[3 * n + i] -= from_v
        rho = sqrt(columns[2 * n + i] * columns[2 * n + i] + columns[3 * n + i] * columns[3 * n + i]) + TINY
        for j in range(2):
            columns[(2 + j) * n + i] /= rho
            columns[(4 + j) * n + i] = height[i] * columns[(2 + j) * n + i]
            columns[j * n + i] = 0.5 * height[i] * columns[(4 + j) * n + i]
        columns[6 * n + i] = 1.0
        target[i] = rho - cylinder[8]
    solve_overdetermined(columns, target, n, 7, rounds, target + n, found)
    if found[0] * found[0] + found[1] * found[1] < flattest * flattest:
        found[0] = flattest
    major = 1.0 / sqrt(found[0] * found[0] + found[1] * found[1])
    for j in range(3):
        towards[j] = major * (found[0] * u[j] + found[1] * v[j])
        along[j] = cylinder[j] + found[4] * u[j] + found[5] * v[j]
        anchor[j] = cylinder[3 + j] + middle * cylinder[j] + found[2] * u[j] + found[3] * v[j] + major * towards[j]
    axis[0] = along[1] * towards[2] - along[2] * towards[1]
    axis[1] = along[2] * towards[0] - along[0] * towards[2]
    axis[2] = along[0] * towards[1] - along[1] * towards[0]
    normalize(axis)
    write(row, axis, anchor, 0.0, major, cylinder[8] + found[6])


def bent(const double[:, ::1] cylinders, const double[:, ::1] points, int rounds, double flattest):
    """The tori (K, 9) that cylinders (K, 9) bend into, as points (N, 3) say; no normals are needed.

    An axis of curvature k towards the unit vector e is k h^2 / 2 off at height h, and moves the surface by that
    times the cosine of the angle from e. Shift, tilt and radius are free, too, to first order. Curvatures are at
    least the flattest.
    """
    cdef Py_ssize_t k, n = points.shape[0]
    result = np.empty((cylinders.shape[0], 9))
    cdef double[:, ::1] view = result
    cdef double *x = room_for((12 + ROOM) * n)
    with nogil:
        lay(&points[0, 0], n, x)
        for k in range(cylinders.shape[0]):
            bend(x, n, &cylinders[k, 0], rounds, flattest, x + 3 * n, &view[k, 0])
    free(x)
    return result


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


def tube(const double[::1] cylinder, const double[:, ::1] points, const double[:, ::1] normals, int rounds):
    """The torus (9,) whose tube has the radius of a cylinder (9,), bent as the normals (N, 3) of points (N, 3) say.

    Going back along the normals, of either sign, by the radius leads to the circle in the middle of the tube.
    """
    cdef Py_ssize_t i, n = points.shape[0], count
    cdef double middle[3]
    cdef double scatter[9]
    cdef double values[3]
    cdef double axes[9]
    cdef double center[2]
    cdef double total
    cdef int a, b
    result = np.empty(9)
    cdef double[::1] view = result
    cdef double *spine = room_for((9 + ROOM) * n)
    cdef double *columns = spine + 3 * n
    with nogil:
        count = find_spine(cylinder, points, normals, spine, columns, columns + n)
        for a in range(3):
            middle[a] = 0.0
            for i in range(count):
                middle[a] += spine[a * n + i] / count
            for i in range(count):
                spine[a * n + i] -= middle[a]
        for a in range(3):
            for b in range(a + 1):
                total = 0.0
                for i in range(count):
                    total += spine[a * n + i] * spine[b * n + i]
                scatter[3 * a + b] = scatter[3 * b + a] = total
        eigen(scatter, values, axes)
        for i in range(count):
            columns[i] = columns[count + i] = 0.0
            for a in range(3):
                columns[i] += spine[a * n + i] * axes[6 + a]
                columns[count + i] += spine[a * n + i] * axes[3 + a]
        total = circle_through(columns, count, rounds, columns + 4 * n, center)
        for a in range(3):
            middle[a] += center[0] * axes[6 + a] + center[1] * axes[3 + a]
        write(&view[0], axes, middle, 0.0, total, cylinder[8])
    free(spine)
    return result


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
    """Direction (3,), moment (3,) and eigenvalues (3,); see `fitting.guesses.oriented.revolution_axis`."""
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


def subsets(const double[:, ::1] shares, Py_ssize_t n):
    """Distinct numbers below n, (K, m): the share, from 0 to 1, says which of those that are left; any is as likely."""
    cdef Py_ssize_t k, j, i, place, number
    result = np.empty((shares.shape[0], shares.shape[1]), np.intp)
    cdef Py_ssize_t[:, ::1] view = result
    for k in range(shares.shape[0]):
        for j in range(shares.shape[1]):
            number = min(<Py_ssize_t> (shares[k, j] * (n - j)), n - j - 1)
            # The taken ones, in ascending order, each move it up by one.
            place = 0
            while place < j and view[k, place] <= number:
                number += 1
                place += 1
            for i in range(j, place, -1):
                view[k, i] = view[k, i - 1]
            view[k, place] = number
    return result
