/* A surface as a row of nine numbers, points as columns, and what a kind is to the compiled loops.

   The row, in a frame whose origin is near the points, is a direction, an anchor, and three numbers:

   kind      axis           anchor                      numbers[0]    numbers[1]      numbers[2]
   plane     unit normal n  point p
   sphere    any            center c                                                  radius r
   cylinder  unit axis a    foot f of the origin on it                                radius r
   cone      unit axis a    foot f of the origin on it  half-angle t                  offset s
   torus     unit axis a    center c                                  major radius R  minor radius r

   A step has as many components as the kind has degrees of freedom. Where there is an axis or a normal, the first
   two tilt it [rad] towards u and v of its basis: an axis about f or c, a plane about the foot of the origin. Then
   come shifts along u and v (the sphere: along x, y, z; the torus: along the axis, too; the plane: along the normal
   only), then the numbers of the row. */
#pragma once

#include "geometry/vectors.h"

/* Components of a step, at most, and numbers of an answer. */
#define MOST 9
#define MOST_NUMBERS 12

/* Components of a direction below this magnitude do not decide its sign. */
#define SIGN_TOLERANCE 1e-9

typedef struct {
    int kind;
    double axis[3];
    double anchor[3];
    double numbers[3];
} Surface;

/* Coordinates, and what the distance of each point is multiplied by; that pointer may be null. */
typedef struct {
    const double *restrict x, *restrict y, *restrict z;
    ptrdiff_t n;
    const double *restrict factor;
} Points;

typedef struct {
    const char *name;
    /* Degrees of freedom. */
    int dof;
    /* Distances d (n); and with them derivatives j (dof, n), one array a component. */
    void (*distances)(const Surface *, Points, double *d);
    void (*slopes)(const Surface *, Points, double *d, double *j);
    /* Move by a step. */
    void (*step)(Surface *, const double *step);
    /* Bring the row back to its normal form after its axis was turned. */
    void (*settle)(Surface *);
    /* Average over components of a step that a turn of the frame mixes. */
    void (*level)(double *values);
    /* The P numbers of an answer, in its canonical sign, whose free point is the one closest to a center (3); unless
       that pointer is null their derivatives (P, dof) by a step, at the sign of the surface. Returns P. */
    int (*numbers)(const Surface *, const double *center, double *values, double *slopes);
    /* The gradient (3) of the distance at a point from its derivatives by a step there, which are n apart. */
    void (*outward)(const Surface *, const double *j, ptrdiff_t n, double *gradient);
} Kind;

/* Both loops of a kind from one that is told whether derivatives are wanted. */
#define LOOPS(NAME) \
    VECTOR_UNITS static void NAME##_distances(const Surface *s, Points p, double *d) { NAME##_loop(s, p, d, NULL, 0); } \
    VECTOR_UNITS static void NAME##_slopes(const Surface *s, Points p, double *d, double *j) { NAME##_loop(s, p, d, j, 1); }

static void stays(Surface *s) { (void)s; }

/* A direction or its opposite: the one whose first component above SIGN_TOLERANCE is positive. */
static inline void canonical_direction(const double *direction, double *found)
{
    int first = 0;
    while (first < 2 && fabs(direction[first]) <= SIGN_TOLERANCE)
        first++;
    for (int k = 0; k < 3; k++)
        found[k] = direction[first] < -SIGN_TOLERANCE ? -direction[k] : direction[k];
}

/* No derivatives (P, dof), but those of a direction, from this row on, by its tilts in the first two columns. */
static inline void slopes_of_axis(const Surface *s, int numbers, int dof, int row, double *slopes)
{
    double u[3], v[3];
    basis(s->axis, u, v);
    for (int k = 0; k < numbers * dof; k++)
        slopes[k] = 0.0;
    for (int k = 0; k < 3; k++)
        slopes[(row + k) * dof] = u[k], slopes[(row + k) * dof + 1] = v[k];
}

/* The gradient of the distance from its derivatives by shifts along u and v, and its component along the axis. */
static inline void outward_of(const Surface *s, double by_u, double by_v, double along, double *gradient)
{
    double u[3], v[3];
    basis(s->axis, u, v);
    for (int k = 0; k < 3; k++)
        gradient[k] = along * s->axis[k] - by_u * u[k] - by_v * v[k];
}

/* Let the anchor be the foot of the origin on the axis; how high above it the anchor was. */
static inline double refoot(Surface *s)
{
    double height = dot(s->axis, s->anchor);
    for (int k = 0; k < 3; k++)
        s->anchor[k] -= height * s->axis[k];
    return height;
}

/* The first components of a step: shift along u and v of the basis, and along the axis, then tilt. */
static inline void step_axis(Surface *s, const double *step, double along)
{
    double u[3], v[3];
    basis(s->axis, u, v);
    for (int k = 0; k < 3; k++)
        s->anchor[k] += step[2] * u[k] + step[3] * v[k];
    if (along != 0.0)
        for (int k = 0; k < 3; k++)
            s->anchor[k] += along * s->axis[k];
    tilt(s->axis, u, v, step);
}

static inline void level_pair(double *values)
{
    values[0] = values[1] = 0.5 * (values[0] + values[1]);
}

static inline void level_axis(double *values)
{
    level_pair(values);
    level_pair(values + 2);
}

/* A point about an axis: height, distance, and the direction outwards in the basis. */
typedef struct {
    double ax, ay, az, ux, uy, uz, vx, vy, vz, cx, cy, cz;
} Frame;

typedef struct {
    double h, rho, qu, qv;
} Around;

static inline Frame frame_of(const Surface *s)
{
    double u[3], v[3];
    basis(s->axis, u, v);
    return (Frame){s->axis[0], s->axis[1], s->axis[2], u[0], u[1], u[2], v[0], v[1], v[2],
                   s->anchor[0], s->anchor[1], s->anchor[2]};
}

EVERYWHERE Around around_axis(const Frame f, double px, double py, double pz)
{
    const double x = px - f.cx, y = py - f.cy, z = pz - f.cz;
    const double h = x * f.ax + y * f.ay + z * f.az;
    const double qx = x - h * f.ax, qy = y - h * f.ay, qz = z - h * f.az;
    const double rho = sqrt(qx * qx + qy * qy + qz * qz), inverse = 1.0 / (rho + TINY);
    return (Around){h, rho, (qx * f.ux + qy * f.uy + qz * f.uz) * inverse, (qx * f.vx + qy * f.vy + qz * f.vz) * inverse};
}
