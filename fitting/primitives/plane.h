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

#define PLANE_KIND {"plane", 3, plane_distances, plane_slopes, plane_step, stays, level_pair}
