/* What the compiled loops share: vector units, small numbers, exponentials, the geometry of directions. */
#pragma once

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Functions that are compiled twice, for processors with AVX2 and FMA and for any; which one is used is decided when
   they are loaded. PLAIN leaves the first one out, to try the other. */
#if defined(PLAIN)
#define VECTOR_UNITS
#elif defined(__GNUC__) && __GNUC__ >= 12 && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__)
#define VECTOR_UNITS __attribute__((target_clones("arch=x86-64-v3", "default")))
#elif defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__)
#define VECTOR_UNITS __attribute__((target_clones("fma", "default")))
#else
#define VECTOR_UNITS
#endif
#if defined(__GNUC__)
#define EVERYWHERE static inline __attribute__((always_inline))
#else
#define EVERYWHERE static inline
#endif

#if defined(_MSC_VER)
#define restrict __restrict
#endif

/* Added where a distance is divided by, so that points on an axis give 0 instead of NaN. */
#define TINY 1e-300

static inline double lesser(double a, double b) { return b < a ? b : a; }
static inline double greater(double a, double b) { return b > a ? b : a; }
static inline ptrdiff_t fewer(ptrdiff_t a, ptrdiff_t b) { return b < a ? b : a; }
static inline ptrdiff_t more(ptrdiff_t a, ptrdiff_t b) { return b > a ? b : a; }

static inline double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Two unit vectors that complete a unit vector to a right-handed frame, as fitting.geometry.vectors.basis. */
static inline void basis(const double *axis, double *u, double *v)
{
    double x = axis[0], y = axis[1], z = axis[2];
    double sign = z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (sign + z), b = x * y * a;
    u[0] = 1.0 + sign * x * x * a, u[1] = sign * b, u[2] = -sign * x;
    v[0] = b, v[1] = sign + y * y * a, v[2] = -y;
}

static inline void normalize(double *direction)
{
    double length = sqrt(dot(direction, direction));
    for (int k = 0; k < 3; k++)
        direction[k] /= length;
}

/* Turn a unit vector by tilts [rad] towards two others across it. */
static inline void tilt(double *axis, const double *u, const double *v, const double *tilts)
{
    double angle = hypot(tilts[0], tilts[1]);
    if (angle == 0.0)
        return;
    for (int k = 0; k < 3; k++)
        axis[k] = cos(angle) * axis[k] + sin(angle) / angle * (tilts[0] * u[k] + tilts[1] * v[k]);
    normalize(axis);
}

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
