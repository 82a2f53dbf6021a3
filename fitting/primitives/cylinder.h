/* Cylinder: d = rho - r.

   A tilt da changes the vector q from the axis by -h da - (x . da) a with q orthogonal to a, so
   drho = -h (q . da) / rho; a shift df gives drho = -(q . df) / rho. */
#pragma once

#include "geometry/surface.h"

EVERYWHERE void cylinder_loop(const Surface *s, Points points, double *restrict d, double *restrict j, int wanted)
{
    const double *restrict px = points.x, *restrict py = points.y, *restrict pz = points.z;
    const ptrdiff_t n = points.n;
    const Frame f = frame_of(s);
    const double radius = s->numbers[2];
    for (ptrdiff_t i = 0; i < n; i++) {
        const Around at = around_axis(f, px[i], py[i], pz[i]);
        d[i] = at.rho - radius;
        if (wanted) {
            j[i] = -at.h * at.qu, j[n + i] = -at.h * at.qv;
            j[2 * n + i] = -at.qu, j[3 * n + i] = -at.qv, j[4 * n + i] = -1.0;
        }
    }
}
LOOPS(cylinder)

static void cylinder_step(Surface *s, const double *step)
{
    step_axis(s, step, 0.0);
    s->numbers[2] = fabs(s->numbers[2] + step[4]);
    refoot(s);
}

static void cylinder_settle(Surface *s) { refoot(s); }

/* a' = a + t,  f' = f + s - (t . f) a,  p = f + ((c - f) . a) a,  where (t . f) a drops out. */
static int cylinder_numbers(const Surface *s, const double *center, double *values, double *slopes)
{
    const double *a = s->axis;
    double u[3], v[3], relative[3];
    for (int k = 0; k < 3; k++)
        relative[k] = center[k] - s->anchor[k];
    const double along = dot(relative, a);
    canonical_direction(a, values);
    for (int k = 0; k < 3; k++)
        values[3 + k] = s->anchor[k] + along * a[k];
    values[6] = s->numbers[2];
    if (!slopes)
        return 7;
    slopes_of_axis(s, 7, 5, 0, slopes);
    basis(a, u, v);
    for (int k = 0; k < 3; k++) {
        double *row = slopes + (3 + k) * 5;
        row[0] = a[k] * dot(relative, u) + along * u[k];
        row[1] = a[k] * dot(relative, v) + along * v[k];
        row[2] = u[k], row[3] = v[k];
    }
    slopes[6 * 5 + 4] = 1.0;
    return 7;
}

static void cylinder_outward(const Surface *s, const double *j, ptrdiff_t n, double *gradient)
{
    outward_of(s, j[2 * n], j[3 * n], 0.0, gradient);
}

#define CYLINDER_KIND \
    {"cylinder", 5, cylinder_distances, cylinder_slopes, cylinder_step, cylinder_settle, level_axis, \
     cylinder_numbers, cylinder_outward}
