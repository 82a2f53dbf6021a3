# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Steps that stay within limits: frozen components, bounds of the numbers of a row, an axis near a direction."""

from libc.math cimport INFINITY, atan2, cos, fabs, hypot, isfinite, sin, sqrt, tan
from libc.string cimport memcpy

cdef double NEAR = 1e-6
"""An axis this close, relatively, to the cone that bounds it counts as being on it."""


cdef class Bounds:
    """The limits on one kind as the steps obey them; see `fitting.trial.limits.Limits`.

    Parameters
    ----------
    frozen : components of a step that are 0
    slots : (3,) the component that adds to each number of a row from row[6] on, or -1
    low, high : (3,) bounds of these numbers
    reference, most_tilt : (3,) unit direction that the axis or normal is within so large an angle [rad] of
    """

    def __init__(self, *, frozen, slots, low, high, reference, double most_tilt):
        cdef int k
        for k in range(MOST):
            self.held.frozen[k] = k < len(frozen) and frozen[k]
        for k in range(3):
            self.held.slots[k] = slots[k]
            self.held.low[k], self.held.high[k], self.held.reference[k] = low[k], high[k], reference[k]
        self.held.most_tilt = most_tilt


cdef const Held *held_by(Bounds bounds) noexcept:
    """Null for None."""
    return NULL if bounds is None else &bounds.held


cdef void keep_within(Surface *surface, const Held *limits) noexcept nogil:
    """Undo what rounding, and the bend of the circle that bounds the axis, have carried over the limits.

    The axis goes back straight towards the reference, to the cone of the largest angle about it.
    """
    cdef double tangent[3]
    cdef double *a = surface.axis
    cdef const double *r = &limits.reference[0]
    cdef double along, across, length
    cdef int k
    for k in range(3):
        surface.numbers[k] = min(max(surface.numbers[k], limits.low[k]), limits.high[k])
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
    normalize(a)
    KINDS[surface.kind].settle(surface)


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
    the feasible step with the least damped quadratic model is the answer of this quadratic program.
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
    const Surface *surface, const Held *limits, const double *normal, const double *gradient,
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
    for k in range(3):
        if limits.low[k] > -INFINITY or limits.high[k] < INFINITY:
            where[bounded] = limits.slots[k]
            low[bounded], high[bounded] = limits.low[k] - surface.numbers[k], limits.high[k] - surface.numbers[k]
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
