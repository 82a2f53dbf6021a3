/* Small dense matrices of the parameters of a surface, as rows of so many numbers as they have. */
#pragma once

#include "geometry/surface.h"

/* Sweeps over all pairs of columns: each but the last few squares how far they are from orthogonal. */
#define SWEEPS 40

/* The lower factor L of a symmetric matrix (k, k), of which the lower triangle is read. Its eigenvalues are known to be
   no smaller than `least`, and neither are pivots then: what is less is rounding. */
static inline void factor(const double *matrix, int k, double least, double *lower)
{
    for (int i = 0; i < k; i++)
        for (int j = 0; j <= i; j++) {
            double rest = matrix[i * k + j];
            for (int l = 0; l < j; l++)
                rest -= lower[i * k + l] * lower[j * k + l];
            lower[i * k + j] = i == j ? sqrt(greater(rest, least)) : rest / lower[j * k + j];
        }
}

/* L^-1 b (k,), in the place of b. */
static inline void forwards(const double *lower, int k, double *b)
{
    for (int i = 0; i < k; i++) {
        for (int l = 0; l < i; l++)
            b[i] -= lower[i * k + l] * b[l];
        b[i] /= lower[i * k + i];
    }
}

/* L^-T b (k,), in the place of b. */
static inline void backwards(const double *lower, int k, double *b)
{
    for (int i = k - 1; i >= 0; i--) {
        for (int l = i + 1; l < k; l++)
            b[i] -= lower[l * k + i] * b[l];
        b[i] /= lower[i * k + i];
    }
}

/* Logarithm of the determinant of  1 + scale M  for a matrix (k, k) that is not negative. */
static inline double log_of_more(const double *matrix, int k, double scale)
{
    double more[MOST * MOST], lower[MOST * MOST], product = 1.0;
    for (int i = 0; i < k; i++)
        for (int j = 0; j < k; j++)
            more[i * k + j] = scale * matrix[i * k + j] + (i == j);
    factor(more, k, 1.0, lower);
    for (int i = 0; i < k; i++)
        product *= lower[i * k + i];
    return 2.0 * log(product);
}

EVERYWHERE double inner(const double *restrict a, const double *restrict b, ptrdiff_t n)
{
    double sum = 0.0;
#pragma omp simd reduction(+ : sum)
    for (ptrdiff_t i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

EVERYWHERE void turn_pair(double *restrict a, double *restrict b, ptrdiff_t n, double cosine, double sine)
{
#pragma omp simd
    for (ptrdiff_t i = 0; i < n; i++) {
        const double first = a[i], second = b[i];
        a[i] = cosine * first - sine * second;
        b[i] = sine * first + cosine * second;
    }
}

/* Turn two of the columns so that they are orthogonal; whether they were not, to rounding. */
EVERYWHERE int part(double *a, double *b, ptrdiff_t n, double *turned_a, double *turned_b, int k)
{
    const double aa = inner(a, a, n), bb = inner(b, b, n), ab = inner(a, b, n);
    if (fabs(ab) <= 1e-15 * sqrt(aa * bb))
        return 0;
    const double half = (bb - aa) / (2.0 * ab);
    const double tangent = (half >= 0.0 ? 1.0 : -1.0) / (fabs(half) + sqrt(1.0 + half * half));
    const double cosine = 1.0 / sqrt(1.0 + tangent * tangent);
    turn_pair(a, b, n, cosine, cosine * tangent);
    turn_pair(turned_a, turned_b, k, cosine, cosine * tangent);
    return 1;
}

/* Singular values of columns (k, n), in whose place U S is left; `directions` (k, k) become V, column by column.

   Source: Hestenes, "Inversion of matrices by biorthogonalization", J. SIAM 6, 1958. */
VECTOR_UNITS static void turn_apart(double *columns, int k, ptrdiff_t n, double *directions, double *sizes)
{
    for (int i = 0; i < k * k; i++)
        directions[i] = i % (k + 1) == 0;
    for (int sweep = 0, turned = 1; sweep < SWEEPS && turned; sweep++) {
        turned = 0;
        for (int i = 0; i < k; i++)
            for (int j = i + 1; j < k; j++)
                turned |= part(columns + i * n, columns + j * n, n, directions + i * k, directions + j * k, k);
    }
    for (int i = 0; i < k; i++)
        sizes[i] = sqrt(inner(columns + i * n, columns + i * n, n));
}
