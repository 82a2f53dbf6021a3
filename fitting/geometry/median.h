/* Medians, and the magnitudes that they are taken of. */
#pragma once

#include <string.h>

#include "geometry/vectors.h"

/* Puts the values below a pivot first, or those up to it; how many there are. No branch depends on a value, as
   half of them would be foreseen wrongly. */
static inline ptrdiff_t parted(double *values, ptrdiff_t n, double pivot, int with_equal)
{
    ptrdiff_t below = 0;
    for (ptrdiff_t i = 0; i < n; i++) {
        const double value = values[i];
        values[i] = values[below];
        values[below] = value;
        below += (value < pivot) | (with_equal & (value == pivot));
    }
    return below;
}

/* The value of this rank, by Hoare's selection; reorders the values so that those before it are no larger. */
static inline double selected(double *values, ptrdiff_t n, ptrdiff_t rank)
{
    double *first = values;
    while (n > 1) {
        const double a = first[0], b = first[n / 2], c = first[n - 1];
        const double pivot = greater(lesser(a, b), lesser(greater(a, b), c));
        ptrdiff_t below = parted(first, n, pivot, 0);
        if (rank < below) {
            n = below;
            continue;
        }
        if (below == 0) { /* the pivot is the smallest */
            below = parted(first, n, pivot, 1);
            if (rank < below)
                return pivot;
        }
        first += below, n -= below, rank -= below;
    }
    return *first;
}

/* As numpy.median; reorders the values. NaN must not be among them. */
static inline double median(double *values, ptrdiff_t n)
{
    const double upper = selected(values, n, n / 2);
    if (n % 2)
        return upper;
    double lower = values[0];
    for (ptrdiff_t i = 1; i < n / 2; i++)
        lower = greater(lower, values[i]);
    return 0.5 * (lower + upper);
}

/* Absolute values; whether all are finite. */
static inline int absolutes(const double *distance, ptrdiff_t n, double *absolute)
{
    int finite = 1;
    for (ptrdiff_t i = 0; i < n; i++) {
        absolute[i] = fabs(distance[i]);
        finite &= isfinite(absolute[i]) != 0;
    }
    return finite;
}
