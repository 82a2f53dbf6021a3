/* The scale of the core of absolute distances; see fitting/noise/scale.py, which holds the numbers `core` and
   `deviation`. */
#pragma once

#include "geometry/median.h"

/* Rounds of estimating a scale at most. */
#define CORE_ROUNDS 30

/* Standard deviation under the weights (1 - (x / core / scale)^2)^2 over that of a normal variable, or 0. */
VECTOR_UNITS static double weighed(const double *absolute, ptrdiff_t n, double scale, double core, double deviation)
{
    const double unit = 1.0 / (core * scale * core * scale);
    double total = 0.0, weights = 0.0;
#pragma omp simd reduction(+ : total, weights)
    for (ptrdiff_t i = 0; i < n; i++) {
        const double square = absolute[i] * absolute[i], weight = greater(1.0 - unit * square, 0.0);
        weights += weight * weight;
        total += weight * weight * square;
    }
    return weights > 0.0 ? sqrt(total / weights) / deviation : 0.0;
}

/* The scale that a given one leads to; steps are extrapolated by Aitken's method until they are below `rest`. */
static inline double core_from(double scale, const double *absolute, ptrdiff_t n, double core, double deviation, double rest)
{
    for (int turn = 0; turn < CORE_ROUNDS; turn++) {
        if (scale == 0.0)
            return 0.0;
        const double first = weighed(absolute, n, scale, core, deviation);
        if (first == 0.0 || fabs(first - scale) <= rest * scale)
            return first;
        const double second = weighed(absolute, n, first, core, deviation);
        if (second == 0.0 || fabs(second - first) <= rest * first)
            return second;
        const double bend = second - 2.0 * first + scale;
        const double far = bend != 0.0 ? scale - (first - scale) * (first - scale) / bend : second;
        scale = far > 0.0 && fabs(far - second) <= fabs(second - scale) ? far : second;
    }
    return scale;
}

/* From the normalized median on; the scratch is for n numbers. */
static inline double core_of(
    const double *absolute, ptrdiff_t n, double *scratch, double core, double deviation, double rest)
{
    memcpy(scratch, absolute, n * sizeof *scratch);
    return core_from(1.4826 * median(scratch, n), absolute, n, core, deviation, rest);
}
