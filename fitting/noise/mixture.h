/* Distances as a mixture of noise and outliers. */
#pragma once

#include "geometry/vectors.h"

#define HALF_LOG_2_PI 0.91893853320467274178

/* Densities are multiplied so many at a time before their logarithm is taken: their products stay within a double. */
#define AT_ONCE 8
#define BLOCK (64 * AT_ONCE)

/* How many of the squared distances (n,), in ascending order, are noise, and its scale.

   `logs` (n,) are those of 1 to n. The k smallest have the most likely scale, and the outliers their share. */
static inline ptrdiff_t noise_among(
    const double *squared, ptrdiff_t n, const double *logs, double smallest, double width, double *scale)
{
    const double floor = smallest * smallest, log_smallest = log(smallest), log_width = log(width);
    double sum = 0.0, highest = -INFINITY;
    ptrdiff_t best = 0;
    for (ptrdiff_t k = 1; k <= n; k++) {
        sum += squared[k - 1];
        const double count = (double)k, others = (double)(n - k);
        const int resolved = sum > count * floor;
        const double log_scale = resolved ? 0.5 * (log(sum) - logs[k - 1]) : log_smallest;
        const double normal = resolved ? 0.5 * count : 0.5 * sum / floor;
        double found = count * (logs[k - 1] - logs[n - 1] - log_scale - HALF_LOG_2_PI) - normal;
        if (k < n)
            found += others * (logs[n - k - 1] - logs[n - 1] - log_width);
        if (found > highest) {
            highest = found;
            best = k;
            *scale = resolved ? sqrt(sum / count) : smallest;
        }
    }
    return best;
}

/* Sum of the logarithms of numbers (n,). */
static inline double sum_of_logs(const double *values, ptrdiff_t n)
{
    double sum = 0.0;
    for (ptrdiff_t i = 0; i < n; i += AT_ONCE) {
        double product = 1.0;
        for (ptrdiff_t j = i; j < (i + AT_ONCE < n ? i + AT_ONCE : n); j++)
            product *= values[j];
        sum += log(product);
    }
    return sum;
}

/* Densities (n,) in the place of squared distances: `peak` times the bell of the scale, and outliers' beside it. */
VECTOR_UNITS static void densities(double *restrict values, ptrdiff_t n, double scale, double peak, double outliers)
{
    const double slope = -0.5 / (scale * scale);
    for (ptrdiff_t i = 0; i < n; i++)
        values[i] = greater(slope * values[i], LOWEST);
    fall(values, n);
    for (ptrdiff_t i = 0; i < n; i++)
        values[i] = peak * values[i] + outliers;
}

/* Log-likelihood of squared distances (n,) that are noise of this scale but for a share of outliers. */
static inline double mixed_likelihood(const double *squared, ptrdiff_t n, double scale, double share, double width)
{
    double block[BLOCK], sum = 0.0;
    const double log_peak = log1p(-share) - log(scale) - HALF_LOG_2_PI;
    if (share == 0.0) {
        for (ptrdiff_t i = 0; i < n; i++)
            sum += squared[i];
        return (double)n * log_peak - 0.5 * sum / (scale * scale);
    }
    for (ptrdiff_t start = 0; start < n; start += BLOCK) {
        const ptrdiff_t count = n - start < BLOCK ? n - start : BLOCK;
        memcpy(block, squared + start, (size_t)count * sizeof *block);
        densities(block, count, scale, exp(log_peak), share / width);
        sum += sum_of_logs(block, count);
    }
    return sum;
}
