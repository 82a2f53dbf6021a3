/* Normal equations of weighted least squares under a kernel. */
#pragma once

#include "geometry/small.h"
#include "noise/kernels.h"

/* J^T W J (lower triangle, rows of `width`) and J^T W d; the scratch holds 2 n numbers. */
static inline void normal_equations(int kernel, double scale, const double *d, const double *j, ptrdiff_t n, int dof,
                                    double *scratch, double *normal, int width, double *gradient)
{
    weigh(kernel, scale, d, n, scratch);
    weighted_sums(scratch, d, j, n, dof, scratch + n, normal, width, gradient);
}
