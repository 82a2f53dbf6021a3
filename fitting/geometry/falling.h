/* Exponentials of numbers that are not positive, on vector units. */
#pragma once

#include <stdint.h>
#include <string.h>

#include "geometry/vectors.h"

/* Below this exponent they are as good as 0. */
#define LOWEST -600.0

/* exp(x) of x from LOWEST to 0, to two units in the last place: 2^k exp(r) with |r| <= log(2) / 2.

   The C library's would be called point by point. Adding `shifter` rounds to a whole number, which then stands in the
   last bits. */
EVERYWHERE double falling(double x)
{
    const double shifter = 6755399441055744.0, log_2 = 6.93147180369123816490e-01, rest = 1.90821492927058770002e-10;
    const double shifted = x * 1.44269504088896340736 + shifter, whole = shifted - shifter;
    const double r = (x - whole * log_2) - whole * rest;
    double sum = 1.0 / 6227020800.0, power;
    sum = sum * r + 1.0 / 479001600.0, sum = sum * r + 1.0 / 39916800.0, sum = sum * r + 1.0 / 3628800.0;
    sum = sum * r + 1.0 / 362880.0, sum = sum * r + 1.0 / 40320.0, sum = sum * r + 1.0 / 5040.0;
    sum = sum * r + 1.0 / 720.0, sum = sum * r + 1.0 / 120.0, sum = sum * r + 1.0 / 24.0;
    sum = sum * r + 1.0 / 6.0, sum = sum * r + 0.5, sum = sum * r + 1.0, sum = sum * r + 1.0;
    uint64_t bits;
    memcpy(&bits, &shifted, sizeof bits);
    bits = (bits << 52) + (UINT64_C(1023) << 52);
    memcpy(&power, &bits, sizeof power);
    return sum * power;
}

EVERYWHERE void fall(double *restrict exponent, ptrdiff_t n)
{
#pragma omp simd
    for (ptrdiff_t j = 0; j < n; j++)
        exponent[j] = falling(exponent[j]);
}
