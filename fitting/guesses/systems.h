/* Overdetermined linear systems, deaf to a minority of outliers, and what points are as seen along a direction. */
#pragma once

#include "geometry/median.h"
#include "geometry/small.h"

/* Numbers of room that a system of n rows takes beside its columns. */
#define ROOM 3

/* Reweighted least squares for  sum columns[k] solution[k] = target (n,);  the room is (ROOM, n).

   Weights are 1 / (1 + (residual / median)^2) after the first round. */
static inline void solve_overdetermined(
    const double *columns, const double *target, ptrdiff_t n, int m, int rounds, double *room, double *solution)
{
    double normal[MOST * MOST], right[MOST], scales[MOST];
    double *weight = room, *rest = room + n, *scratch = room + 2 * n;
    for (int j = 0; j < m; j++)
        solution[j] = 0.0;
    for (ptrdiff_t i = 0; i < n; i++)
        weight[i] = 1.0;
    for (int turn = 0; turn < rounds; turn++) {
        double trace = 0.0, ridge = 0.0;
        weighted_sums(weight, target, columns, n, m, scratch, normal, MOST, right);
        for (int j = 0; j < m; j++) {
            trace += normal[j * MOST + j];
            right[j] = -right[j];
        }
        for (int j = 0; j < m; j++) {
            normal[j * MOST + j] += 1e-13 * trace + TINY;
            scales[j] = sqrt(normal[j * MOST + j]);
        }
        while (!solve(normal, right, scales, ridge, m, solution) && ridge < 1.0)
            ridge = greater(1e3 * ridge, 1e-15);
        if (turn + 1 == rounds)
            return;
        remainder_of(columns, target, n, m, solution, rest);
        if (!absolutes(rest, n, scratch))
            return;
        down_weigh(rest, n, median(scratch, n) + 1e-12, weight);
    }
}

/* Center (2,) and radius of the circle through points of a plane, by Kasa's linear fit  x^2 + y^2 = a x + b y + c.

   Columns are (4, n): x, y and room; the other room is (ROOM, n).
   Source: Kasa, "A circle fitting procedure and its error analysis", IEEE Trans. Instrum. Meas. 25, 1976. */
static inline double circle_through(double *columns, ptrdiff_t n, int rounds, double *room, double *center)
{
    double solution[3];
    for (ptrdiff_t i = 0; i < n; i++) {
        columns[2 * n + i] = 1.0;
        columns[3 * n + i] = columns[i] * columns[i] + columns[n + i] * columns[n + i];
    }
    solve_overdetermined(columns, columns + 3 * n, n, 3, rounds, room, solution);
    center[0] = solution[0] / 2.0, center[1] = solution[1] / 2.0;
    return sqrt(greater(solution[2] + center[0] * center[0] + center[1] * center[1], 1e-12));
}

/* Coordinates (n,) of points, given as columns (3, n), along one direction. */
VECTOR_UNITS static void seen_along(const double *restrict x, ptrdiff_t n, const double *axis, double *restrict along)
{
    const double ax = axis[0], ay = axis[1], az = axis[2];
    for (ptrdiff_t i = 0; i < n; i++)
        along[i] = x[i] * ax + x[n + i] * ay + x[2 * n + i] * az;
}
