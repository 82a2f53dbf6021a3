/* Eigenvalues and eigenvectors of symmetric 3 x 3 matrices by Jacobi's rotations.

   Those of a graded matrix come out as exactly as its entries tell, also the small ones, which a closed form loses.
   Source: Rutishauser, "The Jacobi method for real symmetric matrices", Numerische Mathematik 9, 1966. */
#pragma once

#include <float.h>
#include <math.h>

/* Sweeps at most: five are enough for any matrix. */
#define SWEEPS 12

/* Let a rotation in the plane of axes p and q, r being the third, clear the entry there. */
static inline void rotate_pair(double a[3][3], double vectors[3][3], int p, int q, int r)
{
    const double theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    const double t = (theta < 0.0 ? -1.0 : 1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
    const double c = 1.0 / sqrt(t * t + 1.0), s = t * c;
    const double along = a[p][r], across = a[q][r];
    a[p][p] -= t * a[p][q];
    a[q][q] += t * a[p][q];
    a[p][q] = a[q][p] = 0.0;
    a[p][r] = a[r][p] = c * along - s * across;
    a[q][r] = a[r][q] = s * along + c * across;
    for (int k = 0; k < 3; k++) {
        const double first = vectors[k][p], second = vectors[k][q];
        vectors[k][p] = c * first - s * second;
        vectors[k][q] = s * first + c * second;
    }
}

/* Entries below the rounding of those on the diagonal are nothing. */
static inline int is_cleared(double a[3][3], int p, int q)
{
    return !(fabs(a[p][q]) > 0.25 * DBL_EPSILON * sqrt(fabs(a[p][p])) * sqrt(fabs(a[q][q])));
}

/* Eigenvalues, ascending, of a symmetric matrix, which is lost, and unit eigenvectors in columns. */
static inline void eigen(double a[3][3], double *values, double vectors[3][3])
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            vectors[i][j] = i == j;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        int turned = 0;
        for (int r = 2; r >= 0; r--) {
            const int p = r == 0 ? 1 : 0, q = r == 2 ? 1 : 2;
            if (is_cleared(a, p, q))
                continue;
            rotate_pair(a, vectors, p, q, r);
            turned = 1;
        }
        if (!turned)
            break;
    }
    for (int k = 0; k < 3; k++)
        values[k] = a[k][k];
    for (int last = 2; last > 0; last--)
        for (int k = 0; k < last; k++)
            if (values[k] > values[k + 1]) {
                const double larger = values[k];
                values[k] = values[k + 1];
                values[k + 1] = larger;
                for (int i = 0; i < 3; i++) {
                    const double entry = vectors[i][k];
                    vectors[i][k] = vectors[i][k + 1];
                    vectors[i][k + 1] = entry;
                }
            }
}
