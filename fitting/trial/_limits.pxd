"""What `_limits` hands to other compiled modules."""

cdef extern from "trial/surfaces.h" nogil:
    enum:
        MOST
        MOST_NUMBERS
    double TINY
    ctypedef struct Surface:
        int kind
        double axis[3]
        double anchor[3]
        double numbers[3]
    ctypedef struct Points:
        const double *x
        const double *y
        const double *z
        Py_ssize_t n
        const double *factor
    ctypedef struct Kind:
        const char *name
        int dof
        void (*step)(Surface *surface, const double *step) noexcept nogil
        void (*settle)(Surface *surface) noexcept nogil
        void (*level)(double *values) noexcept nogil
        int (*numbers)(const Surface *surface, const double *center, double *values, double *slopes) noexcept nogil
        void (*outward)(const Surface *surface, const double *j, Py_ssize_t n, double *gradient) noexcept nogil
    const Kind *KINDS
    const int COUNT
    double dot(const double *a, const double *b)
    void basis(const double *axis, double *u, double *v)
    void normalize(double *direction)
    void linearize(const Surface *surface, Points points, double *distance, double *jacobian)

cdef extern from "geometry/small.h" nogil:
    bint solve(
        const double *normal, const double *gradient, const double *scales, double damping, int dof, double *step
    )

cdef struct Held:
    bint frozen[MOST]
    int slots[3]
    double low[3]
    double high[3]
    double reference[3]
    double most_tilt

cdef class Bounds:
    cdef Held held

cdef const Held *held_by(Bounds bounds) noexcept
cdef void keep_within(Surface *surface, const Held *limits) noexcept nogil
cdef bint solve_within(
    const Surface *surface, const Held *limits, const double *normal, const double *gradient,
    const double *scales, double damping, int dof, double *step
) noexcept nogil
