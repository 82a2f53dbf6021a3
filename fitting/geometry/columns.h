/* Weighted least squares of columns (m, n), for vector units. */
#pragma once

#include "geometry/vectors.h"

/* Sums of a b for each of four b: together they take hardly longer than one, which waits for each addition. */
EVERYWHERE void inner(const double *restrict a, const double *const b[4], ptrdiff_t n, double sum[4])
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

/* J^T W J (lower triangle, rows of `width`) and J^T W d of columns J (m, n); the scratch holds n numbers. */
VECTOR_UNITS static void weighted_sums(const double *restrict weight, const double *restrict d,
                                       const double *restrict columns, ptrdiff_t n, int m, double *restrict scratch,
                                       double *normal, int width, double *gradient)
{
    for (int row = 0; row < m; row++) {
        const double *restrict mine = columns + row * n;
        for (ptrdiff_t i = 0; i < n; i++)
            scratch[i] = weight[i] * mine[i];
        for (int first = -1; first <= row; first += 4) {  /* the columns, and before them d */
            const double *beside[4];
            double sum[4];
            for (int k = 0; k < 4; k++)
                beside[k] = first + k < 0 ? d : columns + (first + k < row ? first + k : row) * n;
            inner(scratch, beside, n, sum);
            for (int k = 0; k < 4 && first + k <= row; k++)
                *(first + k < 0 ? gradient + row : normal + row * width + first + k) = sum[k];
        }
    }
}

/* The sum of columns (m, n) times these factors (m), less the target (n). */
VECTOR_UNITS static void remainder_of(const double *restrict columns, const double *restrict target, ptrdiff_t n,
                                      int m, const double *factors, double *restrict rest)
{
    for (ptrdiff_t i = 0; i < n; i++)
        rest[i] = -target[i];
    for (int k = 0; k < m; k++) {
        const double *restrict column = columns + k * n;
        const double factor = factors[k];
        for (ptrdiff_t i = 0; i < n; i++)
            rest[i] += factor * column[i];
    }
}

/* Weights 1 / (1 + (rest / middle)^2). */
VECTOR_UNITS static void down_weigh(const double *restrict rest, ptrdiff_t n, double middle, double *restrict weight)
{
    const double unit = 1.0 / middle;
    for (ptrdiff_t i = 0; i < n; i++)
        weight[i] = 1.0 / (1.0 + rest[i] * unit * (rest[i] * unit));
}

/* Heights h and distances rho (n) of points from an axis through a foot. */
VECTOR_UNITS static void profile(const double *restrict x, const double *restrict y, const double *restrict z,
                                 ptrdiff_t n, const double *axis, const double *foot, double *restrict h,
                                 double *restrict rho)
{
    const double ax = axis[0], ay = axis[1], az = axis[2], fx = foot[0], fy = foot[1], fz = foot[2];
    for (ptrdiff_t i = 0; i < n; i++) {
        const double px = x[i] - fx, py = y[i] - fy, pz = z[i] - fz;
        const double height = px * ax + py * ay + pz * az;
        const double qx = px - height * ax, qy = py - height * ay, qz = pz - height * az;
        h[i] = height;
        rho[i] = sqrt(qx * qx + qy * qy + qz * qz);
    }
}
