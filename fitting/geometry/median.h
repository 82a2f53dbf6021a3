/* Medians, and the magnitudes that they are taken of. */
#pragma once

#include <string.h>

#include "geometry/vectors.h"

/* The value of this rank, by Hoare's selection; reorders the values so that those before it are no larger. */
static inline double selected(double *values, ptrdiff_t n, ptrdiff_t rank)
{
    ptrdiff_t low = 0, high = n - 1;
    while (low < high) {
        const double pivot = values[(low + high) / 2];
        ptrdiff_t i = low, j = high;
        while (i <= j) {
            while (values[i] < pivot)
                i++;
            while (values[j] > pivot)
                j--;
            if (i <= j) {
                const double swap = values[i];
                values[i++] = values[j];
                values[j--] = swap;
            }
        }
        if (rank <= j)
            high = j;
        else if (rank >= i)
            low = i;
        else
            break;
    }
    return values[rank];
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
