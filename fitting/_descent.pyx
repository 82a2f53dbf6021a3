# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The inner loops of the search, compiled: distances, their derivatives, Levenberg-Marquardt, annealing.

A surface is a row of nine numbers, in a frame whose origin is near the points:

=========  ====================  ===============================  =========  =======  ==================
kind       row[0:3]              row[3:6]                         row[6]     row[7]   row[8]
=========  ====================  ===============================  =========  =======  ==================
plane      unit normal n         a point
sphere                           centre c                                             radius
cylinder   unit axis a           foot f of the origin on it                           radius
cone       unit axis a           foot f of the origin on it       half-      -        offset s
                                                                  angle t
torus      unit axis a           centre c                         -          major    minor radius r
                                                                             radius R
=========  ====================  ===============================  =========  =======  ==================

Signed distances, with h the height along the axis, from f or c, q the vector from the axis to x, and rho = |q|:
n . (x - p);  |x - c| - r;  rho - r;  rho cos t - h sin t - s, or the distance from the apex where that is the
closest point;  hypot(rho - R, h) - r.

A step has as many components as the kind has degrees of freedom. Where there is an axis, the first two tilt it
[rad] towards u and v of its basis, about f or c; then, but for the plane, come shifts along u and v (the sphere:
along x, y, z); then what is left, in the order of the row (the torus: along the axis first; the plane: along the
normal). Derivatives:

plane     u.x, v.x, -1
sphere    -(x - c) / |x - c|, -1
cylinder  a tilt da changes q by -h da - (x . da) a with q orthogonal to a, so drho = -h (q . da) / rho;
          a shift df gives drho = -(q . df) / rho; -1
cone      tilt -h (q . da) / rho cos t - (q . da) sin t; shift -(q . df) / rho cos t; dt: -rho sin t - h cos t;
          ds: -1. Behind the apex dd = -w . dc with w the unit vector from the apex c = f + H a, H = -s / sin t
torus     with g = (rho - R, h) / hypot(rho - R, h): tilt drho = -h (q . da) / rho, dh = q . da; shift across
          drho = -(q . df) / rho; along dh = -1; dR: -g0; dr: -1
"""

from libc.math cimport M_PI, cos, fabs, hypot, isfinite, log, sin, sqrt
from libc.stdlib cimport free, malloc
from libc.string cimport memcpy

import numpy as np

cdef extern from *:
    """
    /* Vector units may add up such a sum in parts: the result depends on the build, not on the run. */
    static double inner(const double *a, const double *b, Py_ssize_t n) {
        double total = 0.0;
        #pragma omp simd reduction(+:total)
        for (Py_ssize_t i = 0; i < n; i++)
            total += a[i] * b[i];
        return total;
    }
    """
    double inner(const double *a, const double *b, Py_ssize_t n) noexcept nogil

cdef enum:
    MOST = 7

cdef enum:
    PLANE
    SPHERE
    CYLINDER
    CONE
    TORUS

cdef enum:
    LEAST_SQUARES
    GEMAN_MCCLURE
    TUKEY

cdef int DOF[5]
DOF[:] = [3, 4, 5, 6, 7]

cdef double TINY = 1e-300
"""Added where a distance is divided by, so that points on an axis give 0 instead of NaN."""
cdef double CUTOFF = 6.0
"""Scales beyond which Tukey's biweight sees nothing."""
cdef double SMALLEST_ANGLE = 1e-9
"""Half-angles are kept this far [rad] from 0 and from 90 degrees, where the apex or the nappe is lost."""
cdef double SMALLEST_STEP = 1e-15
"""Steps below this length, in a frame of extent near 1, change nothing any more."""
cdef double LARGEST_DAMPING = 1e8


cdef struct Surface:
    int kind
    double axis[3]
    double anchor[3]
    double angle
    double major
    double offset


cdef inline double dot(const double *a, const double *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef inline void basis(const double *axis, double *u, double *v) noexcept nogil:
    """As `fitting.geometry.basis`."""
    cdef double x = axis[0], y = axis[1], z = axis[2]
    cdef double sign = 1.0 if z >= 0.0 else -1.0
    cdef double a = -1.0 / (sign + z)
    cdef double b = x * y * a
    u[0] = 1.0 + sign * x * x * a
    u[1] = sign * b
    u[2] = -sign * x
    v[0] = b
    v[1] = sign + y * y * a
    v[2] = -y


cdef void load(Surface *surface, int kind, const double *row) noexcept nogil:
    surface.kind = kind
    memcpy(surface.axis, row, 3 * sizeof(double))
    memcpy(surface.anchor, row + 3, 3 * sizeof(double))
    surface.angle, surface.major, surface.offset = row[6], row[7], row[8]


cdef void store(const Surface *surface, double *row) noexcept nogil:
    memcpy(row, surface.axis, 3 * sizeof(double))
    memcpy(row + 3, surface.anchor, 3 * sizeof(double))
    row[6], row[7], row[8] = surface.angle, surface.major, surface.offset


cdef void linearize(
    const Surface *surface, const double *points, Py_ssize_t n, double *distance, double *jacobian
) noexcept nogil:
    """Distances (n,) and, unless that pointer is null, derivatives (dof, n)."""
    cdef double u[3]
    cdef double v[3]
    cdef double a[3]
    cdef double p[3]
    cdef double sine = sin(surface.angle), cosine = cos(surface.angle)
    cdef double apex = -surface.offset / sine if surface.kind == CONE else 0.0
    cdef double x, y, z, h, qx, qy, qz, rho, qu, qv, length, lean, g_rho, g_height, wa, wu, wv
    cdef double *j0 = jacobian
    cdef double *j1 = j0 + n
    cdef double *j2 = j1 + n
    cdef double *j3 = j2 + n
    cdef double *j4 = j3 + n
    cdef double *j5 = j4 + n
    cdef double *j6 = j5 + n
    cdef bint wanted = jacobian != NULL
    cdef Py_ssize_t i
    memcpy(a, surface.axis, 3 * sizeof(double))
    memcpy(p, surface.anchor, 3 * sizeof(double))
    basis(a, u, v)
    for i in range(n):
        x, y, z = points[3 * i] - p[0], points[3 * i + 1] - p[1], points[3 * i + 2] - p[2]
        if surface.kind == PLANE:
            distance[i] = x * a[0] + y * a[1] + z * a[2]
            if wanted:
                j0[i], j1[i], j2[i] = dot(points + 3 * i, u), dot(points + 3 * i, v), -1.0
            continue
        if surface.kind == SPHERE:
            length = sqrt(x * x + y * y + z * z)
            distance[i] = length - surface.offset
            if wanted:
                length += TINY
                j0[i], j1[i], j2[i], j3[i] = -x / length, -y / length, -z / length, -1.0
            continue
        h = x * a[0] + y * a[1] + z * a[2]
        qx, qy, qz = x - h * a[0], y - h * a[1], z - h * a[2]
        rho = sqrt(qx * qx + qy * qy + qz * qz)
        qu = (qx * u[0] + qy * u[1] + qz * u[2]) / (rho + TINY) if wanted else 0.0
        qv = (qx * v[0] + qy * v[1] + qz * v[2]) / (rho + TINY) if wanted else 0.0
        if surface.kind == CYLINDER:
            distance[i] = rho - surface.offset
            if wanted:
                j0[i], j1[i], j2[i], j3[i], j4[i] = -h * qu, -h * qv, -qu, -qv, -1.0
        elif surface.kind == TORUS:
            length = sqrt((rho - surface.major) * (rho - surface.major) + h * h)
            distance[i] = length - surface.offset
            if wanted:
                g_rho = (rho - surface.major) / (length + TINY)
                g_height = h / (length + TINY)
                lean = g_height * rho - h * g_rho
                j0[i], j1[i], j2[i], j3[i] = qu * lean, qv * lean, -qu * g_rho, -qv * g_rho
                j4[i], j5[i], j6[i] = -g_height, -g_rho, -1.0
        elif (h - apex) * cosine + rho * sine >= 0.0:
            distance[i] = rho * cosine - h * sine - surface.offset
            if wanted:
                lean = -h * cosine - rho * sine
                j0[i], j1[i], j2[i], j3[i] = qu * lean, qv * lean, -qu * cosine, -qv * cosine
                j4[i], j5[i] = -rho * sine - h * cosine, -1.0
        else:
            length = sqrt(rho * rho + (h - apex) * (h - apex))
            distance[i] = length
            if wanted:
                wa = -(h - apex) / (length + TINY)
                wu, wv = -qu * rho / (length + TINY), -qv * rho / (length + TINY)
                j0[i], j1[i], j2[i], j3[i] = apex * wu, apex * wv, wu, wv
                j4[i], j5[i] = -wa * apex * cosine / sine, -wa / sine


cdef void take_step(Surface *surface, const double *step) noexcept nogil:
    """Move by a step in minimal coordinates and bring the row back to its normal form."""
    cdef double u[3]
    cdef double v[3]
    cdef double *a = surface.axis
    cdef double *p = surface.anchor
    cdef double angle, height, length
    cdef int k
    if surface.kind == SPHERE:
        for k in range(3):
            p[k] += step[k]
        surface.offset = fabs(surface.offset + step[3])
        return
    basis(a, u, v)
    if surface.kind == PLANE:
        height = dot(a, p) + step[2]
        for k in range(3):
            p[k] = height * a[k]
    else:
        for k in range(3):
            p[k] += step[2] * u[k] + step[3] * v[k]
    if surface.kind == TORUS:
        for k in range(3):
            p[k] += step[4] * a[k]
    angle = hypot(step[0], step[1])
    if angle > 0.0:
        for k in range(3):
            a[k] = cos(angle) * a[k] + sin(angle) / angle * (step[0] * u[k] + step[1] * v[k])
        length = sqrt(dot(a, a))
        for k in range(3):
            a[k] /= length
    if surface.kind == CYLINDER:
        surface.offset = fabs(surface.offset + step[4])
    elif surface.kind == CONE:
        surface.angle += step[4]
        surface.offset += step[5]
        if surface.angle < 0.0:
            surface.angle = -surface.angle
            for k in range(3):
                a[k] = -a[k]
        surface.angle = min(max(surface.angle, SMALLEST_ANGLE), M_PI / 2 - SMALLEST_ANGLE)
    elif surface.kind == TORUS:
        surface.major = fabs(surface.major + step[5])
        surface.offset = fabs(surface.offset + step[6])
    if surface.kind == CYLINDER or surface.kind == CONE:
        height = dot(a, p)
        for k in range(3):
            p[k] -= height * a[k]
        if surface.kind == CONE:
            surface.offset -= height * sin(surface.angle)


cdef inline double rho(int kernel, double squared) noexcept nogil:
    """What a residual of this square costs; see `fitting.kernels`."""
    cdef double inside
    if kernel == GEMAN_MCCLURE:
        return 0.5 * squared / (1.0 + squared)
    if kernel == TUKEY:
        inside = max(1.0 - squared / (CUTOFF * CUTOFF), 0.0)
        return CUTOFF * CUTOFF / 6.0 * (1.0 - inside * inside * inside)
    return 0.5 * squared


cdef inline double weight_of(int kernel, double squared) noexcept nogil:
    """rho'(x) / x."""
    cdef double inside
    if kernel == GEMAN_MCCLURE:
        return 1.0 / ((1.0 + squared) * (1.0 + squared))
    if kernel == TUKEY:
        inside = max(1.0 - squared / (CUTOFF * CUTOFF), 0.0)
        return inside * inside
    return 1.0


cdef double cost_of(int kernel, double scale, const double *distance, Py_ssize_t n) noexcept nogil:
    """Sum of rho(d / scale)."""
    cdef double total = 0.0
    cdef Py_ssize_t i
    for i in range(n):
        total += rho(kernel, (distance[i] / scale) * (distance[i] / scale))
    return total


cdef void normal_equations(
    int kernel, double scale, const double *distance, const double *jacobian, Py_ssize_t n, int dof,
    double *scratch, double *normal, double *gradient
) noexcept nogil:
    """J^T W J (lower triangle) and J^T W d; the scratch is (2, n)."""
    cdef double *weight = scratch
    cdef double *weighted = scratch + n
    cdef Py_ssize_t i
    cdef int j, k
    for i in range(n):
        weight[i] = weight_of(kernel, (distance[i] / scale) * (distance[i] / scale))
    for j in range(dof):
        for i in range(n):
            weighted[i] = weight[i] * jacobian[j * n + i]
        gradient[j] = inner(weighted, distance, n)
        for k in range(j + 1):
            normal[j * MOST + k] = inner(weighted, jacobian + k * n, n)


cdef bint solve(
    const double *normal, const double *gradient, const double *scales, double damping, int dof, double *step
) noexcept nogil:
    """Solve (N + damping D) step = -gradient by Cholesky on the unit diagonal; whether that went well."""
    cdef double lower[MOST * MOST]
    cdef double total
    cdef int i, j, k
    for i in range(dof):
        for j in range(i + 1):
            total = normal[i * MOST + j] / (scales[i] * scales[j])
            if i == j:
                total += damping
            for k in range(j):
                total -= lower[i * MOST + k] * lower[j * MOST + k]
            if i == j:
                if not total > 0.0:
                    return False
                lower[i * MOST + i] = sqrt(total)
            else:
                lower[i * MOST + j] = total / lower[j * MOST + j]
    for i in range(dof):
        total = -gradient[i] / scales[i]
        for k in range(i):
            total -= lower[i * MOST + k] * step[k]
        step[i] = total / lower[i * MOST + i]
    for i in range(dof - 1, -1, -1):
        total = step[i]
        for k in range(i + 1, dof):
            total -= lower[k * MOST + i] * step[k]
        step[i] = total / lower[i * MOST + i]
    for i in range(dof):
        step[i] /= scales[i]
        if not isfinite(step[i]):
            return False
    return True


cdef bint descend(
    Surface *surface, const double *points, Py_ssize_t n, int kernel, double scale,
    int max_iterations, double *distance, double *jacobian, double *cost
) noexcept nogil:
    """Levenberg-Marquardt; whether it came to rest. The last distances stay in `distance` (n,).

    `jacobian` is room for (dof + 2, n).
    """
    cdef int dof = DOF[surface.kind]
    cdef double normal[MOST * MOST]
    cdef double gradient[MOST]
    cdef double scales[MOST]
    cdef double step[MOST]
    cdef double damping = 1e-12, largest, new_cost, gain
    cdef Surface candidate
    cdef int iteration, j
    linearize(surface, points, n, distance, jacobian)
    cost[0] = cost_of(kernel, scale, distance, n)
    for iteration in range(max_iterations):
        normal_equations(kernel, scale, distance, jacobian, n, dof, jacobian + dof * n, normal, gradient)
        largest = 1e-300
        for j in range(dof):
            if not isfinite(normal[j * MOST + j]) or not isfinite(gradient[j]):
                return False
            largest = max(largest, normal[j * MOST + j])
        for j in range(dof):
            scales[j] = sqrt(normal[j * MOST + j] + 1e-14 * largest)
        while True:
            if solve(normal, gradient, scales, damping, dof, step):
                largest = 0.0
                for j in range(dof):
                    largest = max(largest, fabs(step[j]))
                if largest <= SMALLEST_STEP:
                    return True
                candidate = surface[0]
                take_step(&candidate, step)
                linearize(&candidate, points, n, distance, NULL)
                new_cost = cost_of(kernel, scale, distance, n)
                if new_cost < cost[0]:
                    break
            damping = max(damping * 8.0, 1e-6)
            if damping > LARGEST_DAMPING:
                linearize(surface, points, n, distance, jacobian)
                return True
        gain = cost[0] - new_cost
        surface[0] = candidate
        cost[0] = new_cost
        if gain <= 1e-15 * new_cost:
            return True
        damping = max(damping * 0.1, 1e-12)
        if iteration + 1 < max_iterations:
            linearize(surface, points, n, distance, jacobian)
    return False


cdef double selected(double *values, Py_ssize_t n, Py_ssize_t rank) noexcept nogil:
    """The value of this rank, by Hoare's selection; reorders the values so that those before it are no larger."""
    cdef Py_ssize_t low = 0, high = n - 1, i, j
    cdef double pivot, swap
    while low < high:
        pivot = values[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while values[j] > pivot:
                j -= 1
            if i <= j:
                swap = values[i]
                values[i] = values[j]
                values[j] = swap
                i += 1
                j -= 1
        if rank <= j:
            high = j
        elif rank >= i:
            low = i
        else:
            break
    return values[rank]


cdef double median(double *values, Py_ssize_t n) noexcept nogil:
    """As `numpy.median`; reorders the values. NaN must not be among them."""
    cdef double upper = selected(values, n, n // 2), lower
    cdef Py_ssize_t i
    if n % 2:
        return upper
    lower = values[0]
    for i in range(1, n // 2):
        lower = max(lower, values[i])
    return 0.5 * (lower + upper)


cdef double trimmed(const double *absolute, Py_ssize_t n, double *scratch, double trim, double deviation) noexcept nogil:
    """As `fitting.noise.trimmed_scale`."""
    cdef double scale, total, new_scale
    cdef Py_ssize_t i, count
    cdef int turn
    memcpy(scratch, absolute, n * sizeof(double))
    scale = 1.4826 * median(scratch, n)
    for turn in range(20):
        total, count = 0.0, 0
        for i in range(n):
            if absolute[i] <= trim * scale:
                total += absolute[i] * absolute[i]
                count += 1
        if count == 0 or scale == 0.0:
            return scale
        new_scale = sqrt(total / count) / deviation
        if fabs(new_scale - scale) <= 1e-3 * scale:
            return new_scale
        scale = new_scale
    return scale


cdef bint absolutes(const double *distance, Py_ssize_t n, double *absolute) noexcept nogil:
    """Absolute values; whether all are finite."""
    cdef Py_ssize_t i
    cdef bint finite = True
    for i in range(n):
        absolute[i] = fabs(distance[i])
        if not isfinite(absolute[i]):
            finite = False
    return finite


def costs(int kernel, const double[::1] squared):
    """Costs rho and weights (N,) of squared residuals (N,) in units of the scale."""
    cdef Py_ssize_t i
    cost, weight = np.empty(squared.shape[0]), np.empty(squared.shape[0])
    cdef double[::1] cost_view = cost, weight_view = weight
    for i in range(squared.shape[0]):
        cost_view[i] = rho(kernel, squared[i])
        weight_view[i] = weight_of(kernel, squared[i])
    return cost, weight


def distances(int kind, const double[:, ::1] rows, const double[:, ::1] points):
    """Signed distances (K, N) of points (N, 3) from surfaces (K, 9) of one kind."""
    cdef Py_ssize_t k, n = points.shape[0]
    cdef Surface surface
    result = np.empty((rows.shape[0], n))
    cdef double[:, ::1] view = result
    if n:
        with nogil:
            for k in range(rows.shape[0]):
                load(&surface, kind, &rows[k, 0])
                linearize(&surface, &points[0, 0], n, &view[k, 0], NULL)
    return result


def derivatives(int kind, const double[::1] row, const double[:, ::1] points):
    """Signed distances (N,) of points (N, 3) from a surface (9,), and their derivatives (N, dof) by a step."""
    cdef Py_ssize_t n = points.shape[0]
    cdef Surface surface
    distance, jacobian = np.empty(n), np.empty((DOF[kind], n))
    cdef double[::1] distance_view = distance
    cdef double[:, ::1] jacobian_view = jacobian
    if n:
        load(&surface, kind, &row[0])
        linearize(&surface, &points[0, 0], n, &distance_view[0], &jacobian_view[0, 0])
    return distance, jacobian.T


def stepped(int kind, const double[::1] row, const double[::1] step):
    """The row (9,) after a step (dof,)."""
    cdef Surface surface
    result = np.empty(9)
    cdef double[::1] view = result
    if step.shape[0] != DOF[kind]:
        raise ValueError(f"a step of {DOF[kind]} components is needed, not {step.shape[0]}")
    load(&surface, kind, &row[0])
    take_step(&surface, &step[0])
    store(&surface, &view[0])
    return result


def refine(
    int kind, const double[::1] row, const double[:, ::1] points, int kernel, double scale,
    int max_iterations
):
    """The row (9,) that minimises  sum rho(d / scale)  near the given one, the cost, and whether it is at rest."""
    cdef Py_ssize_t n = points.shape[0]
    cdef Surface surface
    cdef double cost = 0.0
    cdef bint rest
    result = np.empty(9)
    cdef double[::1] view = result
    cdef double *buffer = <double *> malloc((n + 1) * (3 + MOST) * sizeof(double))
    if buffer == NULL:
        raise MemoryError
    load(&surface, kind, &row[0])
    with nogil:
        rest = descend(
            &surface, &points[0, 0], n, kernel, scale, max_iterations, buffer, buffer + n, &cost
        )
    free(buffer)
    store(&surface, &view[0])
    return result, cost, bool(rest)


def settle(
    int kind, const double[:, ::1] rows, const double[:, ::1] points, double smallest, double widths,
    int rounds, int iterations
):
    """Rows (K, 9) after some rounds of steps under Geman-McClure kernels, and their last distances (K, N).

    The kernel of a round is `widths` times the median distance wide, at least `smallest`. Rows whose distances
    are not finite stay as they are.
    """
    cdef Py_ssize_t k, n = points.shape[0]
    cdef Surface surface
    cdef double cost = 0.0, scale
    cdef int turn
    result, last = np.array(rows), np.empty((rows.shape[0], n))
    cdef double[:, ::1] view = result
    cdef double[:, ::1] last_view = last
    cdef double *buffer = <double *> malloc((n + 1) * (3 + MOST) * sizeof(double))
    if buffer == NULL:
        raise MemoryError
    with nogil:
        for k in range(rows.shape[0]):
            load(&surface, kind, &rows[k, 0])
            for turn in range(rounds):
                linearize(&surface, &points[0, 0], n, &last_view[k, 0], NULL)
                if not absolutes(&last_view[k, 0], n, buffer):
                    break
                scale = max(widths * median(buffer, n), smallest)
                descend(
                    &surface, &points[0, 0], n, GEMAN_MCCLURE, scale, iterations, &last_view[k, 0], buffer,
                    &cost
                )
            store(&surface, &view[k, 0])
            linearize(&surface, &points[0, 0], n, &last_view[k, 0], NULL)
    free(buffer)
    return result, last


def anneal(
    int kind, const double[::1] row, const double[:, ::1] points, double tolerance, double shrink, double locked,
    double at_noise, Py_ssize_t need, double trim, double deviation
):
    """Steps under a Geman-McClure kernel that shrinks; see `fitting.search.anneal` for the parameters.

    Returns the last row (9,), and the row at the scale of the noise, or None where that was not reached.
    """
    cdef Py_ssize_t i, count, n = points.shape[0]
    cdef Surface surface, noisy
    cdef double cost = 0.0, scale
    cdef bint reached = False
    cdef double *buffer = <double *> malloc((n + 1) * (5 + MOST) * sizeof(double))
    if buffer == NULL:
        raise MemoryError
    cdef double *distance = buffer
    cdef double *absolute = buffer + n
    cdef double *scratch = buffer + 2 * n
    cdef double *jacobian = buffer + 3 * n
    load(&surface, kind, &row[0])
    with nogil:
        linearize(&surface, &points[0, 0], n, distance, NULL)
        if absolutes(distance, n, absolute):
            scale = max(2.0 * median(absolute, n), tolerance)
            while True:
                descend(
                    &surface, &points[0, 0], n, GEMAN_MCCLURE, scale, 2, distance, jacobian, &cost
                )
                linearize(&surface, &points[0, 0], n, distance, NULL)
                if not absolutes(distance, n, absolute):
                    break
                if not reached and scale < at_noise * trimmed(absolute, n, scratch, trim, deviation):
                    noisy, reached = surface, True
                count = 0
                for i in range(n):
                    if absolute[i] < scale:
                        scratch[count] = absolute[i]
                        count += 1
                if count < need or scale <= tolerance:
                    break
                scale = max(tolerance, min(shrink * scale, locked * median(scratch, count)))
    free(buffer)
    result, at_scale = np.empty(9), np.empty(9)
    cdef double[::1] view = result
    store(&surface, &view[0])
    if not reached:
        return result, None
    view = at_scale
    store(&noisy, &view[0])
    return result, at_scale
