/* Small symmetric systems by Cholesky, as rows of MOST numbers. */
#pragma once

#include "geometry/surface.h"

/* Solve (N + damping S^2) step = -gradient in units of the scales S; whether that went well. */
static inline int solve(
    const double *normal, const double *gradient, const double *scales, double damping, int dof, double *step)
{
    double lower[MOST * MOST];
    for (int i = 0; i < dof; i++)
        for (int j = 0; j <= i; j++) {
            double total = normal[i * MOST + j] / (scales[i] * scales[j]);
            if (i == j)
                total += damping;
            for (int k = 0; k < j; k++)
                total -= lower[i * MOST + k] * lower[j * MOST + k];
            if (i != j)
                lower[i * MOST + j] = total / lower[j * MOST + j];
            else if (total > 0.0)
                lower[i * MOST + i] = sqrt(total);
            else
                return 0;
        }
    for (int i = 0; i < dof; i++) {
        double total = -gradient[i] / scales[i];
        for (int k = 0; k < i; k++)
            total -= lower[i * MOST + k] * step[k];
        step[i] = total / lower[i * MOST + i];
    }
    for (int i = dof - 1; i >= 0; i--) {
        double total = step[i];
        for (int k = i + 1; k < dof; k++)
            total -= lower[k * MOST + i] * step[k];
        step[i] = total / lower[i * MOST + i];
    }
    for (int i = 0; i < dof; i++) {
        step[i] /= scales[i];
        if (!isfinite(step[i]))
            return 0;
    }
    return 1;
}
