/* Sums and extremes of distances. */
#pragma once

#include "geometry/median.h"

typedef struct {
    double squares, sum, largest; /* of the magnitudes */
    double lowest, highest;       /* with their signs */
    double near_squares;          /* of those that belong to the surface, */
    double near_lowest, near_highest;
    ptrdiff_t near; /* and how many these are */
} Figures;

/* Of n signed distances, whose magnitudes are left in `absolute`; those within reach by `judged` belong. */
VECTOR_UNITS static Figures figures_of(
    const double *restrict distance, const double *restrict judged, ptrdiff_t n, double reach, double *restrict absolute)
{
    double squares = 0.0, sum = 0.0, lowest = distance[0], highest = distance[0], near_squares = 0.0, near = 0.0;
    double near_lowest = INFINITY, near_highest = -INFINITY;
#pragma omp simd reduction(+ : squares, sum, near_squares, near) reduction(min : lowest, near_lowest) reduction(max : highest, near_highest)
    for (ptrdiff_t i = 0; i < n; i++) {
        const double each = distance[i], size = fabs(each), square = size * size;
        const double belongs = fabs(judged[i]) <= reach ? 1.0 : 0.0;
        const double low = belongs > 0.0 ? each : INFINITY, high = belongs > 0.0 ? each : -INFINITY;
        absolute[i] = size;
        squares += square;
        sum += size;
        near += belongs;
        near_squares += belongs * square;
        lowest = each < lowest ? each : lowest;
        highest = each > highest ? each : highest;
        near_lowest = low < near_lowest ? low : near_lowest;
        near_highest = high > near_highest ? high : near_highest;
    }
    return (Figures){squares, sum, greater(-lowest, highest), lowest, highest, near_squares,
                     near_lowest, near_highest, (ptrdiff_t)near};
}

/* As numpy.quantile, linear between ranks; reorders the values. */
static inline double quantile(double *values, ptrdiff_t n, double share)
{
    const double rank = share * (double)(n - 1);
    const ptrdiff_t below = (ptrdiff_t)rank;
    const double low = selected(values, n, below), part = rank - (double)below;
    if (below + 1 >= n)
        return low;
    double high = values[below + 1];
    for (ptrdiff_t i = below + 2; i < n; i++)
        high = lesser(high, values[i]);
    return part < 0.5 ? low + (high - low) * part : high - (high - low) * (1.0 - part);
}
