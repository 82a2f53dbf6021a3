/* Torus: d = hypot(rho - R, h) - r.

   Derivatives, with g = (rho - R, h) / hypot(rho - R, h): tilt drho = -h (q . da) / rho, dh = q . da; shift across
   drho = -(q . df) / rho; along dh = -1; dR: -g0; dr: -1. */
#pragma once

#include "geometry/surface.h"

EVERYWHERE void torus_loop(const Surface *s, Points points, double *restrict d, double *restrict j, int wanted)
{
    const double *restrict px = points.x, *restrict py = points.y, *restrict pz = points.z;
    const ptrdiff_t n = points.n;
    const Frame f = frame_of(s);
    const double major = s->numbers[1], minor = s->numbers[2];
#pragma omp simd
    for (ptrdiff_t i = 0; i < n; i++) {
        const Around at = around_axis(f, px[i], py[i], pz[i]);
        const double across = at.rho - major, length = sqrt(across * across + at.h * at.h);
        d[i] = length - minor;
        if (wanted) {
            const double scale = 1.0 / (length + TINY), g_rho = across * scale, g_height = at.h * scale;
            const double lean = g_height * at.rho - at.h * g_rho;
            j[i] = at.qu * lean, j[n + i] = at.qv * lean, j[2 * n + i] = -at.qu * g_rho, j[3 * n + i] = -at.qv * g_rho;
            j[4 * n + i] = -g_height, j[5 * n + i] = -g_rho, j[6 * n + i] = -1.0;
        }
    }
}
LOOPS(torus)

static void torus_step(Surface *s, const double *step)
{
    step_axis(s, step, step[4]);
    s->numbers[1] = fabs(s->numbers[1] + step[5]);
    s->numbers[2] = fabs(s->numbers[2] + step[6]);
}

/* Center and axis move as the step says, and the radii. */
static int torus_numbers(const Surface *s, const double *center, double *values, double *slopes)
{
    double u[3], v[3];
    (void)center;
    canonical_direction(s->axis, values + 3);
    for (int k = 0; k < 3; k++)
        values[k] = s->anchor[k];
    values[6] = s->numbers[1], values[7] = s->numbers[2];
    if (!slopes)
        return 8;
    slopes_of_axis(s, 8, 7, 3, slopes);
    basis(s->axis, u, v);
    for (int k = 0; k < 3; k++)
        slopes[k * 7 + 2] = u[k], slopes[k * 7 + 3] = v[k], slopes[k * 7 + 4] = s->axis[k];
    slopes[6 * 7 + 5] = slopes[7 * 7 + 6] = 1.0;
    return 8;
}

static void torus_outward(const Surface *s, const double *j, ptrdiff_t n, double *gradient)
{
    outward_of(s, j[2 * n], j[3 * n], -j[4 * n], gradient);
}

#define TORUS_KIND \
    {"torus", 7, torus_distances, torus_slopes, torus_step, stays, level_axis, torus_numbers, torus_outward}
