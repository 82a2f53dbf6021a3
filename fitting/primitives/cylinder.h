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
#pragma omp simd
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

#define CYLINDER_KIND \
    {"cylinder", 5, cylinder_distances, cylinder_slopes, cylinder_step, cylinder_settle, level_axis}
