# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""How far a number of a surface may go before the points object, the others following: its profile.

On short arcs the interval of a radius is not symmetric: much larger ones fit nearly as well, and much
smaller ones do not. An end is the farthest value of the number among all surfaces whose cost has risen by no
more than is asked; steps lead to the farthest point of the quadratic model of the cost. Each search begins at
the farthest surface that is known already: the region is bent like a banana.
Source: Venzon and Moolgavkar, "A method for computing profile-likelihood-based confidence intervals", Applied
Statistics 37, 1988.
"""

from libc.math cimport INFINITY, asin, fabs, hypot, sqrt
from libc.stdlib cimport free, malloc, realloc

import numpy as np

from ..solver._descent cimport BLOCK, columns, load, store
from ..trial._limits cimport (
    KINDS, MOST, MOST_NUMBERS, Bounds, Held, Points, Surface, basis, dot, linearize, solve
)

cdef extern from "noise/kernels.h" nogil:
    double cost_of(int kernel, double scale, const double *distance, Py_ssize_t n)

cdef extern from "solver/equations.h" nogil:
    void normal_equations(
        int kernel, double scale, const double *distance, const double *jacobian, Py_ssize_t n, int dof,
        double *scratch, double *normal, int width, double *gradient
    )

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef extern from "primitives/cone.h" nogil:
    const double QUARTER_TURN

cdef int ROUNDS = 24
cdef double CLOSE = 0.02
"""An end is found when the rise of the cost is this close to what is asked, relatively, and the next step
moves the number by this share of its linearized half-width at most."""
cdef double GROWTH = 2.0, OVERSHOOT = 0.5
"""A step may change a size by this factor, and the cost may pass what is asked by this share of the rise."""
cdef double SHORTEST = 1e-3
"""Share of a step below which there is none."""
cdef double FLATTEST = 1e-3
"""An end beyond which the curvature is this share of what was found, or an angle that close to its limits, is
not bounded by the points."""


cdef struct Local:
    Surface surface
    double values[MOST_NUMBERS]
    double cost
    double slope[MOST]
    double square[MOST * MOST]
    int free
    double ways[MOST * MOST]
"""A surface, its numbers, the cost there, and a quadratic model about it in its free steps: how many these are,
what directions (free, MOST) of a step, and the slope and the curvature (lower triangle) along them."""


def numbers(int kind, const double[::1] row, const double[::1] center):
    """The numbers (P,) of the surface of a row (9,), and their derivatives (P, dof) by a step.

    They are those of an answer, in its canonical sign; the `point` of a plane or a cylinder is the one closest
    to a center (3,).
    """
    cdef Surface surface
    cdef double[MOST_NUMBERS] found
    cdef double[MOST_NUMBERS * MOST] by_step
    cdef int i, j, count, dof = KINDS[kind].dof
    load(&surface, kind, &row[0])
    count = KINDS[kind].numbers(&surface, &center[0], found, by_step)
    values, slopes = np.empty(count), np.empty((count, dof))
    cdef double[::1] value = values
    cdef double[:, ::1] slope = slopes
    for i in range(count):
        value[i] = found[i]
        for j in range(dof):
            slope[i, j] = by_step[i * dof + j]
    return values, slopes


cdef int free_steps(const Surface *surface, const Held *limits, double touches, double *ways) noexcept nogil:
    """Orthonormal directions (free, MOST) of the steps that no active limit holds, and how many these are.

    As `fitting.trial.limits.Limits.free_steps`.
    """
    cdef int i, k, found = 0, dof = KINDS[surface.kind].dof
    cdef bint[MOST] held
    cdef double[3] u
    cdef double[3] v
    cdef double bound, value, towards_u, towards_v, towards
    for i in range(dof):
        held[i] = limits != NULL and limits.frozen[i]
        for k in range(MOST):
            ways[i * MOST + k] = 0.0
    if limits != NULL:
        for k in range(3):
            value = surface.numbers[k]
            for bound in (limits.low[k], limits.high[k]):
                if limits.slots[k] >= 0 and fabs(value - bound) <= touches * fabs(bound) < INFINITY:
                    held[limits.slots[k]] = True
        if limits.most_tilt < INFINITY:
            basis(surface.axis, u, v)
            towards_u, towards_v = dot(u, limits.reference), dot(v, limits.reference)
            towards = hypot(towards_u, towards_v)
            if asin(min(towards, 1.0)) >= limits.most_tilt - touches:
                held[0] = held[1] = True
                ways[0], ways[1] = -towards_v / towards, towards_u / towards
                found = 1
    for i in range(dof):
        if not held[i]:
            ways[found * MOST + i] = 1.0
            found += 1
    return found


cdef bint farthest(const Local *local, const double *gradient, double rise, double *step) noexcept nogil:
    """The step (dof,) to where a number with this gradient (dof,) is largest at so much more cost.

    False where the model leaves a step open.
    """
    cdef int i, k, dof = KINDS[local.surface.kind].dof
    cdef double[MOST] units
    cdef double[MOST] wanted
    cdef double[MOST] least
    cdef double[MOST] along
    cdef double left = rise, reach = 0.0, stretch
    for i in range(local.free):
        if not local.square[i * MOST + i] > 0.0:
            return False
        units[i] = sqrt(local.square[i * MOST + i])
        wanted[i] = 0.0
        for k in range(dof):
            wanted[i] -= local.ways[i * MOST + k] * gradient[k]
    if not (
        solve(local.square, local.slope, units, 0.0, local.free, least)
        and solve(local.square, wanted, units, 0.0, local.free, along)
    ):
        return False
    for i in range(local.free):
        left -= 0.5 * local.slope[i] * least[i]
        reach -= wanted[i] * along[i]
    if not reach > 0.0:
        return False
    stretch = sqrt(2.0 * max(left, 0.0) / reach)
    for k in range(dof):
        step[k] = 0.0
        for i in range(local.free):
            step[k] += local.ways[i * MOST + k] * (least[i] + stretch * along[i])
    return True


cdef class Region:
    """The surfaces about an optimum, as far as they have been looked at; the first is the optimum.

    Parameters
    ----------
    kind, row : the optimum
    points : (N, 3) that the cost is a sum over, in the frame of the steps
    kernel, scale, factors : of the cost; each distance is multiplied by its factor (N,), where given
    bounds, touches : limits that hold anyhow, where given, and how close to one is on it
    center : (3,) that free points of the numbers are closest to
    sizes, angles : places in a row of radii and half-angles, and which of them are angles
    """

    cdef Points points
    cdef double *room
    cdef Local *seen
    cdef int count, kernel, sizes
    cdef double scale, touches
    cdef Bounds bounds
    cdef const double[::1] factors
    cdef double[3] center
    cdef int[3] places
    cdef bint[3] angles

    def __cinit__(self, int kind, const double[::1] row, const double[:, ::1] points, **_):
        self.room = NULL
        self.seen = NULL
        self.room = room_for(3 * points.shape[0] + (3 + MOST) * BLOCK)
        self.seen = <Local *>malloc(sizeof(Local))
        if self.seen == NULL:
            raise MemoryError

    def __init__(
        self, int kind, const double[::1] row, const double[:, ::1] points, *, int kernel, double scale, factors,
        Bounds bounds, double touches, const double[::1] center, sizes, angles
    ):
        cdef int k
        self.points = columns(points, self.room)
        self.factors, self.bounds = factors, bounds
        if factors is not None:
            self.points.factor = &self.factors[0]
        self.kernel, self.scale, self.touches = kernel, scale, touches
        self.sizes = len(sizes)
        for k in range(self.sizes):
            self.places[k], self.angles[k] = sizes[k] - 6, angles[k]
        for k in range(3):
            self.center[k] = center[k]
        self.count = 1
        load(&self.seen[0].surface, kind, &row[0])
        with nogil:
            self.look(&self.seen[0], INFINITY)

    def __dealloc__(self):
        free(self.room)
        free(self.seen)

    @property
    def rows(self):
        """Rows (K, 9) of the surfaces seen."""
        cdef int k
        found = np.empty((self.count, 9))
        cdef double[:, ::1] row = found
        for k in range(self.count):
            store(&self.seen[k].surface, &row[k, 0])
        return found

    def ends(self, const double[::1] weights, double half, double rise):
        """The numbers (P,) where their sum with these weights (P,) is least, and where it is largest; None
        for an open end.

        `half` is the half-width of the linearized interval of the sum, and `rise` what the cost may rise by.
        """
        return self.end(weights, -1.0, half, rise), self.end(weights, 1.0, half, rise)

    cdef end(self, const double[::1] weights, double sign, double half, double rise):
        cdef double[MOST_NUMBERS] signed
        cdef Local found
        cdef int k, first
        cdef bint ended
        for k in range(weights.shape[0]):
            signed[k] = sign * weights[k]
        first = self.farthest_seen(signed, weights.shape[0])
        found = self.seen[first]
        with nogil:
            ended = self.climb(&found, signed, half, rise)
        # A number that has passed infinity has no end either.
        if not ended or valued(&found, signed, weights.shape[0]) < valued(self.seen, signed, weights.shape[0]):
            return None
        self.keep(&found)
        if valued(&found, signed, weights.shape[0]) < valued(&self.seen[first], signed, weights.shape[0]):
            found = self.seen[first]
        values = np.empty(weights.shape[0])
        cdef double[::1] value = values
        for k in range(weights.shape[0]):
            value[k] = found.values[k]
        return values

    cdef int farthest_seen(self, const double *weights, Py_ssize_t numbers) noexcept:
        cdef int k, best = 0
        for k in range(1, self.count):
            if valued(&self.seen[k], weights, numbers) > valued(&self.seen[best], weights, numbers):
                best = k
        return best

    cdef int keep(self, const Local *local) except -1:
        cdef Local *grown = <Local *>realloc(self.seen, (self.count + 1) * sizeof(Local))
        if grown == NULL:
            raise MemoryError
        self.seen = grown
        grown[self.count] = local[0]
        self.count += 1
        return 0

    cdef bint look(self, Local *local, double most) noexcept nogil:
        """The numbers of the surface of `local` and the cost about it; False where that is beyond the most."""
        cdef double[MOST * MOST] normal
        cdef double[MOST] gradient
        cdef double[MOST] turned
        cdef Surface *surface = &local.surface
        cdef double square = self.scale * self.scale
        cdef int dof = KINDS[surface.kind].dof, i, j, k, m
        if not self.add_up(local, most, normal, gradient):
            return False
        KINDS[surface.kind].numbers(surface, self.center, local.values, NULL)
        local.free = free_steps(surface, self.held(), self.touches, local.ways)
        for i in range(local.free):
            local.slope[i] = 0.0
            for k in range(dof):
                local.slope[i] += local.ways[i * MOST + k] * gradient[k] / square
                turned[k] = 0.0
                for m in range(dof):
                    turned[k] += normal[max(k, m) * MOST + min(k, m)] * local.ways[i * MOST + m]
            for j in range(i + 1):
                local.square[i * MOST + j] = 0.0
                for k in range(dof):
                    local.square[i * MOST + j] += local.ways[j * MOST + k] * turned[k] / square
        return True

    cdef bint add_up(self, Local *local, double most, double *normal, double *gradient) noexcept nogil:
        """The cost of a surface and its normal equations, by blocks; False as soon as it is beyond the most."""
        cdef Points block = self.points
        cdef double[MOST * MOST] part
        cdef double[MOST] pull
        cdef double *distance = self.room + 3 * self.points.n
        cdef double *jacobian = distance + BLOCK
        cdef int dof = KINDS[local.surface.kind].dof, i, j
        cdef Py_ssize_t start = 0
        local.cost = 0.0
        for i in range(dof):
            gradient[i] = 0.0
            for j in range(i + 1):
                normal[i * MOST + j] = 0.0
        while start < self.points.n:
            block.n = min(BLOCK, self.points.n - start)
            block.x, block.y, block.z = self.points.x + start, self.points.y + start, self.points.z + start
            if self.points.factor != NULL:
                block.factor = self.points.factor + start
            linearize(&local.surface, block, distance, jacobian)
            local.cost += cost_of(self.kernel, self.scale, distance, block.n)
            if not local.cost <= most:
                return False
            normal_equations(
                self.kernel, self.scale, distance, jacobian, block.n, dof, jacobian + dof * BLOCK, part, MOST, pull
            )
            for i in range(dof):
                gradient[i] += pull[i]
                for j in range(i + 1):
                    normal[i * MOST + j] += part[i * MOST + j]
            start += BLOCK
        return True

    cdef const Held *held(self) noexcept nogil:
        return NULL if self.bounds is None else &self.bounds.held

    cdef bint climb(self, Local *local, const double *weights, double half, double rise) noexcept nogil:
        """From a surface to the one where a number is largest among those of at most so much more cost.

        False where none ends it.
        """
        cdef int turn, k, dof = KINDS[local.surface.kind].dof
        cdef double most = self.seen[0].cost + rise, along
        cdef double[MOST] gradient
        cdef double[MOST] step
        cdef Surface start = local.surface
        for turn in range(ROUNDS):
            self.slope_of(&local.surface, weights, gradient)
            if not farthest(local, gradient, most - local.cost, step):
                return False
            along = 0.0
            for k in range(dof):
                along += gradient[k] * step[k]
            if fabs(local.cost - most) <= CLOSE * rise and fabs(along) <= CLOSE * half:
                return True
            if not self.move(local, step, max(most, local.cost) + OVERSHOOT * rise):
                return False
            if self.is_flat(&start, &local.surface):
                return False
        return False

    cdef void slope_of(self, const Surface *surface, const double *weights, double *gradient) noexcept nogil:
        """The derivative (dof,) by a step of the sum of the numbers with these weights."""
        cdef int i, k, dof = KINDS[surface.kind].dof, numbers
        cdef double[MOST_NUMBERS] values
        cdef double[MOST_NUMBERS * MOST] slopes
        numbers = KINDS[surface.kind].numbers(surface, self.center, values, slopes)
        for k in range(dof):
            gradient[k] = 0.0
            for i in range(numbers):
                gradient[k] += weights[i] * slopes[i * dof + k]

    cdef bint move(self, Local *local, const double *step, double most) noexcept nogil:
        """To where the largest of some shares of a step leads that is allowed; False where none is."""
        cdef double share = 1.0
        cdef double[MOST] part
        cdef Local there
        cdef int k
        while share > SHORTEST:
            for k in range(KINDS[local.surface.kind].dof):
                part[k] = share * step[k]
            there.surface = local.surface
            KINDS[local.surface.kind].step(&there.surface, part)
            if self.is_near(&local.surface, &there.surface) and self.look(&there, most):
                local[0] = there
                return True
            share *= 0.5
        return False

    cdef bint is_near(self, const Surface *one, const Surface *other) noexcept nogil:
        """Whether no size has changed too much for a step."""
        cdef int k
        cdef double old, new
        for k in range(self.sizes):
            old, new = one.numbers[self.places[k]], other.numbers[self.places[k]]
            if not 0.0 < old / GROWTH <= new <= old * GROWTH or (self.angles[k] and not new < QUARTER_TURN):
                return False
        return True

    cdef bint is_flat(self, const Surface *start, const Surface *surface) noexcept nogil:
        """Whether a size has gone as far as sizes go."""
        cdef int k
        cdef double old, new
        for k in range(self.sizes):
            old, new = start.numbers[self.places[k]], surface.numbers[self.places[k]]
            if (not FLATTEST <= new <= QUARTER_TURN - FLATTEST) if self.angles[k] else new > old / FLATTEST:
                return True
        return False


cdef double valued(const Local *local, const double *weights, Py_ssize_t numbers) noexcept nogil:
    cdef Py_ssize_t k
    cdef double total = 0.0
    for k in range(numbers):
        total += weights[k] * local.values[k]
    return total
