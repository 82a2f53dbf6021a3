/* What a squared residual, in squared scales, costs, and the weight rho'(x) / x; see fitting/noise/kernels.py. */
#pragma once

#include "geometry/vectors.h"

/* Scales beyond which Tukey's biweight sees nothing. */
#define CUTOFF 6.0

enum { LEAST_SQUARES, GEMAN_MCCLURE, TUKEY, HUBER };

EVERYWHERE double rho_of(int kernel, double squared)
{
    const double inside = 1.0 - squared / (CUTOFF * CUTOFF), positive = inside > 0.0 ? inside : 0.0;
    if (kernel == GEMAN_MCCLURE)
        return 0.5 * squared / (1.0 + squared);
    if (kernel == TUKEY)
        return CUTOFF * CUTOFF / 6.0 * (1.0 - positive * positive * positive);
    if (kernel == HUBER)
        return squared <= 1.0 ? 0.5 * squared : sqrt(squared) - 0.5;
    return 0.5 * squared;
}

EVERYWHERE double weight_of(int kernel, double squared)
{
    const double inside = 1.0 - squared / (CUTOFF * CUTOFF), positive = inside > 0.0 ? inside : 0.0;
    if (kernel == GEMAN_MCCLURE)
        return 1.0 / ((1.0 + squared) * (1.0 + squared));
    if (kernel == TUKEY)
        return positive * positive;
    if (kernel == HUBER)
        return squared <= 1.0 ? 1.0 : 1.0 / sqrt(squared);
    return 1.0;
}

/* rho''(x): what the pull of a residual grows by. */
EVERYWHERE double slope_of(int kernel, double squared)
{
    const double share = squared / (CUTOFF * CUTOFF), wider = 1.0 + squared;
    if (kernel == GEMAN_MCCLURE)
        return (1.0 - 3.0 * squared) / (wider * wider * wider);
    if (kernel == TUKEY)
        return share < 1.0 ? (1.0 - share) * (1.0 - 5.0 * share) : 0.0;
    if (kernel == HUBER)
        return squared <= 1.0 ? 1.0 : 0.0;
    return 1.0;
}

EVERYWHERE double sum_of_costs(int kernel, double inverse, const double *restrict d, ptrdiff_t n)
{
    double total = 0.0;
#pragma omp simd reduction(+ : total)
    for (ptrdiff_t i = 0; i < n; i++)
        total += rho_of(kernel, d[i] * inverse * (d[i] * inverse));
    return total;
}

EVERYWHERE void weights_of(int kernel, double inverse, const double *restrict d, ptrdiff_t n, double *restrict weight)
{
    for (ptrdiff_t i = 0; i < n; i++)
        weight[i] = weight_of(kernel, d[i] * inverse * (d[i] * inverse));
}

/* Sum of rho(d / scale). */
VECTOR_UNITS static double cost_of(int kernel, double scale, const double *d, ptrdiff_t n)
{
    if (kernel == GEMAN_MCCLURE)
        return sum_of_costs(GEMAN_MCCLURE, 1.0 / scale, d, n);
    if (kernel == TUKEY)
        return sum_of_costs(TUKEY, 1.0 / scale, d, n);
    if (kernel == HUBER)
        return sum_of_costs(HUBER, 1.0 / scale, d, n);
    return sum_of_costs(LEAST_SQUARES, 1.0 / scale, d, n);
}

VECTOR_UNITS static void weigh(int kernel, double scale, const double *d, ptrdiff_t n, double *weight)
{
    if (kernel == GEMAN_MCCLURE)
        weights_of(GEMAN_MCCLURE, 1.0 / scale, d, n, weight);
    else if (kernel == TUKEY)
        weights_of(TUKEY, 1.0 / scale, d, n, weight);
    else if (kernel == HUBER)
        weights_of(HUBER, 1.0 / scale, d, n, weight);
    else
        weights_of(LEAST_SQUARES, 1.0 / scale, d, n, weight);
}
