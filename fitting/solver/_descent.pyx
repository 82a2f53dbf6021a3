# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The inner loops of the search, compiled: distances, their derivatives, Levenberg-Marquardt, annealing.

A surface is a row of nine numbers, in a frame whose origin is near the points:

========  =============  ==========================  ============  ==============  ==============
kind      row[0:3]       row[3:6]                    row[6]        row[7]          row[8]
========  =============  ==========================  ============  ==============  ==============
plane     unit normal n  point p
sphere    any            centre c                                                  radius r
cylinder  unit axis a    foot f of the origin on it                                radius r
cone      unit axis a    foot f of the origin on it  half-angle t                  offset s
torus     unit axis a    centre c                                  major radius R  minor radius r
========  =============  ==========================  ============  ==============  ==============

Signed distances, with h the height along the axis, from f or c, q the vector from the axis to x, and rho = |q|:
n . (x - p);  |x - c| - r;  rho - r;  rho cos t - h sin t - s, or the distance from the apex where that is the
closest point;  hypot(rho - R, h) - r.

A step has as many components as the kind has degrees of freedom. Where there is an axis or a normal, the first
two tilt it [rad] towards u and v of its basis: an axis about f or c, a plane about the foot of the origin. Then
come shifts along u and v (the sphere: along x, y, z; the torus: along the axis, too; the plane: along the normal
only), then the numbers of the row from row[6] on. Derivatives:

plane     u.x, v.x, -1
sphere    -(x - c) / |x - c|, -1
cylinder  a tilt da changes q by -h da - (x . da) a with q orthogonal to a, so drho = -h (q . da) / rho;
          a shift df gives drho = -(q . df) / rho; -1
cone      tilt -h (q . da) / rho cos t - (q . da) sin t; shift -(q . df) / rho cos t; dt: -rho sin t - h cos t;
          ds: -1. Behind the apex dd = -w . dc with w the unit vector from the apex c = f + H a, H = -s / sin t
torus     with g = (rho - R, h) / hypot(rho - R, h): tilt drho = -h (q . da) / rho, dh = q . da; shift across
          drho = -(q . df) / rho; along dh = -1; dR: -g0; dr: -1
"""

from libc.math cimport INFINITY, M_PI, atan2, cos, fabs, hypot, isfinite, log, sin, sqrt, tan
from libc.stddef cimport ptrdiff_t
from libc.stdlib cimport free, malloc
from libc.string cimport memcpy

import numpy as np

cdef extern from "_surfaces.h" nogil:
    enum:
        PLANE
        SPHERE
        CYLINDER
        CONE
        TORUS
    enum:
        GEMAN_MCCLURE
    double TINY
    const int DOF[5]
    ctypedef struct Surface:
        int kind
        double axis[3]
        double anchor[3]
        double angle
        double major
        double offset
    ctypedef struct Points:
        const double *x
        const double *y
        const double *z
        ptrdiff_t n
        const double *factor
    void basis(const double *axis, double *u, double *v)
    void linearize(const Surface *surface, Points points, double *distance, double *jacobian)
    double rho_of(int kernel, double squared)
    double weight_of(int kernel, double squared)
    double cost_of(int kernel, double scale, const double *distance, ptrdiff_t n)
    void normal_equations(
        int kernel, double scale, const double *distance, const double *jacobian, ptrdiff_t n, int dof,
        double *scratch, double *normal, int width, double *gradient
    )

cdef extern from "_factors.h" nogil:
    bint eliminate(double *rows, ptrdiff_t n, ptrdiff_t width)
    void substitute(double *rows, ptrdiff_t n, ptrdiff_t width)

cdef enum:
    MOST = 7

cdef struct Limits:
    bint frozen[MOST]
    double low[3]
    double high[3]
    double reference[3]
    double most_tilt

cdef int[5][3] NUMBERS
NUMBERS[0][:] = [-1, -1, -1]
NUMBERS[1][:] = [-1, -1, 3]
NUMBERS[2][:] = [-1, -1, 4]
NUMBERS[3][:] = [4, -1, 5]
NUMBERS[4][:] = [-1, 5, 6]

cdef double SMALLEST_ANGLE = 1e-9
"""Half-angles are kept this far [rad] from 0 and from 90 degrees, where the apex or the nappe is lost."""
cdef double SMALLEST_STEP = 1e-15
"""Steps below this length, in a frame of extent near 1, change nothing any more."""
cdef double UNSEEN = 1e-13
cdef int LAST_STEPS = 3
"""Relative gains below this drown in the rounding of the cost: such steps are trusted, and so many of them in a row
are the last ones. They bring the digits that the cost does not show."""
cdef int CORE_ROUNDS = 30
cdef double NEARLY_AT_REST = 1e-3
"""Rounds of estimating a scale at most, and the relative change that ends them in annealing."""
cdef double LARGEST_DAMPING = 1e8
cdef ptrdiff_t BLOCK = 256
"""Points whose derivatives are summed before the next ones are taken: those of a torus are 14 kB."""
cdef double NEAR = 1e-6
"""An axis this close, relatively, to the cone that bounds it counts as being on it."""


cdef inline double dot(const double *a, const double *b) noexcept nogil:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


cdef void load(Surface *surface, int kind, const double *row) noexcept nogil:
    surface.kind = kind
    memcpy(surface.axis, row, 3 * sizeof(double))
    memcpy(surface.anchor, row + 3, 3 * sizeof(double))
    surface.angle, surface.major, surface.offset = row[6], row[7], row[8]


cdef void store(const Surface *surface, double *row) noexcept nogil:
    memcpy(row, surface.axis, 3 * sizeof(double))
    memcpy(row + 3, surface.anchor, 3 * sizeof(double))
    row[6], row[7], row[8] = surface.angle, surface.major, surface.offset


cdef Points columns(const double[:, ::1] points, double *room) noexcept nogil:
    """The points (N, 3) as three arrays in a room of 3 N numbers."""
    cdef Py_ssize_t i, n = points.shape[0]
    cdef Points result
    for i in range(n):
        room[i], room[n + i], room[2 * n + i] = points[i, 0], points[i, 1], points[i, 2]
    result.x, result.y, result.z, result.n, result.factor = room, room + n, room + 2 * n, n, NULL
    return result


cdef inline void refoot(Surface *surface) noexcept nogil:
    """Let the anchor of a cylinder or cone be the foot of the origin again."""
    cdef double *a = surface.axis
    cdef double *p = surface.anchor
    cdef double height
    cdef int k
    if surface.kind == CYLINDER or surface.kind == CONE:
        height = dot(a, p)
        for k in range(3):
            p[k] -= height * a[k]
        if surface.kind == CONE:
            surface.offset -= height * sin(surface.angle)


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
    refoot(surface)


cdef bint solve(
    const double *normal, const double *gradient, const double *scales, double damping, int dof, double *step
) noexcept nogil:
    """Solve (N + damping S^2) step = -gradient by Cholesky in units of the scales S; whether that went well."""
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


cdef void level(int kind, double *values) noexcept nogil:
    """Average over components that a turn of the frame mixes: then the path does not depend on the frame."""
    cdef double middle
    if kind == SPHERE:
        middle = (values[0] + values[1] + values[2]) / 3.0
        values[0], values[1], values[2] = middle, middle, middle
        return
    middle = 0.5 * (values[0] + values[1])
    values[0], values[1] = middle, middle
    if kind != PLANE:
        middle = 0.5 * (values[2] + values[3])
        values[2], values[3] = middle, middle


cdef const Limits *limits_of(const double[::1] numbers, Limits *limits):
    """The limits that seventeen numbers hold (see `fitting.solver.limits.Limits.numbers`), or null for None."""
    cdef int k
    if numbers is None:
        return NULL
    for k in range(MOST):
        limits.frozen[k] = numbers[k] != 0.0
    for k in range(3):
        limits.low[k], limits.high[k], limits.reference[k] = numbers[7 + k], numbers[10 + k], numbers[13 + k]
    limits.most_tilt = numbers[16]
    return limits


cdef void keep_within(Surface *surface, const Limits *limits) noexcept nogil:
    """Undo what rounding, and the bend of the circle that bounds the axis, have carried over the limits.

    The axis goes back straight towards the reference, to the cone of the largest angle about it.
    """
    cdef double tangent[3]
    cdef double *a = surface.axis
    cdef const double *r = &limits.reference[0]
    cdef double along, across, length
    cdef int k
    surface.angle = min(max(surface.angle, limits.low[0]), limits.high[0])
    surface.major = min(max(surface.major, limits.low[1]), limits.high[1])
    surface.offset = min(max(surface.offset, limits.low[2]), limits.high[2])
    if limits.most_tilt == INFINITY:
        return
    along = dot(a, r)
    for k in range(3):
        tangent[k] = a[k] - along * r[k]
    across = sqrt(dot(tangent, tangent))
    if atan2(across, fabs(along)) <= limits.most_tilt:
        return
    length = cos(limits.most_tilt) if along >= 0.0 else -cos(limits.most_tilt)
    for k in range(3):
        a[k] = length * r[k] + sin(limits.most_tilt) / across * tangent[k]
    length = sqrt(dot(a, a))
    for k in range(3):
        a[k] /= length
    refoot(surface)


cdef bint solve_pinned(
    const double *normal, const double *gradient, const double *scales, double damping, int dof,
    const bint *pinned, double *step
) noexcept nogil:
    """As `solve`, for the components that are not pinned; the pinned ones are what `step` holds."""
    cdef double rest[MOST * MOST]
    cdef double right[MOST]
    cdef double units[MOST]
    cdef double found[MOST]
    cdef int free_ones[MOST]
    cdef int i, j, k, count = 0
    for i in range(dof):
        if not pinned[i]:
            free_ones[count] = i
            count += 1
    for i in range(count):
        k = free_ones[i]
        right[i], units[i] = gradient[k], scales[k]
        for j in range(dof):
            if pinned[j]:
                right[i] += normal[max(k, j) * MOST + min(k, j)] * step[j]
        for j in range(i + 1):
            rest[i * MOST + j] = normal[k * MOST + free_ones[j]]
    if not solve(rest, right, units, damping, count, found):
        return False
    for i in range(count):
        step[free_ones[i]] = found[i]
    return True


cdef bint solve_boxed(
    const double *normal, const double *gradient, const double *scales, double damping, int dof,
    const bint *frozen, int bounded, const int *where, const double *low, const double *high, double *step
) noexcept nogil:
    """The step of `solve` with frozen components 0 and the bounded ones, at most three, in their ranges.

    Where the free step leaves the ranges, every combination of active bounds is tried (they are few), and
    the feasible step with the least damped quadratic model is the answer of this quadratic programme.
    """
    cdef double trial[MOST]
    cdef bint pinned[MOST]
    cdef double model, best = INFINITY
    cdef int state, states = 1, code, i, j, k
    cdef bint feasible
    for i in range(bounded):
        states *= 3
    for state in range(states):
        for i in range(dof):
            pinned[i], trial[i] = frozen[i], 0.0
        code, feasible = state, True
        for i in range(bounded):
            if code % 3:
                pinned[where[i]] = True
                trial[where[i]] = low[i] if code % 3 == 1 else high[i]
                feasible = feasible and isfinite(trial[where[i]])
            code //= 3
        if not feasible:
            continue
        if not solve_pinned(normal, gradient, scales, damping, dof, pinned, trial):
            return False
        for i in range(bounded):
            k = where[i]
            feasible = feasible and (pinned[k] or low[i] <= trial[k] <= high[i])
        if not feasible:
            continue
        model = 0.0
        for i in range(dof):
            model += trial[i] * (gradient[i] + 0.5 * damping * scales[i] * scales[i] * trial[i])
            for j in range(dof):
                model += 0.5 * trial[i] * normal[max(i, j) * MOST + min(i, j)] * trial[j]
        if model < best:
            best = model
            memcpy(step, trial, dof * sizeof(double))
        if state == 0:
            return True
    return best < INFINITY


cdef void turn_tilts(double *normal, double *gradient, int dof, double c, double s) noexcept nogil:
    """Let the first tilt be the one towards c u + s v, the second the one a quarter turn on."""
    cdef double first = normal[0], mixed = normal[MOST], second = normal[MOST + 1]
    cdef int i
    normal[0] = c * c * first + 2.0 * c * s * mixed + s * s * second
    normal[MOST] = c * s * (second - first) + (c * c - s * s) * mixed
    normal[MOST + 1] = s * s * first - 2.0 * c * s * mixed + c * c * second
    for i in range(2, dof):
        first, second = normal[i * MOST], normal[i * MOST + 1]
        normal[i * MOST], normal[i * MOST + 1] = c * first + s * second, c * second - s * first
    first, second = gradient[0], gradient[1]
    gradient[0], gradient[1] = c * first + s * second, c * second - s * first


cdef bint solve_within(
    const Surface *surface, const Limits *limits, const double *normal, const double *gradient,
    const double *scales, double damping, int dof, double *step
) noexcept nogil:
    """The step of `solve` within the limits; how it goes about the axis:

    An axis on the cone of the largest angle about the reference may not tilt outwards; one inside it, that
    would leave the cone, may come as far as the tangent where it would leave. Tilting across by t leaves the
    cone, too, by t^2 / 2 cot(angle), which `keep_within` takes back at a cost of as much times the outward pull:
    without that curvature steps along the cone would be far too long where the cone is narrow.
    """
    cdef double turned[MOST * MOST]
    cdef double pull[MOST]
    cdef double u[3]
    cdef double v[3]
    cdef double away[3]
    cdef double low[3]
    cdef double high[3]
    cdef int where[3]
    cdef double along, across, angle, x, y, c, s, length
    cdef int bounded = 0, k
    cdef bint on_cone
    cdef const double *a = &surface.axis[0]
    cdef double values[3]
    values[0], values[1], values[2] = surface.angle, surface.major, surface.offset
    for k in range(3):
        if limits.low[k] > -INFINITY or limits.high[k] < INFINITY:
            where[bounded] = NUMBERS[surface.kind][k]
            low[bounded], high[bounded] = limits.low[k] - values[k], limits.high[k] - values[k]
            bounded += not limits.frozen[where[bounded]]
    if limits.most_tilt == INFINITY:
        return solve_boxed(
            normal, gradient, scales, damping, dof, limits.frozen, bounded, where, low, high, step
        )
    basis(a, u, v)
    along = dot(a, limits.reference)
    for k in range(3):
        away[k] = along * along * a[k] - along * limits.reference[k]
    across = hypot(dot(away, u), dot(away, v))
    angle = atan2(across, along * along)
    x = angle / (across + TINY) * dot(away, u)
    y = angle / (across + TINY) * dot(away, v)
    on_cone = angle >= (1.0 - NEAR) * limits.most_tilt
    c, s = x, y
    if not on_cone:
        if not solve_boxed(
            normal, gradient, scales, damping, dof, limits.frozen, bounded, where, low, high, step
        ):
            return False
        c, s = x + step[0], y + step[1]
        if hypot(c, s) <= limits.most_tilt:
            return True
    length = hypot(c, s)
    c, s = c / length, s / length
    memcpy(turned, normal, sizeof(turned))
    memcpy(pull, gradient, sizeof(pull))
    turn_tilts(turned, pull, dof, c, s)
    if on_cone and pull[0] < 0.0:
        turned[MOST + 1] -= pull[0] / tan(angle)
    where[bounded], low[bounded], high[bounded] = 0, -INFINITY, limits.most_tilt - (c * x + s * y)
    if not solve_boxed(
        turned, pull, scales, damping, dof, limits.frozen, bounded + 1, where, low, high, step
    ):
        return False
    step[0], step[1] = c * step[0] - s * step[1], s * step[0] + c * step[1]
    return True


cdef void assemble(
    const Surface *surface, Points points, int kernel, double scale, double *distance, double *room,
    double *normal, double *gradient
) noexcept nogil:
    """Distances (n,), and the sums of `normal_equations`, by blocks whose derivatives stay in the cache.

    The room is for (2 + dof) numbers of each point of a block.
    """
    cdef int dof = DOF[surface.kind], i, j
    cdef double part[MOST * MOST]
    cdef double pull[MOST]
    cdef ptrdiff_t start = 0, n = points.n
    cdef Points block = points
    for i in range(dof):
        gradient[i] = 0.0
        for j in range(i + 1):
            normal[i * MOST + j] = 0.0
    while start < n:
        block.n = min(BLOCK, n - start)
        block.x, block.y, block.z = points.x + start, points.y + start, points.z + start
        if points.factor != NULL:
            block.factor = points.factor + start
        linearize(surface, block, distance + start, room)
        normal_equations(
            kernel, scale, distance + start, room, block.n, dof, room + dof * block.n, part, MOST, pull
        )
        for i in range(dof):
            gradient[i] += pull[i]
            for j in range(i + 1):
                normal[i * MOST + j] += part[i * MOST + j]
        start += block.n


cdef bint descend(
    Surface *surface, Points points, int kernel, double scale, int max_iterations, double *distance,
    double *room, double *cost, const Limits *limits = NULL
) noexcept nogil:
    """Levenberg-Marquardt, within the limits if there are any; whether it came to rest.

    `distance` (n,) is that of the surface, before and after; the room is as in `assemble`.
    """
    cdef int dof = DOF[surface.kind]
    cdef Py_ssize_t n = points.n
    cdef double normal[MOST * MOST]
    cdef double gradient[MOST]
    cdef double scales[MOST]
    cdef double step[MOST]
    cdef double damping = 1e-12, largest, promised, new_cost, gain
    cdef bint solved = False
    cdef int unseen = 0
    cdef Surface candidate
    cdef int iteration, j
    cost[0] = cost_of(kernel, scale, distance, n)
    for iteration in range(max_iterations):
        assemble(surface, points, kernel, scale, distance, room, normal, gradient)
        largest = 1e-300
        for j in range(dof):
            if not isfinite(normal[j * MOST + j]) or not isfinite(gradient[j]):
                return False
            largest = max(largest, normal[j * MOST + j])
        for j in range(dof):
            scales[j] = normal[j * MOST + j] + 1e-14 * largest
        level(surface.kind, scales)
        for j in range(dof):
            scales[j] = sqrt(scales[j])
        while True:
            if (
                solve(normal, gradient, scales, damping, dof, step) if limits == NULL
                else solve_within(surface, limits, normal, gradient, scales, damping, dof, step)
            ):
                solved = True
                largest = 0.0
                for j in range(dof):
                    largest = max(largest, fabs(step[j]))
                if largest <= SMALLEST_STEP:
                    linearize(surface, points, distance, NULL)
                    return True
                candidate = surface[0]
                take_step(&candidate, step)
                if limits != NULL:
                    keep_within(&candidate, limits)
                linearize(&candidate, points, distance, NULL)
                new_cost = cost_of(kernel, scale, distance, n)
                if new_cost < cost[0]:
                    break
                promised = 0.0
                for j in range(dof):
                    promised -= 0.5 * gradient[j] * step[j] / (scale * scale)
                if promised <= UNSEEN * cost[0] and new_cost <= (1.0 + UNSEEN) * cost[0]:
                    break
            damping = max(damping * 8.0, 1e-6)
            if damping > LARGEST_DAMPING:
                linearize(surface, points, distance, NULL)
                return solved
        gain = cost[0] - new_cost
        surface[0] = candidate
        cost[0] = new_cost
        unseen = unseen + 1 if gain <= UNSEEN * new_cost else 0
        if unseen == LAST_STEPS:
            return True
        damping = max(damping * 0.1, 1e-12)
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


cdef double weighed(const double *absolute, Py_ssize_t n, double scale, double core, double deviation) noexcept nogil:
    """Standard deviation (n,) under the weights (1 - (x / core / scale)^2)^2 over that of a normal variable, or 0."""
    cdef double weight, square, unit = 1.0 / (core * scale * core * scale), total = 0.0, weights = 0.0
    cdef Py_ssize_t i
    for i in range(n):
        square = absolute[i] * absolute[i]
        weight = max(1.0 - unit * square, 0.0)
        weights += weight * weight
        total += weight * weight * square
    return sqrt(total / weights) / deviation if weights > 0.0 else 0.0


cdef double core_of(
    const double *absolute, Py_ssize_t n, double *scratch, double core, double deviation, double rest
) noexcept nogil:
    """As `fitting.noise.scale.core_scale`."""
    memcpy(scratch, absolute, n * sizeof(double))
    return core_from(1.4826 * median(scratch, n), absolute, n, core, deviation, rest)


cdef double core_from(
    double scale, const double *absolute, Py_ssize_t n, double core, double deviation, double rest
) noexcept nogil:
    """The scale that a given one leads to; steps are extrapolated by Aitken's method until they are below `rest`."""
    cdef double first, second, bend, far
    cdef int turn
    for turn in range(CORE_ROUNDS):
        if scale == 0.0:
            return 0.0
        first = weighed(absolute, n, scale, core, deviation)
        if first == 0.0 or fabs(first - scale) <= rest * scale:
            return first
        second = weighed(absolute, n, first, core, deviation)
        if second == 0.0 or fabs(second - first) <= rest * first:
            return second
        bend = second - 2.0 * first + scale
        far = scale - (first - scale) * (first - scale) / bend if bend != 0.0 else second
        scale = far if far > 0.0 and fabs(far - second) <= fabs(second - scale) else second
    return scale


def core_scale(const double[::1] absolute, double core, double deviation, double rest):
    """The scale of absolute values (N,); see `fitting.noise.scale.core_scale`."""
    cdef Py_ssize_t n = absolute.shape[0]
    cdef double scale
    cdef double *room = room_for(n)
    with nogil:
        scale = core_of(&absolute[0], n, room, core, deviation, rest) if n else 0.0
    free(room)
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


cdef double *room_for(Py_ssize_t numbers) except NULL:
    cdef double *room = <double *> malloc((numbers + 1) * sizeof(double))
    if room == NULL:
        raise MemoryError
    return room


def costs(int kernel, const double[::1] squared):
    """Costs rho and weights (N,) of squared residuals (N,) in units of the scale."""
    cdef Py_ssize_t i
    cost, weight = np.empty(squared.shape[0]), np.empty(squared.shape[0])
    cdef double[::1] cost_view = cost
    cdef double[::1] weight_view = weight
    for i in range(squared.shape[0]):
        cost_view[i] = rho_of(kernel, squared[i])
        weight_view[i] = weight_of(kernel, squared[i])
    return cost, weight


def derivatives(int kind, const double[::1] row, const double[:, ::1] points):
    """Signed distances (N,) of points (N, 3) from a surface (9,), and their derivatives (N, dof) by a step."""
    cdef Py_ssize_t n = points.shape[0]
    cdef Surface surface
    distance, jacobian = np.empty(n), np.empty((DOF[kind], n))
    cdef double[::1] distance_view = distance
    cdef double[:, ::1] jacobian_view = jacobian
    cdef double *room = room_for(3 * n)
    if n:
        load(&surface, kind, &row[0])
        linearize(&surface, columns(points, room), &distance_view[0], &jacobian_view[0, 0])
    free(room)
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
    int kind, const double[::1] row, const double[:, ::1] points, int kernel, double scale, int max_iterations,
    const double[::1] factors=None, const double[::1] limits=None
):
    """The row (9,) that minimises  sum rho(d / scale)  near the given one, the cost, and whether it is at rest.

    Distances are multiplied by `factors` (N,), where given; `limits` (17,) are those of `fitting.solver.limits`.
    """
    cdef Py_ssize_t n = points.shape[0]
    cdef Limits room_for_limits
    cdef const Limits *within = limits_of(limits, &room_for_limits)
    cdef Surface surface
    cdef Points seen
    cdef double cost = 0.0
    cdef bint rest
    result = np.empty(9)
    cdef double[::1] view = result
    cdef double *room = room_for(4 * n + (2 + MOST) * BLOCK)
    cdef double *distance = room + 3 * n
    load(&surface, kind, &row[0])
    with nogil:
        seen = columns(points, room)
        if factors is not None:
            seen.factor = &factors[0]
        linearize(&surface, seen, distance, NULL)
        rest = descend(&surface, seen, kernel, scale, max_iterations, distance, distance + n, &cost, within)
    free(room)
    store(&surface, &view[0])
    return result, cost, bool(rest)


def pull(
    int kind, const double[::1] row, const double[:, ::1] points, int kernel, double scale, double core,
    double deviation, double rest, const double[::1] factors=None
):
    """J^T W J (dof, dof), J^T W d (dof,) of the distances d under a kernel, and the scale that theirs leads to.

    The arguments are those of `refine` and of `core_scale`.
    """
    cdef Py_ssize_t n = points.shape[0]
    cdef int dof = DOF[kind], i, j
    cdef Surface surface
    cdef Points seen
    cdef double found = 0.0
    cdef double[MOST * MOST] sums
    normal, gradient = np.empty((dof, dof)), np.empty(dof)
    cdef double[:, ::1] normal_view = normal
    cdef double[::1] gradient_view = gradient
    cdef double *room = room_for(4 * n + (2 + MOST) * BLOCK)
    cdef double *distance = room + 3 * n
    load(&surface, kind, &row[0])
    with nogil:
        seen = columns(points, room)
        if factors is not None:
            seen.factor = &factors[0]
        assemble(&surface, seen, kernel, scale, distance, distance + n, &sums[0], &gradient_view[0])
        for i in range(dof):
            for j in range(i + 1):
                normal_view[i, j] = normal_view[j, i] = sums[i * MOST + j]
        if absolutes(distance, n, distance):
            found = core_from(scale, distance, n, core, deviation, rest)
    free(room)
    return normal, gradient, found


cdef void step_robustly(
    Surface *surface, Points points, double smallest, double widths, int steps, double *distance,
    double *absolute, double *room, const Limits *limits = NULL
) noexcept nogil:
    """Steps under Geman-McClure kernels `widths` times the median distance wide, at least `smallest`.

    A surface whose distances are not finite stays as it is. `absolute` is room for (n,), `room` as in
    `descend`; `distance` (n,) holds the last distances.
    """
    cdef double cost
    cdef int turn
    linearize(surface, points, distance, NULL)
    for turn in range(steps):
        if not absolutes(distance, points.n, absolute):
            return
        descend(
            surface, points, GEMAN_MCCLURE, max(widths * median(absolute, points.n), smallest), 1, distance,
            room, &cost, limits
        )


def settle(
    int kind, const double[:, ::1] rows, const double[:, ::1] points, double smallest, double widths, int steps,
    const double[::1] limits=None
):
    """Rows (K, 9) after some robust steps, and their last distances (K, N); see `fitting.solver.refine.settle`."""
    cdef Limits room_for_limits
    cdef const Limits *within = limits_of(limits, &room_for_limits)
    cdef Py_ssize_t k, n = points.shape[0]
    cdef Surface surface
    cdef Points seen
    result, last = np.empty((rows.shape[0], 9)), np.empty((rows.shape[0], n))
    cdef double[:, ::1] view = result
    cdef double[:, ::1] last_view = last
    cdef double *room = room_for(4 * n + (2 + MOST) * BLOCK)
    with nogil:
        seen = columns(points, room)
        for k in range(rows.shape[0]):
            load(&surface, kind, &rows[k, 0])
            step_robustly(
                &surface, seen, smallest, widths, steps, &last_view[k, 0], room + 3 * n, room + 4 * n, within
            )
            store(&surface, &view[k, 0])
    free(room)
    return result, last


def compete(
    int kind, const double[:, ::1] rows, const double[:, ::1] points, double smallest, double widths,
    double resolved, const long long[:, ::1] stages
):
    """The best of the rows (K, 9) after some stages, and its distances (N,); see `fitting.solver.refine.compete`."""
    cdef Py_ssize_t k, i, n = points.shape[0], count, left = rows.shape[0], first
    cdef Py_ssize_t most = 5 * n + (2 + MOST) * BLOCK
    cdef double *room = room_for(most + left + left * sizeof(Surface) // sizeof(double))
    cdef double *costs = room + most
    cdef Surface *surfaces = <Surface *> (costs + left)
    cdef double *distance
    cdef double cost
    cdef Surface swap
    cdef Points seen
    cdef int stage
    if left == 0:
        raise ValueError("at least one start is needed")
    result, last = np.empty(9), np.empty(n)
    cdef double[::1] view = result
    cdef double[::1] last_view = last
    with nogil:
        for k in range(left):
            load(&surfaces[k], kind, &rows[k, 0])
        for stage in range(stages.shape[0]):
            count = min(n, stages[stage, 0])
            for i in range(count):
                k = i * (n - 1) // max(count - 1, 1)
                room[i], room[count + i], room[2 * count + i] = points[k, 0], points[k, 1], points[k, 2]
            seen.x, seen.y, seen.z, seen.n, seen.factor = room, room + count, room + 2 * count, count, NULL
            distance = room + 3 * count
            for k in range(left):
                step_robustly(
                    &surfaces[k], seen, smallest, widths, stages[stage, 1], distance, room + 4 * count,
                    room + 5 * count
                )
                costs[k] = 0.0
                for i in range(count):
                    costs[k] += log(fabs(distance[i]) + resolved)
                if not isfinite(costs[k]):
                    costs[k] = INFINITY
            for i in range(min(left, stages[stage, 2])):
                first = i
                for k in range(i + 1, left):
                    if costs[k] < costs[first]:
                        first = k
                swap, cost = surfaces[first], costs[first]
                surfaces[first], costs[first] = surfaces[i], costs[i]
                surfaces[i], costs[i] = swap, cost
            left = min(left, stages[stage, 2])
        store(&surfaces[0], &view[0])
        linearize(&surfaces[0], columns(points, room), &last_view[0], NULL)
    free(room)
    return result, last


def anneal(
    int kind, const double[::1] row, const double[:, ::1] points, double tolerance, double shrink, double locked,
    double at_noise, Py_ssize_t need, double core, double deviation, const double[::1] limits=None
):
    """Steps under a Geman-McClure kernel whose scale shrinks; see `fitting.search.anneal.anneal`.

    `shrink`, `locked` and `at_noise` are constants of `fitting.search.kind`, `core` and `deviation` of
    `fitting.noise.scale`. It ends at the tolerance, or where fewer than `need` points are within the scale. Returned
    are the last row (9,), and the row at the scale of the noise, or None where that was not reached.
    """
    cdef Py_ssize_t i, count, n = points.shape[0]
    cdef Limits room_for_limits
    cdef const Limits *within = limits_of(limits, &room_for_limits)
    cdef Surface surface, noisy
    cdef Points seen
    cdef double cost = 0.0, scale
    cdef bint reached = False
    cdef double *room = room_for(6 * n + (2 + MOST) * BLOCK)
    cdef double *distance = room + 3 * n
    cdef double *absolute = room + 4 * n
    cdef double *scratch = room + 5 * n
    load(&surface, kind, &row[0])
    with nogil:
        seen = columns(points, room)
        linearize(&surface, seen, distance, NULL)
        if absolutes(distance, n, absolute):
            scale = max(2.0 * median(absolute, n), tolerance)
            while True:
                descend(&surface, seen, GEMAN_MCCLURE, scale, 2, distance, room + 6 * n, &cost, within)
                if not absolutes(distance, n, absolute):
                    break
                if not reached and scale < at_noise * core_of(absolute, n, scratch, core, deviation, NEARLY_AT_REST):
                    noisy, reached = surface, True
                count = 0
                for i in range(n):
                    if absolute[i] < scale:
                        scratch[count] = absolute[i]
                        count += 1
                if count < need or scale <= tolerance:
                    break
                scale = max(tolerance, min(shrink * scale, locked * median(scratch, count)))
    free(room)
    result, at_scale = np.empty(9), np.empty(9)
    cdef double[::1] view = result
    store(&surface, &view[0])
    if not reached:
        return result, None
    view = at_scale
    store(&noisy, &view[0])
    return result, at_scale


cdef void solve_overdetermined(
    const double *design, const double *target, Py_ssize_t n, int m, int rounds, double *room, double *solution
) noexcept nogil:
    """Reweighted least squares for  design (n, m) . solution = target (n,);  the room is (3, n).

    Weights are 1 / (1 + (residual / median)^2) after the first round.
    """
    cdef double normal[MOST * MOST]
    cdef double right[MOST]
    cdef double scales[MOST]
    cdef double *weight = room
    cdef double *residual = room + n
    cdef double *scratch = room + 2 * n
    cdef double weighted, trace, ridge, middle
    cdef const double *row
    cdef Py_ssize_t i
    cdef int j, l, turn
    for j in range(m):
        solution[j] = 0.0
    for i in range(n):
        weight[i] = 1.0
    for turn in range(rounds):
        for j in range(m):
            right[j] = 0.0
            for l in range(j + 1):
                normal[j * MOST + l] = 0.0
        for i in range(n):
            row = design + i * m
            for j in range(m):
                weighted = weight[i] * row[j]
                right[j] -= weighted * target[i]
                for l in range(j + 1):
                    normal[j * MOST + l] += weighted * row[l]
        trace = 0.0
        for j in range(m):
            trace += normal[j * MOST + j]
        for j in range(m):
            normal[j * MOST + j] += 1e-13 * trace + TINY
            scales[j] = sqrt(normal[j * MOST + j])
        ridge = 0.0
        while not solve(normal, right, scales, ridge, m, solution) and ridge < 1.0:
            ridge = max(1e3 * ridge, 1e-15)
        if turn + 1 == rounds:
            return
        for i in range(n):
            residual[i] = -target[i]
            row = design + i * m
            for j in range(m):
                residual[i] += row[j] * solution[j]
        if not absolutes(residual, n, scratch):
            return
        middle = median(scratch, n) + 1e-12
        for i in range(n):
            weight[i] = 1.0 / (1.0 + residual[i] / middle * (residual[i] / middle))


def solve_linear(const double[:, :, ::1] design, const double[:, ::1] target, int rounds):
    """Solutions (K, m) of  design (K, N, m) . x = target (K, N);  see `fitting.geometry.axes.robust_linear_solve`."""
    cdef Py_ssize_t k, n = design.shape[1]
    cdef int m = design.shape[2]
    if m > MOST:
        raise ValueError(f"at most {MOST} unknowns, not {m}")
    result = np.empty((design.shape[0], m))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(3 * n)
    with nogil:
        for k in range(design.shape[0]):
            solve_overdetermined(&design[k, 0, 0], &target[k, 0], n, m, rounds, room, &view[k, 0])
    free(room)
    return result


def solve_circles(const double[:, ::1] x, const double[:, ::1] y, int rounds):
    """Solutions (K, 3) of  x^2 + y^2 = a x + b y + c;  see `fitting.geometry.axes.circles`."""
    cdef Py_ssize_t k, i, n = x.shape[1]
    result = np.empty((x.shape[0], 3))
    cdef double[:, ::1] view = result
    cdef double *room = room_for(7 * n)
    cdef double *design = room + 3 * n
    cdef double *target = room + 6 * n
    with nogil:
        for k in range(x.shape[0]):
            for i in range(n):
                design[3 * i], design[3 * i + 1], design[3 * i + 2] = x[k, i], y[k, i], 1.0
                target[i] = x[k, i] * x[k, i] + y[k, i] * y[k, i]
            solve_overdetermined(design, target, n, 3, rounds, room, &view[k, 0])
    free(room)
    return result


cdef void covariance_beside(
    const double *white, const double *bells, const long long *which, const double *sizes, int parts,
    const double *columns, Py_ssize_t n, Py_ssize_t k, double *rows
) noexcept nogil:
    """Rows (n, n + k): the upper triangle of  diag(white) + sum sizes^2 bells[which],  and the columns beside it."""
    cdef Py_ssize_t i, j, width = n + k
    cdef int part
    cdef const double *bell
    cdef double square
    for i in range(n):
        for j in range(i, n):
            rows[i * width + j] = 0.0
        for part in range(parts):
            square = sizes[part] * sizes[part]
            if square > 0.0:
                bell = bells + (which[part] * n + i) * n
                for j in range(i, n):
                    rows[i * width + j] += square * bell[j]
        rows[i * width + i] += white[i]
        memcpy(rows + i * width + n, columns + i * k, k * sizeof(double))


def solve_fields(
    const double[::1] white, const double[:, :, ::1] bells, const long long[:, ::1] which,
    const double[:, ::1] sizes, const double[:, ::1] columns
):
    """Columns (P, K) solved by each covariance  C = diag(white) + sum sizes^2 bells[which]  of fields on P patches.

    A field is a row of `which` (T, parts) of the bells (B, P, P), and one of their sizes; size 0 leaves a part
    out. With Cholesky's factor C = L L^T returned are  L^-1 columns  and  C^-1 columns, (T, P, K),  and the
    logarithm of the determinant of L (T,), which is infinite where a covariance is not positive definite.
    """
    cdef Py_ssize_t t, i, n = columns.shape[0], k = columns.shape[1], fields = which.shape[0], width = n + k
    cdef int parts = which.shape[1]
    halves, solved, root = np.zeros((fields, n, k)), np.zeros((fields, n, k)), np.zeros(fields)
    cdef double[:, :, ::1] half = halves
    cdef double[:, :, ::1] whole = solved
    cdef double[::1] log_root = root
    cdef double *rows = room_for(n * width)
    with nogil:
        for t in range(fields):
            covariance_beside(
                &white[0], &bells[0, 0, 0], &which[t, 0], &sizes[t, 0], parts, &columns[0, 0], n, k, rows
            )
            if not eliminate(rows, n, width):
                log_root[t] = INFINITY
                continue
            for i in range(n):
                log_root[t] += log(rows[i * width + i])
                memcpy(&half[t, i, 0], rows + i * width + n, k * sizeof(double))
            substitute(rows, n, width)
            for i in range(n):
                memcpy(&whole[t, i, 0], rows + i * width + n, k * sizeof(double))
    free(rows)
    return halves, solved, root


cdef void lower_half(double *keys, Py_ssize_t *order, Py_ssize_t n) noexcept nogil:
    """Let the n // 2 smallest keys (n,), and their places, come first; of equal keys those of lower places."""
    cdef Py_ssize_t low = 0, high = n - 1, rank = n // 2, i, j, place
    cdef double pivot, swap
    while low < high:
        pivot, place = keys[(low + high) // 2], order[(low + high) // 2]
        i, j = low, high
        while i <= j:
            while keys[i] < pivot or (keys[i] == pivot and order[i] < place):
                i += 1
            while keys[j] > pivot or (keys[j] == pivot and order[j] > place):
                j -= 1
            if i <= j:
                swap = keys[i]
                keys[i] = keys[j]
                keys[j] = swap
                order[i], order[j] = order[j], order[i]
                i += 1
                j -= 1
        if rank <= j:
            high = j
        elif rank >= i:
            low = i
        else:
            break


cdef void halve(
    const double[:, ::1] points, Py_ssize_t *order, double *keys, Py_ssize_t n, int times, long long number,
    long long[::1] numbers
) noexcept nogil:
    """Number the n points of this order as halves of halves, so many times; keys (n,) is room."""
    cdef double least, most, widest = -1.0
    cdef Py_ssize_t i
    cdef int axis, along = 0
    if times == 0:
        for i in range(n):
            numbers[order[i]] = number
        return
    for axis in range(3):
        least, most = INFINITY, -INFINITY
        for i in range(n):
            least, most = min(least, points[order[i], axis]), max(most, points[order[i], axis])
        if most - least > widest:
            widest, along = most - least, axis
    for i in range(n):
        keys[i] = points[order[i], along]
    lower_half(keys, order, n)
    halve(points, order, keys, n // 2, times - 1, 2 * number, numbers)
    halve(points, order + n // 2, keys, n - n // 2, times - 1, 2 * number + 1, numbers)


def halves(const double[:, ::1] points, int times):
    """Numbers (N,) of the pieces of points (N, 3) that halving so many times leaves; see `fitting.cloud.patches`."""
    cdef Py_ssize_t i, n = points.shape[0]
    numbers = np.empty(n, np.int64)
    cdef long long[::1] view = numbers
    cdef double *keys = room_for(2 * n)
    cdef Py_ssize_t *order = <Py_ssize_t *> (keys + n)
    with nogil:
        for i in range(n):
            order[i] = i
        halve(points, order, keys, n, times, 0, view)
    free(keys)
    return numbers
