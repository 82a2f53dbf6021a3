/* Sphere: d = |x - c| - r, with derivatives -(x - c) / |x - c|, -1. */
#pragma once

#include "geometry/surface.h"

EVERYWHERE void sphere_loop(const Surface *s, Points points, double *restrict d, double *restrict j, int wanted)
{
    const double *restrict px = points.x, *restrict py = points.y, *restrict pz = points.z;
    const ptrdiff_t n = points.n;
    const double cx = s->anchor[0], cy = s->anchor[1], cz = s->anchor[2], radius = s->numbers[2];
    for (ptrdiff_t i = 0; i < n; i++) {
        const double x = px[i] - cx, y = py[i] - cy, z = pz[i] - cz;
        const double length = sqrt(x * x + y * y + z * z), inverse = -1.0 / (length + TINY);
        d[i] = length - radius;
        if (wanted)
            j[i] = x * inverse, j[n + i] = y * inverse, j[2 * n + i] = z * inverse, j[3 * n + i] = -1.0;
    }
}
LOOPS(sphere)

static void sphere_step(Surface *s, const double *step)
{
    for (int k = 0; k < 3; k++)
        s->anchor[k] += step[k];
    s->numbers[2] = fabs(s->numbers[2] + step[3]);
}

static void sphere_level(double *values)
{
    values[0] = values[1] = values[2] = (values[0] + values[1] + values[2]) / 3.0;
}

/* They are the components of a step. */
static int sphere_numbers(const Surface *s, const double *center, double *values, double *slopes)
{
    (void)center;
    for (int k = 0; k < 3; k++)
        values[k] = s->anchor[k];
    values[3] = s->numbers[2];
    for (int k = 0; slopes && k < 16; k++)
        slopes[k] = k % 5 == 0 ? 1.0 : 0.0;
    return 4;
}

static void sphere_outward(const Surface *s, const double *j, ptrdiff_t n, double *gradient)
{
    (void)s;
    for (int k = 0; k < 3; k++)
        gradient[k] = -j[k * n];
}

#define SPHERE_KIND \
    {"sphere", 4, sphere_distances, sphere_slopes, sphere_step, stays, sphere_level, sphere_numbers, sphere_outward}
