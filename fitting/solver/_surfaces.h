/* The loops over points of fitting/_descent.pyx: distances, their derivatives, kernels, sums.

   Points come as three arrays x, y, z; derivatives leave as one array of n a component. The loops are written
   for vector units. A sum is taken in as many parts as the unit has lanes: its last bits depend on the machine,
   not on the run. */

#include <math.h>
#include <stddef.h>

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__gnu_linux__)
#define VECTOR_UNITS __attribute__((target_clones("avx2", "default")))
#else
#define VECTOR_UNITS
#endif
#if defined(__GNUC__)
#define EVERYWHERE static inline __attribute__((always_inline))
#else
#define EVERYWHERE static inline
#endif

/* Added where a distance is divided by, so that points on an axis give 0 instead of NaN. */
#define TINY 1e-300
/* Scales beyond which Tukey's biweight sees nothing. */
#define CUTOFF 6.0

enum { PLANE, SPHERE, CYLINDER, CONE, TORUS };
enum { LEAST_SQUARES, GEMAN_MCCLURE, TUKEY, HUBER };

/* The row of a surface; the table in fitting/_descent.pyx says what it holds. */
typedef struct {
    int kind;
    double axis[3];
    double anchor[3];
    double angle, major, offset;
} Surface;

/* Degrees of freedom of each kind. */
static const int DOF[] = {3, 4, 5, 6, 7};

/* Coordinates, and what the distance of each point is multiplied by; that pointer may be null. */
typedef struct {
    const double *restrict x, *restrict y, *restrict z;
    ptrdiff_t n;
    const double *restrict factor;
} Points;

/* Two unit vectors that complete a unit vector to a right-handed frame, as fitting.geometry.vectors.basis. */
static void basis(const double *axis, double *u, double *v)
{
    double x = axis[0], y = axis[1], z = axis[2];
    double sign = z >= 0.0 ? 1.0 : -1.0, a = -1.0 / (sign + z), b = x * y * a;
    u[0] = 1.0 + sign * x * x * a, u[1] = sign * b, u[2] = -sign * x;
    v[0] = b, v[1] = sign + y * y * a, v[2] = -y;
}

/* Distances d (n) and, where wanted, derivatives j (dof, n). */
EVERYWHERE void surface(const Surface *s, Points points, double *restrict d, double *restrict j, int kind, int wanted)
{
    const double *restrict px = points.x, *restrict py = points.y, *restrict pz = points.z;
    const ptrdiff_t n = points.n;
    const double ax = s->axis[0], ay = s->axis[1], az = s->axis[2];
    const double cx = s->anchor[0], cy = s->anchor[1], cz = s->anchor[2];
    const double sine = sin(s->angle), cosine = cos(s->angle), major = s->major, offset = s->offset;
    const double apex = kind == CONE ? -offset / sine : 0.0;
    double u[3], v[3], behind = 0.0;
    basis(s->axis, u, v);
    for (ptrdiff_t i = 0; i < n; i++) {
        const double x = px[i] - cx, y = py[i] - cy, z = pz[i] - cz;
        if (kind == PLANE) {
            d[i] = x * ax + y * ay + z * az;
            if (wanted) {
                j[i] = px[i] * u[0] + py[i] * u[1] + pz[i] * u[2];
                j[n + i] = px[i] * v[0] + py[i] * v[1] + pz[i] * v[2];
                j[2 * n + i] = -1.0;
            }
            continue;
        }
        if (kind == SPHERE) {
            const double length = sqrt(x * x + y * y + z * z), inverse = -1.0 / (length + TINY);
            d[i] = length - offset;
            if (wanted)
                j[i] = x * inverse, j[n + i] = y * inverse, j[2 * n + i] = z * inverse, j[3 * n + i] = -1.0;
            continue;
        }
        const double h = x * ax + y * ay + z * az;
        const double qx = x - h * ax, qy = y - h * ay, qz = z - h * az;
        const double rho = sqrt(qx * qx + qy * qy + qz * qz), inverse = 1.0 / (rho + TINY);
        const double qu = (qx * u[0] + qy * u[1] + qz * u[2]) * inverse;
        const double qv = (qx * v[0] + qy * v[1] + qz * v[2]) * inverse;
        if (kind == CYLINDER) {
            d[i] = rho - offset;
            if (wanted) {
                j[i] = -h * qu, j[n + i] = -h * qv;
                j[2 * n + i] = -qu, j[3 * n + i] = -qv, j[4 * n + i] = -1.0;
            }
        }
        if (kind == CONE) {
            const double side = (h - apex) * cosine + rho * sine;
            behind = side < behind ? side : behind;
            d[i] = rho * cosine - h * sine - offset;
            if (wanted) {
                const double lean = -h * cosine - rho * sine;
                j[i] = qu * lean, j[n + i] = qv * lean;
                j[2 * n + i] = -qu * cosine, j[3 * n + i] = -qv * cosine;
                j[4 * n + i] = -rho * sine - h * cosine, j[5 * n + i] = -1.0;
            }
        }
        if (kind == TORUS) {
            const double across = rho - major, length = sqrt(across * across + h * h);
            d[i] = length - offset;
            if (wanted) {
                const double scale = 1.0 / (length + TINY), g_rho = across * scale, g_height = h * scale;
                const double lean = g_height * rho - h * g_rho;
                j[i] = qu * lean, j[n + i] = qv * lean, j[2 * n + i] = -qu * g_rho, j[3 * n + i] = -qv * g_rho;
                j[4 * n + i] = -g_height, j[5 * n + i] = -g_rho, j[6 * n + i] = -1.0;
            }
        }
    }
    if (kind != CONE || behind == 0.0)
        return;
    for (ptrdiff_t i = 0; i < n; i++) {  /* the points that have the apex for their closest point */
        const double x = px[i] - cx, y = py[i] - cy, z = pz[i] - cz;
        const double h = x * ax + y * ay + z * az;
        const double qx = x - h * ax, qy = y - h * ay, qz = z - h * az;
        const double rho = sqrt(qx * qx + qy * qy + qz * qz);
        if ((h - apex) * cosine + rho * sine >= 0.0)
            continue;
        const double length = sqrt(rho * rho + (h - apex) * (h - apex)), inverse = -1.0 / (length + TINY);
        d[i] = length;
        if (wanted) {
            const double wa = (h - apex) * inverse;
            const double wu = (qx * u[0] + qy * u[1] + qz * u[2]) * inverse;
            const double wv = (qx * v[0] + qy * v[1] + qz * v[2]) * inverse;
            j[i] = apex * wu, j[n + i] = apex * wv, j[2 * n + i] = wu, j[3 * n + i] = wv;
            j[4 * n + i] = -wa * apex * cosine / sine, j[5 * n + i] = -wa / sine;
        }
    }
}

#define OF_KIND(NAME, KIND) \
    VECTOR_UNITS static void NAME(const Surface *s, Points points, double *d) { surface(s, points, d, NULL, KIND, 0); } \
    VECTOR_UNITS static void NAME##_slopes(const Surface *s, Points points, double *d, double *j) { surface(s, points, d, j, KIND, 1); }
OF_KIND(plane, PLANE)
OF_KIND(sphere, SPHERE)
OF_KIND(cylinder, CYLINDER)
OF_KIND(cone, CONE)
OF_KIND(torus, TORUS)

static void multiply(double *restrict values, const double *restrict factor, ptrdiff_t n)
{
    for (ptrdiff_t i = 0; i < n; i++)
        values[i] *= factor[i];
}

/* Distances d (n) and, unless that pointer is null, derivatives j (dof, n); both times the factors. */
static void linearize(const Surface *s, Points points, double *d, double *j)
{
    static void (*const plain[])(const Surface *, Points, double *) = {plane, sphere, cylinder, cone, torus};
    static void (*const sloped[])(const Surface *, Points, double *, double *) = {
        plane_slopes, sphere_slopes, cylinder_slopes, cone_slopes, torus_slopes};
    if (j)
        sloped[s->kind](s, points, d, j);
    else
        plain[s->kind](s, points, d);
    if (!points.factor)
        return;
    multiply(d, points.factor, points.n);
    for (int row = 0; j && row < DOF[s->kind]; row++)
        multiply(j + row * points.n, points.factor, points.n);
}

/* What a squared residual, in squared scales, costs, and the weight rho'(x) / x; see fitting/noise/kernels.py. */
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

/* Sums of a b for each of four b: together they take hardly longer than one, which waits for each addition. */
VECTOR_UNITS static void inner(const double *restrict a, const double *const b[4], ptrdiff_t n, double sum[4])
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

/* J^T W J (lower triangle, rows of `width`) and J^T W d; the scratch holds 2 n numbers. */
VECTOR_UNITS static void normal_equations(int kernel, double scale, const double *restrict d, const double *restrict j,
                                          ptrdiff_t n, int dof, double *restrict scratch, double *normal,
                                          int width, double *gradient)
{
    double *restrict weight = scratch, *restrict weighted = scratch + n;
    weigh(kernel, scale, d, n, weight);
    for (int row = 0; row < dof; row++) {
        const double *restrict slopes = j + row * n;
        for (ptrdiff_t i = 0; i < n; i++)
            weighted[i] = weight[i] * slopes[i];
        for (int first = -1; first <= row; first += 4) {  /* the derivatives, and before them the distances */
            const double *beside[4];
            double sum[4];
            for (int k = 0; k < 4; k++)
                beside[k] = first + k < 0 ? d : j + (first + k < row ? first + k : row) * n;
            inner(weighted, beside, n, sum);
            for (int k = 0; k < 4 && first + k <= row; k++)
                *(first + k < 0 ? gradient + row : normal + row * width + first + k) = sum[k];
        }
    }
}
