/* Normal equations of weighted least squares. */
#pragma once

#include "noise/kernels.h"

/* Sums of a b for each of four b: together they take hardly longer than one, which waits for each addition. */
VECTOR_UNITS static void inner(const double *restrict a, const double *const b[4], ptrdiff_t n, double sum[4])
{
    const double *restrict first = b[0], *restrict second = b[1], *restrict third = b[2], *restrict fourth = b[3];
    double one = 0.0, two = 0.0, three = 0.0, four = 0.0;
#pragma omp simd reduction(+ : one, two, three, four)
    for (ptrdiff_t i = 0; i < n; i++) {
        one += a[i] * first[i];
        two += a[i] * second[i];
        three += a[i] * third[i];
        four += a[i] * fourth[i];
    }
    sum[0] = one, sum[1] = two, sum[2] = three, sum[3] = four;
}

/* J^T W J (lower triangle, rows of `width`) and J^T W d; the scratch holds 2 n numbers. */
VECTOR_UNITS static void normal_equations(int kernel, double scale, const double *restrict d, const double *restrict j,
                                          ptrdiff_t n, int dof, double *restrict scratch, double *normal,
                                          int width, double *gradient)
{
    double *restrict weight = scratch, *restrict weighted = scratch + n;
    weigh(kernel, scale, d, n, weight);
    for (int row = 0; row < dof; row++) {
        const double *restrict slopes = j + row * n;
        for (ptrdiff_t i = 0; i < n; i++)
            weighted[i] = weight[i] * slopes[i];
        for (int first = -1; first <= row; first += 4) {  /* the derivatives, and before them the distances */
            const double *beside[4];
            double sum[4];
            for (int k = 0; k < 4; k++)
                beside[k] = first + k < 0 ? d : j + (first + k < row ? first + k : row) * n;
            inner(weighted, beside, n, sum);
            for (int k = 0; k < 4 && first + k <= row; k++)
                *(first + k < 0 ? gradient + row : normal + row * width + first + k) = sum[k];
        }
    }
}
