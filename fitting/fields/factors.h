/* Cholesky factors of covariances of some dozen patches; the loops are written for vector units. */
#pragma once

#include <stdint.h>

#include "geometry/vectors.h"

/* So many rows are eliminated at a time, in tiles of so many columns: what fits into the registers. */
#define PANEL 4
#define TILE 8

/* Rows and columns of a matrix come in whole tiles. */
static inline ptrdiff_t padded(ptrdiff_t n) { return (n + TILE - 1) / TILE * TILE; }

/* Of room for eight numbers more than needed, where a line of the cache begins. */
static inline double *aligned(double *room) { return (double *)(((uintptr_t)room + 63) / 64 * 64); }

/* The factor of the square that a panel begins with: below the diagonal its numbers, on it their inverses. */
static inline int factor_square(const double *panel, ptrdiff_t width, double lower[PANEL][PANEL])
{
    for (int i = 0; i < PANEL; i++)
        for (int j = 0; j <= i; j++) {
            double rest = panel[j * width + i];
            for (int k = 0; k < j; k++)
                rest -= lower[i][k] * lower[j][k];
            if (i != j)
                lower[i][j] = rest * lower[j][j];
            else if (rest > 0.0)
                lower[i][i] = 1.0 / sqrt(rest);
            else
                return 0;
        }
    return 1;
}

/* The rows of a panel divided by that factor. */
EVERYWHERE void divide_panel(double *panel, ptrdiff_t width, ptrdiff_t length, double lower[PANEL][PANEL])
{
    double *restrict a = panel, *restrict b = panel + width;
    double *restrict c = panel + 2 * width, *restrict d = panel + 3 * width;
    const double a0 = lower[0][0], b0 = lower[1][0], b1 = lower[1][1], c0 = lower[2][0], c1 = lower[2][1];
    const double c2 = lower[2][2], d0 = lower[3][0], d1 = lower[3][1], d2 = lower[3][2], d3 = lower[3][3];
#pragma omp simd
    for (ptrdiff_t j = 0; j < length; j++) {
        const double first = a[j] * a0, second = (b[j] - b0 * first) * b1;
        const double third = (c[j] - c0 * first - c1 * second) * c2;
        a[j] = first, b[j] = second, c[j] = third;
        d[j] = (d[j] - d0 * first - d1 * second - d2 * third) * d3;
    }
}

/* A tile of a panel, at this row and column, less what the first rows, which are done, make of it. */
EVERYWHERE void take_rows(double *rows, ptrdiff_t width, ptrdiff_t done, ptrdiff_t at, ptrdiff_t column)
{
    double a[TILE] = {0.0}, b[TILE] = {0.0}, c[TILE] = {0.0}, d[TILE] = {0.0};
    for (ptrdiff_t k = 0; k < done; k++) {
        const double *row = rows + k * width;
        const double one = row[at], two = row[at + 1], three = row[at + 2], four = row[at + 3];
#pragma omp simd
        for (int j = 0; j < TILE; j++) {
            const double value = row[column + j];
            a[j] += one * value, b[j] += two * value, c[j] += three * value, d[j] += four * value;
        }
    }
    double *tile = rows + at * width + column;
    for (int j = 0; j < TILE; j++)
        tile[j] -= a[j];
    tile += width;
    for (int j = 0; j < TILE; j++)
        tile[j] -= b[j];
    tile += width;
    for (int j = 0; j < TILE; j++)
        tile[j] -= c[j];
    tile += width;
    for (int j = 0; j < TILE; j++)
        tile[j] -= d[j];
}

/* Of a matrix (width, width) that holds a covariance (m, m), the upper triangle of it, columns B beside it and zeros
   below these: the upper factor U with U^T U = C, U^-T B, and -B^T C^-1 B, the upper triangle of it, in their places.
   Below the diagonal nothing is left that means anything. Whether the covariance is positive definite. */
VECTOR_UNITS static int eliminate(double *rows, ptrdiff_t m, ptrdiff_t width)
{
    double lower[PANEL][PANEL];
    for (ptrdiff_t p = 0; p < width; p += PANEL) {
        for (ptrdiff_t column = p / TILE * TILE; column < width; column += TILE)
            take_rows(rows, width, p < m ? p : m, p, column);
        double *panel = rows + p * width + p;
        if (p >= m)
            continue;
        if (!factor_square(panel, width, lower))
            return 0;
        divide_panel(panel, width, (width - p) / PANEL * PANEL, lower);
    }
    return 1;
}

/* The solution of U w = h in the place of h (m,), for the factor that `eliminate` leaves. */
VECTOR_UNITS static void substitute(const double *rows, ptrdiff_t m, ptrdiff_t width, double *restrict h)
{
    for (ptrdiff_t p = m - PANEL; p >= 0; p -= PANEL) {
        const double *restrict a = rows + p * width, *restrict b = a + width;
        const double *restrict c = b + width, *restrict d = c + width;
        double one = h[p], two = h[p + 1], three = h[p + 2], four = h[p + 3];
#pragma omp simd reduction(- : one, two, three, four)
        for (ptrdiff_t j = p + PANEL; j < m; j++) {
            one -= a[j] * h[j], two -= b[j] * h[j];
            three -= c[j] * h[j], four -= d[j] * h[j];
        }
        four /= d[p + 3];
        three = (three - c[p + 3] * four) / c[p + 2];
        two = (two - b[p + 2] * three - b[p + 3] * four) / b[p + 1];
        one = (one - a[p + 1] * two - a[p + 2] * three - a[p + 3] * four) / a[p];
        h[p] = one, h[p + 1] = two, h[p + 2] = three, h[p + 3] = four;
    }
}
