/* Cone: d = rho cos t - h sin t - s with the height h from the foot f, or the distance from the apex where that is
   the closest point.

   Derivatives: tilt -h (q . da) / rho cos t - (q . da) sin t; shift -(q . df) / rho cos t;
   dt: -rho sin t - h cos t; ds: -1. Behind the apex dd = -w . dc with w the unit vector from the apex c = f + H a,
   H = -s / sin t. */
#pragma once

#include "geometry/surface.h"

/* Half-angles are kept this far [rad] from 0 and from 90 degrees, where the apex or the nappe is lost. */
#define SMALLEST_ANGLE 1e-9
#define QUARTER_TURN 1.5707963267948966

EVERYWHERE void cone_loop(const Surface *s, Points points, double *restrict d, double *restrict j, int wanted)
{
    const double *restrict px = points.x, *restrict py = points.y, *restrict pz = points.z;
    const ptrdiff_t n = points.n;
    const Frame f = frame_of(s);
    const double offset = s->numbers[2], sine = sin(s->numbers[0]), cosine = cos(s->numbers[0]);
    const double apex = -offset / sine;
    double behind = 0.0;
    for (ptrdiff_t i = 0; i < n; i++) {
        const Around at = around_axis(f, px[i], py[i], pz[i]);
        const double side = (at.h - apex) * cosine + at.rho * sine;
        behind = side < behind ? side : behind;
        d[i] = at.rho * cosine - at.h * sine - offset;
        if (wanted) {
            const double lean = -at.h * cosine - at.rho * sine;
            j[i] = at.qu * lean, j[n + i] = at.qv * lean;
            j[2 * n + i] = -at.qu * cosine, j[3 * n + i] = -at.qv * cosine;
            j[4 * n + i] = -at.rho * sine - at.h * cosine, j[5 * n + i] = -1.0;
        }
    }
    if (behind == 0.0)
        return;
    for (ptrdiff_t i = 0; i < n; i++) {  /* the points that have the apex for their closest point */
        const double x = px[i] - f.cx, y = py[i] - f.cy, z = pz[i] - f.cz;
        const double h = x * f.ax + y * f.ay + z * f.az;
        const double qx = x - h * f.ax, qy = y - h * f.ay, qz = z - h * f.az;
        const double rho = sqrt(qx * qx + qy * qy + qz * qz);
        if ((h - apex) * cosine + rho * sine >= 0.0)
            continue;
        const double length = sqrt(rho * rho + (h - apex) * (h - apex)), inverse = -1.0 / (length + TINY);
        d[i] = length;
        if (wanted) {
            const double wa = (h - apex) * inverse;
            const double wu = (qx * f.ux + qy * f.uy + qz * f.uz) * inverse;
            const double wv = (qx * f.vx + qy * f.vy + qz * f.vz) * inverse;
            j[i] = apex * wu, j[n + i] = apex * wv, j[2 * n + i] = wu, j[3 * n + i] = wv;
            j[4 * n + i] = -wa * apex * cosine / sine, j[5 * n + i] = -wa / sine;
        }
    }
}
LOOPS(cone)

static void cone_settle(Surface *s) { s->numbers[2] -= refoot(s) * sin(s->numbers[0]); }

static void cone_step(Surface *s, const double *step)
{
    step_axis(s, step, 0.0);
    s->numbers[0] += step[4];
    s->numbers[2] += step[5];
    if (s->numbers[0] < 0.0) {
        s->numbers[0] = -s->numbers[0];
        for (int k = 0; k < 3; k++)
            s->axis[k] = -s->axis[k];
    }
    s->numbers[0] = lesser(greater(s->numbers[0], SMALLEST_ANGLE), QUARTER_TURN - SMALLEST_ANGLE);
    cone_settle(s);
}

/* apex = f + s - offset / sin(angle) (a + t). */
static int cone_numbers(const Surface *s, const double *center, double *values, double *slopes)
{
    const double *a = s->axis, sine = sin(s->numbers[0]), apex = -s->numbers[2] / sine;
    double u[3], v[3];
    (void)center;
    for (int k = 0; k < 3; k++)
        values[k] = s->anchor[k] + apex * a[k], values[3 + k] = a[k];
    values[6] = s->numbers[0];
    if (!slopes)
        return 7;
    slopes_of_axis(s, 7, 6, 3, slopes);
    basis(a, u, v);
    for (int k = 0; k < 3; k++) {
        double *row = slopes + k * 6;
        row[0] = apex * u[k], row[1] = apex * v[k], row[2] = u[k], row[3] = v[k];
        row[4] = -apex * cos(s->numbers[0]) / sine * a[k], row[5] = -a[k] / sine;
    }
    slopes[6 * 6 + 4] = 1.0;
    return 7;
}

/* The offset moves the surface along its axis by -1 / sin t. */
static void cone_outward(const Surface *s, const double *j, ptrdiff_t n, double *gradient)
{
    outward_of(s, j[2 * n], j[3 * n], j[5 * n] * sin(s->numbers[0]), gradient);
}

#define CONE_KIND \
    {"cone", 6, cone_distances, cone_slopes, cone_step, cone_settle, level_axis, cone_numbers, cone_outward}
