"""What `_descent` hands to other compiled modules."""

from ..trial._limits cimport Held, Points, Surface

cdef enum:
    BLOCK = 256

cdef void load(Surface *surface, int kind, const double *row) noexcept nogil
cdef void store(const Surface *surface, double *row) noexcept nogil
cdef Points columns(const double[:, ::1] points, double *room) noexcept nogil
cdef bint descend(
    Surface *surface, Points points, int kernel, double scale, int max_iterations, double *distance,
    double *room, double *cost, const Held *limits=*
) noexcept nogil
