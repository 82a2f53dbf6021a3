/* Eigenvalues and eigenvectors of symmetric 3 x 3 matrices, many at once, by Jacobi's rotations.

   Those of a graded matrix come out as exactly as its entries tell, also the small ones, which a closed form loses.
   Source: Rutishauser, "The Jacobi method for real symmetric matrices", Numerische Mathematik 9, 1966. */
#pragma once

#include "geometry/vectors.h"

/* Rounds of three rotations: after four of them nothing but rounding is left to clear. */
#define ROUNDS 6

/* Let a rotation of each of n matrices clear entry pq, and turn two vectors; r is the third axis. All are rows (n,),
   those of a vector one after the other. */
VECTOR_UNITS static void rotate_pairs(
    double *restrict pp, double *restrict qq, double *restrict pq, double *restrict pr, double *restrict qr,
    double *restrict p, double *restrict q, ptrdiff_t n)
{
#pragma omp simd
    for (ptrdiff_t i = 0; i < n; i++) {
        const double apart = qq[i] - pp[i], twice = 2.0 * pq[i];
        const double t = (apart < 0.0 ? -twice : twice) / (fabs(apart) + sqrt(apart * apart + twice * twice) + TINY);
        const double c = 1.0 / sqrt(1.0 + t * t), s = t * c;
        const double along = pr[i], across = qr[i];
        const double px = p[i], py = p[n + i], pz = p[2 * n + i];
        const double qx = q[i], qy = q[n + i], qz = q[2 * n + i];
        pp[i] -= t * pq[i];
        qq[i] += t * pq[i];
        pq[i] = 0.0;
        pr[i] = c * along - s * across;
        qr[i] = s * along + c * across;
        p[i] = c * px - s * qx, p[n + i] = c * py - s * qy, p[2 * n + i] = c * pz - s * qz;
        q[i] = s * px + c * qx, q[n + i] = s * py + c * qy, q[2 * n + i] = s * pz + c * qz;
    }
}

/* Let the smaller of two eigenvalues, and its vector, come first. */
static inline void put_in_order(double *first, double *second, double *p, double *q, ptrdiff_t n)
{
    for (ptrdiff_t i = 0; i < n; i++) {
        if (!(second[i] < first[i]))
            continue;
        const double larger = first[i];
        first[i] = second[i];
        second[i] = larger;
        for (ptrdiff_t at = i; at < 3 * n; at += n) {
            const double entry = p[at];
            p[at] = q[at];
            q[at] = entry;
        }
    }
}

/* Eigenvalues, ascending, in the first three rows in place of the entries xx, yy, zz, xy, xz, yz (6, n) of n matrices;
   and unit eigenvectors, three rows each, (9, n). */
static inline void eigen(double *entries, ptrdiff_t n, double *vectors)
{
    double *xx = entries, *yy = entries + n, *zz = entries + 2 * n;
    double *xy = entries + 3 * n, *xz = entries + 4 * n, *yz = entries + 5 * n;
    double *u = vectors, *v = vectors + 3 * n, *w = vectors + 6 * n;
    for (ptrdiff_t at = 0; at < 9 * n; at++)
        vectors[at] = at / n % 4 == 0;
    for (int round = 0; round < ROUNDS; round++) {
        rotate_pairs(xx, yy, xy, xz, yz, u, v, n);
        rotate_pairs(xx, zz, xz, xy, yz, u, w, n);
        rotate_pairs(yy, zz, yz, xy, xz, v, w, n);
    }
    put_in_order(xx, yy, u, v, n);
    put_in_order(yy, zz, v, w, n);
    put_in_order(xx, yy, u, v, n);
}
