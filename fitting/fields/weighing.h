/* How well white noise and fields explain the residuals of patches, and what they make of them. */
#pragma once

#include <float.h>

#include "fields/bells.h"
#include "fields/small.h"

#define LOG_2_PI 1.8378770664093454836

/* Factors of so many pivots are taken the logarithm of at once; they are no smaller than those of a point. */
#define TOGETHER 16

/* Residuals of n patches, and the parameters that may have a share in them. */
typedef struct {
    ptrdiff_t n;
    int dof;
    const double *mean;     /* (n,) residuals */
    const double *count;    /* (n,) points */
    const double *whitened; /* (dof, n) what steps move, orthogonal columns of length root n */
    double scatter;         /* standard deviation within grains, */
    double spare;           /* how many such deviations are free */
    double prior;           /* variance by which a step may move the surface */
    double least;           /* the smallest noise that is told from none */
} Patches;

/* The two fields of an explanation: sizes over the white noise, 0 for none, and correlations (m, m). */
typedef struct {
    double size[2];
    const double *bell[2];
} Fields;

/* What is made of them: `Explanations` has the words. */
typedef struct {
    double evidence, white, rough, smooth;
} Weighed;

/* Rows for `eliminate`: the covariance over the white variance of a point, residuals and steps beside it. */
VECTOR_UNITS static void lay_out(const Patches *p, const Fields *f, ptrdiff_t m, ptrdiff_t width, double *rows)
{
    const double rough = f->size[0] * f->size[0], smooth = f->size[1] * f->size[1];
    for (ptrdiff_t i = 0; i < m; i++) {
        double *restrict row = rows + i * width;
        const ptrdiff_t start = i / PANEL * PANEL, length = (m - start) / PANEL * PANEL;
        const double *restrict one = f->bell[0] + i * m + start, *restrict two = f->bell[1] + i * m + start;
#pragma omp simd
        for (ptrdiff_t j = 0; j < length; j++)
            row[start + j] = rough * one[j] + smooth * two[j];
        row[i] += i < p->n ? 1.0 / p->count[i] : 1.0;
        for (ptrdiff_t j = m; j < width; j++)
            row[j] = 0.0;
        if (i >= p->n)
            continue;
        row[m] = p->mean[i];
        for (int k = 0; k < p->dof; k++)
            row[m + 1 + k] = p->whitened[k * p->n + i];
    }
    memset(rows + m * width, 0, (size_t)((width - m) * width) * sizeof *rows);
}

/* Half the logarithm of the determinant of a covariance, from the diagonal (m,) of its factor. */
static inline double root_of(const double *rows, ptrdiff_t m, ptrdiff_t width)
{
    double sum = 0.0, product = 1.0;
    for (ptrdiff_t i = 0; i < m; i++) {
        product *= rows[i * width + i];
        if (i % TOGETHER == TOGETHER - 1 || i == m - 1) {
            sum += log(product);
            product = 1.0;
        }
    }
    return sum;
}

/* The matrix (dof, dof) of the normal equations of the steps, and their right side, from what is eliminated. */
static inline void normal_of(
    const double *rows, ptrdiff_t m, ptrdiff_t width, int dof, double *normal, double *right)
{
    for (int k = 0; k < dof; k++) {
        right[k] = -rows[m * width + m + 1 + k];
        for (int l = 0; l <= k; l++)
            normal[k * dof + l] = normal[l * dof + k] = -rows[(m + 1 + l) * width + m + 1 + k];
    }
}

/* The lower factor of the normal matrix with so little more on its diagonal that it has one. */
static inline void damped(const double *normal, int dof, double *lower)
{
    double matrix[MOST * MOST], trace = 0.0;
    memcpy(matrix, normal, (size_t)(dof * dof) * sizeof *normal);
    for (int k = 0; k < dof; k++)
        trace += normal[k * dof + k];
    for (int k = 0; k < dof; k++)
        matrix[k * dof + k] += DBL_EPSILON * trace;
    factor(matrix, dof, greater(DBL_EPSILON * trace, TINY), lower);
}

/* Root mean square of a course (n,) beside what steps take of it, which are taken off it. */
EVERYWHERE double seen(const Patches *p, double *restrict course)
{
    for (int k = 0; k < p->dof; k++) {
        const double *restrict column = p->whitened + k * p->n;
        const double share = inner(course, column, p->n) / (double)p->n;
#pragma omp simd
        for (ptrdiff_t i = 0; i < p->n; i++)
            course[i] -= share * column[i];
    }
    return sqrt(inner(course, course, p->n) / (double)p->n);
}

/* The most likely courses of the fields, and how large they are.

   What is left of residuals (n,) after a step is the sum of both and of the white noise; solved by the covariance
   it is `weights` (n,), of which each part makes its own. */
VECTOR_UNITS static void see(
    const Patches *p, const Fields *f, ptrdiff_t m, const double *rest, const double *weights, double *course,
    Weighed *found)
{
    const int rough = f->size[0] > 0.0, smooth = f->size[1] > 0.0;
    double *restrict other = course + m;
    for (ptrdiff_t i = 0; i < p->n; i++)
        other[i] = rest[i] - weights[i] / p->count[i];
    if (rough && smooth) {
        const double square = f->size[1] * f->size[1];
        for (ptrdiff_t i = 0; i < p->n; i++) {
            course[i] = square * inner(f->bell[1] + i * m, weights, p->n);
            other[i] -= course[i];
        }
        found->smooth = seen(p, course);
        found->rough = seen(p, other);
    } else {
        found->smooth = smooth ? seen(p, other) : 0.0;
        found->rough = rough ? seen(p, other) : 0.0;
    }
}

/* Residuals less a step: solved by the factor's half they are in column m of the rows, as they are in the patches. */
VECTOR_UNITS static void take_step(
    const Patches *p, const double *rows, ptrdiff_t m, ptrdiff_t width, const double *step, double *half, double *rest)
{
    for (ptrdiff_t i = 0; i < m; i++) {
        half[i] = rows[i * width + m];
        for (int k = 0; k < p->dof; k++)
            half[i] -= rows[i * width + m + 1 + k] * step[k];
    }
    memcpy(rest, p->mean, (size_t)p->n * sizeof *rest);
    for (int k = 0; k < p->dof; k++)
        for (ptrdiff_t i = 0; i < p->n; i++)
            rest[i] -= step[k] * p->whitened[k * p->n + i];
}

/* How well two fields explain the residuals, and what they make of them; the normal matrix (dof, dof) of the steps
   over the white variance. The room is for rows (width, width) and 4 m numbers. */
static inline Weighed weigh(
    const Patches *p, const Fields *f, ptrdiff_t m, ptrdiff_t width, double *room, double *normal)
{
    double lower[MOST * MOST], step[MOST] = {0.0};
    double *rows = room, *half = rows + width * width, *rest = half + m, *course = rest + m;
    const double free_ = (double)p->n + p->spare, within = p->spare * p->scatter * p->scatter;
    Weighed found = {-INFINITY, 0.0, 0.0, 0.0};
    lay_out(p, f, m, width, rows);
    const int positive = eliminate(rows, m, width);
    double left = within;
    if (positive) {
        normal_of(rows, m, width, p->dof, normal, step);
        damped(normal, p->dof, lower);
        forwards(lower, p->dof, step);
        backwards(lower, p->dof, step);
        take_step(p, rows, m, width, step, half, rest);
        left += inner(half, half, m);
    }
    const double variance = greater(left / greater(free_ - p->dof, 1.0), p->least * p->least);
    found.white = sqrt(variance);
    if (!positive)
        return found;
    const double occam = log_of_more(normal, p->dof, p->prior / variance);
    found.evidence = -0.5 * (free_ * (LOG_2_PI + log(variance)) + left / variance + occam) - root_of(rows, m, width);
    substitute(rows, m, width, half);
    see(p, f, m, rest, half, course, &found);
    return found;
}

/* Evidence and size, as of a point, of white noise that the means of patches have to themselves.

   So it is where noise is correlated within patches only. The variances of the means and within patches are two
   numbers for one, which costs half the logarithm of how often the second is seen. The room is for n numbers. */
static inline double weigh_apart(const Patches *p, double *rest, double *white)
{
    double normal[MOST * MOST], lower[MOST * MOST], step[MOST];
    const double many = (double)p->n, dof = p->dof;
    double left = 0.0, roots = 0.0;
    *white = 0.0;
    if (p->spare == 0.0 || p->scatter == 0.0)
        return -INFINITY;
    for (int k = 0; k < p->dof; k++) {
        for (ptrdiff_t i = 0; i < p->n; i++)
            rest[i] = p->count[i] * p->whitened[k * p->n + i];
        step[k] = inner(rest, p->mean, p->n);
        for (int l = 0; l <= k; l++)
            normal[k * p->dof + l] = normal[l * p->dof + k] = inner(rest, p->whitened + l * p->n, p->n);
    }
    damped(normal, p->dof, lower);
    forwards(lower, p->dof, step);
    backwards(lower, p->dof, step);
    for (ptrdiff_t i = 0; i < p->n; i++) {
        double mean = p->mean[i];
        for (int k = 0; k < p->dof; k++)
            mean -= step[k] * p->whitened[k * p->n + i];
        left += p->count[i] * mean * mean;
        roots += 0.5 * log(p->count[i]);
    }
    const double variance = greater(left / (many - dof), p->least * p->least);
    const double occam = log_of_more(normal, p->dof, p->prior / variance);
    const double means = -0.5 * ((many - dof) * (LOG_2_PI + 1.0 + log(variance)) + dof * (LOG_2_PI + log(variance)) + occam);
    const double within = -0.5 * p->spare * (LOG_2_PI + 1.0 + 2.0 * log(greater(p->scatter, p->least)));
    *white = sqrt(variance);
    return means + within + roots - 0.5 * log(p->spare);
}

/* Columns (dof, n) that move the surface by 1 in the mean square, each by itself, from the derivatives (n, dof);
   and the directions (dof, dof) of the steps that do, in columns. */
static inline void whiten(const double *jacobian, ptrdiff_t n, int dof, double *columns, double *directions)
{
    double turned[MOST * MOST], sizes[MOST], largest = 0.0;
    for (int k = 0; k < dof; k++)
        for (ptrdiff_t i = 0; i < n; i++)
            columns[k * n + i] = jacobian[i * dof + k];
    turn_apart(columns, dof, n, turned, sizes);
    for (int k = 0; k < dof; k++) {
        sizes[k] /= sqrt((double)n);
        largest = greater(largest, sizes[k]);
    }
    for (int k = 0; k < dof; k++) {
        const double size = greater(sizes[k], DBL_EPSILON * greater(largest, TINY));
        for (ptrdiff_t i = 0; i < n; i++)
            columns[k * n + i] /= size;
        for (int l = 0; l < dof; l++)
            directions[l * dof + k] = turned[k * dof + l] / size;
    }
}

/* Standard deviations (dof,) of the parameters, from the normal matrix of whitened steps over the white variance. */
static inline void spread_of(
    const double *normal, int dof, const double *directions, double white, double *spread)
{
    double lower[MOST * MOST], row[MOST];
    damped(normal, dof, lower);
    for (int l = 0; l < dof; l++) {
        double square = 0.0;
        memcpy(row, directions + l * dof, (size_t)dof * sizeof *row);
        forwards(lower, dof, row);
        for (int k = 0; k < dof; k++)
            square += row[k] * row[k];
        spread[l] = white * sqrt(square);
    }
}
