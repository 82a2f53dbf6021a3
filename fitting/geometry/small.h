/* Small systems and the sums over points that they come from: weighted least squares of columns, for vector units;
   Cholesky's factors, as rows of MOST numbers; eigenvectors in space. */
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

/* Eigenvalues (3), ascending, and unit eigenvectors, in rows, of a symmetric matrix (3, 3), which is used up. Jacobi's
   rotations find small ones to as many digits as they have. */
static inline void eigen(double *matrix, double *values, double *vectors)
{
    for (int k = 0; k < 9; k++)
        vectors[k] = k % 4 == 0;
    for (int sweep = 0; sweep < 20; sweep++) {
        int turned = 0;
        for (int p = 0; p < 2; p++)
            for (int q = p + 1; q < 3; q++) {
                const double off = matrix[3 * p + q], size = fabs(matrix[4 * p]) * fabs(matrix[4 * q]);
                if (!(off * off > 1e-32 * size) || off == 0.0)
                    continue;
                const double half = 0.5 * (matrix[4 * q] - matrix[4 * p]) / off;
                const double t = (half < 0.0 ? -1.0 : 1.0) / (fabs(half) + sqrt(1.0 + half * half));
                const double c = 1.0 / sqrt(1.0 + t * t), s = t * c;
                const int r = 3 - p - q;
                const double to_p = matrix[3 * r + p], to_q = matrix[3 * r + q];
                matrix[4 * p] -= t * off, matrix[4 * q] += t * off;
                matrix[3 * p + q] = matrix[3 * q + p] = 0.0;
                matrix[3 * r + p] = matrix[3 * p + r] = c * to_p - s * to_q;
                matrix[3 * r + q] = matrix[3 * q + r] = s * to_p + c * to_q;
                for (int k = 0; k < 3; k++) {
                    const double a = vectors[3 * p + k], b = vectors[3 * q + k];
                    vectors[3 * p + k] = c * a - s * b, vectors[3 * q + k] = s * a + c * b;
                }
                turned = 1;
            }
        if (!turned)
            break;
    }
    for (int k = 0; k < 3; k++)
        values[k] = matrix[4 * k];
    for (int pass = 0; pass < 2; pass++)
        for (int p = 0; p < 2 - pass; p++)
            if (values[p] > values[p + 1]) {
                const double value = values[p];
                values[p] = values[p + 1], values[p + 1] = value;
                for (int k = 0; k < 3; k++) {
                    const double swap = vectors[3 * p + k];
                    vectors[3 * p + k] = vectors[3 * (p + 1) + k], vectors[3 * (p + 1) + k] = swap;
                }
            }
}

/* The basic solution of least squares of columns (k, n), n at most MOST + 1 and k at most n, which are used up, as
   is the right side (n): by reflections, the longest column first. Columns whose rest is below `least`, over the
   longest, do not count. */
static inline void least_squares(double *columns, int n, int k, double *right, double least, double *solution)
{
    int order[MOST + 1], rank = 0;
    double first = 0.0;
    for (int j = 0; j < k; j++)
        order[j] = j, solution[j] = 0.0;
    for (int turn = 0; turn < k; turn++) {
        double longest = -1.0;
        int best = turn;
        for (int j = turn; j < k; j++) {
            double squares = 0.0;
            for (int i = turn; i < n; i++)
                squares += columns[order[j] * n + i] * columns[order[j] * n + i];
            if (squares > longest)
                longest = squares, best = j;
        }
        const double length = sqrt(longest);
        first = turn ? first : length;
        if (!(length > least * first))
            break;
        const int chosen = order[best];
        order[best] = order[turn], order[turn] = chosen;
        double *mirror = columns + chosen * n;
        const double head = mirror[turn] > 0.0 ? -length : length, scale = head * (head - mirror[turn]);
        mirror[turn] -= head;
        for (int j = turn + 1; j <= k; j++) {
            double *other = j < k ? columns + order[j] * n : right, along = 0.0;
            for (int i = turn; i < n; i++)
                along += mirror[i] * other[i];
            for (int i = turn; i < n; i++)
                other[i] -= along / scale * mirror[i];
        }
        mirror[turn] = head;
        rank++;
    }
    for (int turn = rank - 1; turn >= 0; turn--) {
        double total = right[turn];
        for (int j = turn + 1; j < rank; j++)
            total -= columns[order[j] * n + turn] * solution[order[j]];
        solution[order[turn]] = total / columns[order[turn] * n + turn];
    }
}

/* The factor L with L L^T = S^-1 N S^-1 of the lower triangle of N (n), S the roots of its diagonal (n); whether the
   smallest pivot is over `least`. */
static inline int factor(const double *normal, int n, double least, double *scales, double *lower)
{
    for (int i = 0; i < n; i++) {
        scales[i] = sqrt(normal[i * MOST + i]);
        if (!(scales[i] > 0.0) || !isfinite(scales[i]))
            return 0;
        for (int j = 0; j <= i; j++) {
            double total = normal[i * MOST + j] / (scales[i] * scales[j]);
            for (int k = 0; k < j; k++)
                total -= lower[i * MOST + k] * lower[j * MOST + k];
            if (i == j && !(total > least))
                return 0;
            lower[i * MOST + j] = i == j ? sqrt(total) : total / lower[j * MOST + j];
        }
    }
    return 1;
}

/* Sums of a b for each of four b: together they take hardly longer than one, which waits for each addition. */
EVERYWHERE void inner(const double *restrict a, const double *const b[4], ptrdiff_t n, double sum[4])
{
    const double *restrict first = b[0], *restrict second = b[1], *restrict third = b[2], *restrict fourth = b[3];
    double one = 0.0, two = 0.0, three = 0.0, four = 0.0;
#pragma omp simd reduction(+ : one, two, three, four)
    for (ptrdiff_t i = 0; i < n; i++) {
        one += a[i] * first[i];
        two += a[i] * second[i];
        three += a[i] * third[i];
        four += a[i] * fourth[i];
    }
    sum[0] = one, sum[1] = two, sum[2] = three, sum[3] = four;
}

/* J^T W J (lower triangle, rows of `width`) and J^T W d of columns J (m, n); the scratch holds n numbers. */
VECTOR_UNITS static void weighted_sums(const double *restrict weight, const double *restrict d,
                                       const double *restrict columns, ptrdiff_t n, int m, double *restrict scratch,
                                       double *normal, int width, double *gradient)
{
    for (int row = 0; row < m; row++) {
        const double *restrict mine = columns + row * n;
        for (ptrdiff_t i = 0; i < n; i++)
            scratch[i] = weight[i] * mine[i];
        for (int first = -1; first <= row; first += 4) {  /* the columns, and before them d */
            const double *beside[4];
            double sum[4];
            for (int k = 0; k < 4; k++)
                beside[k] = first + k < 0 ? d : columns + (first + k < row ? first + k : row) * n;
            inner(scratch, beside, n, sum);
            for (int k = 0; k < 4 && first + k <= row; k++)
                *(first + k < 0 ? gradient + row : normal + row * width + first + k) = sum[k];
        }
    }
}

/* The sum of columns (m, n) times these factors (m), less the target (n). */
VECTOR_UNITS static void remainder_of(const double *restrict columns, const double *restrict target, ptrdiff_t n,
                                      int m, const double *factors, double *restrict rest)
{
    for (ptrdiff_t i = 0; i < n; i++)
        rest[i] = -target[i];
    for (int k = 0; k < m; k++) {
        const double *restrict column = columns + k * n;
        const double factor = factors[k];
        for (ptrdiff_t i = 0; i < n; i++)
            rest[i] += factor * column[i];
    }
}

/* Weights 1 / (1 + (rest / middle)^2). */
VECTOR_UNITS static void down_weigh(const double *restrict rest, ptrdiff_t n, double middle, double *restrict weight)
{
    const double unit = 1.0 / middle;
    for (ptrdiff_t i = 0; i < n; i++)
        weight[i] = 1.0 / (1.0 + rest[i] * unit * (rest[i] * unit));
}

/* Heights h and distances rho (n) of points from an axis through a foot. */
VECTOR_UNITS static void profile(const double *restrict x, const double *restrict y, const double *restrict z,
                                 ptrdiff_t n, const double *axis, const double *foot, double *restrict h,
                                 double *restrict rho)
{
    const double ax = axis[0], ay = axis[1], az = axis[2], fx = foot[0], fy = foot[1], fz = foot[2];
    for (ptrdiff_t i = 0; i < n; i++) {
        const double px = x[i] - fx, py = y[i] - fy, pz = z[i] - fz;
        const double height = px * ax + py * ay + pz * az;
        const double qx = px - height * ax, qy = py - height * ay, qz = pz - height * az;
        h[i] = height;
        rho[i] = sqrt(qx * qx + qy * qy + qz * qz);
    }
}
