/* Plane: d = n . (x - p), with derivatives u.x, v.x, -1. */
#pragma once

#include "geometry/surface.h"

EVERYWHERE void plane_loop(const Surface *s, Points points, double *restrict d, double *restrict j, int wanted)
{
    const double *restrict px = points.x, *restrict py = points.y, *restrict pz = points.z;
    const ptrdiff_t n = points.n;
    const Frame f = frame_of(s);
#pragma omp simd
    for (ptrdiff_t i = 0; i < n; i++) {
        const double x = px[i] - f.cx, y = py[i] - f.cy, z = pz[i] - f.cz;
        d[i] = x * f.ax + y * f.ay + z * f.az;
        if (wanted) {
            j[i] = px[i] * f.ux + py[i] * f.uy + pz[i] * f.uz;
            j[n + i] = px[i] * f.vx + py[i] * f.vy + pz[i] * f.vz;
            j[2 * n + i] = -1.0;
        }
    }
}
LOOPS(plane)

static void plane_step(Surface *s, const double *step)
{
    double u[3], v[3], height = dot(s->axis, s->anchor) + step[2];
    basis(s->axis, u, v);
    for (int k = 0; k < 3; k++)
        s->anchor[k] = height * s->axis[k];
    tilt(s->axis, u, v, step);
}

/* With the height h = p . n:  n' = n + t,  p = c - (c . n - h) n,  for a tilt t and the center c. */
static int plane_numbers(const Surface *s, const double *center, double *values, double *slopes)
{
    const double *n = s->axis, height = dot(s->anchor, n) - dot(center, n);
    double u[3], v[3];
    canonical_direction(n, values);
    for (int k = 0; k < 3; k++)
        values[3 + k] = center[k] + height * n[k];
    if (!slopes)
        return 6;
    slopes_of_axis(s, 6, 3, 0, slopes);
    basis(n, u, v);
    for (int k = 0; k < 3; k++) {
        double *row = slopes + (3 + k) * 3;
        row[0] = height * u[k] - n[k] * dot(center, u);
        row[1] = height * v[k] - n[k] * dot(center, v);
        row[2] = n[k];
    }
    return 6;
}

static void plane_outward(const Surface *s, const double *j, ptrdiff_t n, double *gradient)
{
    (void)j, (void)n;
    outward_of(s, 0.0, 0.0, 1.0, gradient);
}

#define PLANE_KIND \
    {"plane", 3, plane_distances, plane_slopes, plane_step, stays, level_pair, plane_numbers, plane_outward}
