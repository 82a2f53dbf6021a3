/* Cholesky factors of covariances of some dozen patches; the loops are written for vector units. */
#pragma once

#include "geometry/vectors.h"

/* Of rows (n, width) that hold a covariance (n, n), the upper triangle of it, and columns B beside it: the upper
   factor U with U^T U = C, and U^-T B, in their places. Whether the covariance is positive definite. */
VECTOR_UNITS static int eliminate(double *rows, ptrdiff_t n, ptrdiff_t width)
{
    for (ptrdiff_t k = 0; k < n; k++) {
        double *restrict pivot = rows + k * width;
        if (!(pivot[k] > 0.0))
            return 0;
        const double inverse = 1.0 / sqrt(pivot[k]);
        for (ptrdiff_t j = k; j < width; j++)
            pivot[j] *= inverse;
        for (ptrdiff_t i = k + 1; i < n; i++) {
            double *restrict row = rows + i * width;
            const double factor = pivot[i];
            for (ptrdiff_t j = i; j < width; j++)
                row[j] -= factor * pivot[j];
        }
    }
    return 1;
}

/* U^-1 B in the place of columns B, beside the factor that `eliminate` leaves. */
VECTOR_UNITS static void substitute(double *rows, ptrdiff_t n, ptrdiff_t width)
{
    for (ptrdiff_t k = n - 1; k >= 0; k--) {
        double *restrict solved = rows + k * width;
        const double inverse = 1.0 / solved[k];
        for (ptrdiff_t j = n; j < width; j++)
            solved[j] *= inverse;
        for (ptrdiff_t i = 0; i < k; i++) {
            double *restrict row = rows + i * width;
            const double factor = row[k];
            for (ptrdiff_t j = n; j < width; j++)
                row[j] -= factor * solved[j];
        }
    }
}
