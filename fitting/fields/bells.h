/* How patches agree that are so far apart. */
#pragma once

#include "fields/factors.h"
#include "geometry/vectors.h"

/* Correlations (m, m) of n patches that are so far apart (n, n):  exp(-d / span)  of a rough field,
   exp(-d^2 / 2 span^2)  of a smooth one; rows and columns beyond n are 0. */
VECTOR_UNITS static void bell_of(
    const double *apart, ptrdiff_t n, ptrdiff_t m, double span, int smooth, double *bell)
{
    for (ptrdiff_t i = 0; i < m; i++) {
        const double *restrict from = apart + i * n;
        double *restrict row = bell + i * m;
        for (ptrdiff_t j = 0; j < (i < n ? n : 0); j++)
            row[j] = greater(smooth ? from[j] * from[j] * (-0.5 / (span * span)) : from[j] * (-1.0 / span), LOWEST);
        fall(row, i < n ? n : 0);
        for (ptrdiff_t j = i < n ? n : 0; j < m; j++)
            row[j] = 0.0;
    }
}
