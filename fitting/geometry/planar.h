/* Points in a plane: their convex hull, the rectangle of least area about it, their Delaunay triangulation. Points are
   pairs of coordinates, different ones sorted by the first, and by the second where that is the same. */
#pragma once

#include <stdint.h>
#include <string.h>

#include "geometry/vectors.h"

/* The largest errors of two determinants, over the sums of the magnitudes of their terms: bounds of J. R. Shewchuk,
   "Adaptive precision floating-point arithmetic and fast robust geometric predicates", Discrete & Computational Geometry
   18, 1997. */
#define SIDE_ERROR 3.3306690738754716e-16
#define CIRCLE_ERROR 1.1102230246251577e-15

/* The sign of (a - c) x (b - c) by the exact sum of its six products. */
static double exact_side(const double *a, const double *b, const double *c)
{
    const double factors[6][2] = {{a[0], b[1]}, {-a[0], c[1]}, {-c[0], b[1]}, {-a[1], b[0]}, {a[1], c[0]}, {c[1], b[0]}};
    double sum[12] = {0.0};
    for (int k = 0; k < 6; k++) {
        const double product = factors[k][0] * factors[k][1];
        double parts[2] = {fma(factors[k][0], factors[k][1], -product), product};
        for (int part = 0; part < 2; part++) {
            double rest = parts[part];
            for (int i = 0; i < 2 * k + part; i++) {
                const double total = rest + sum[i], shown = total - rest;
                sum[i] = (rest - (total - shown)) + (sum[i] - shown);
                rest = total;
            }
            sum[2 * k + part] = rest;
        }
    }
    for (int i = 11; i >= 0; i--)
        if (sum[i] != 0.0)
            return sum[i];
    return 0.0;
}

/* Positive where c lies to the left of the line from a to b, 0 on it. */
static inline double side_of(const double *a, const double *b, const double *c)
{
    const double left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]);
    const double found = left - right;
    return fabs(found) > SIDE_ERROR * (fabs(left) + fabs(right)) ? found : exact_side(a, b, c);
}

/* Whether d lies within the circle about the counter-clockwise triangle a, b, c, by more than rounding. */
static inline int within_circle(const double *a, const double *b, const double *c, const double *d)
{
    const double ax = a[0] - d[0], ay = a[1] - d[1], bx = b[0] - d[0], by = b[1] - d[1];
    const double cx = c[0] - d[0], cy = c[1] - d[1];
    const double bc = bx * cy, cb = cx * by, ca = cx * ay, ac = ax * cy, ab = ax * by, ba = bx * ay;
    const double aa = ax * ax + ay * ay, bb = bx * bx + by * by, cc = cx * cx + cy * cy;
    const double found = aa * (bc - cb) + bb * (ca - ac) + cc * (ab - ba);
    const double most = aa * (fabs(bc) + fabs(cb)) + bb * (fabs(ca) + fabs(ac)) + cc * (fabs(ab) + fabs(ba));
    return found > CIRCLE_ERROR * most;
}

/* Corners of the convex outline by less than this share of the largest coordinate are none, but rounding. */
#define STRAIGHT 4e-15

/* Whether b lies on the way from a to c, or beside it by rounding only. */
static inline int is_straight(const double *p, ptrdiff_t a, ptrdiff_t b, ptrdiff_t c, double slack)
{
    const double x = p[2 * c] - p[2 * a], y = p[2 * c + 1] - p[2 * a + 1];
    const double to_x = p[2 * b] - p[2 * a], to_y = p[2 * b + 1] - p[2 * a + 1];
    const double chord = x * x + y * y, along = to_x * x + to_y * y, beside = to_x * y - to_y * x;
    return beside * beside <= slack * slack * chord && along > 0.0 && along < chord;
}

/* The corners of the convex hull, counter-clockwise; how many they are, under 3 where all points are on one line.

   By A. M. Andrew, "Another efficient algorithm for convex hulls in two dimensions", Information Processing Letters 9(5),
   1979. The corners are room for n + 2. */
static ptrdiff_t hull_of(const double *p, ptrdiff_t n, ptrdiff_t *corners)
{
    double largest = 0.0;
    for (ptrdiff_t i = 0; i < 2 * n; i++)
        largest = greater(largest, fabs(p[i]));
    const double slack = STRAIGHT * largest;
    ptrdiff_t k = 0, first = 2, count = 0;
    for (ptrdiff_t i = 0; i < 2 * n - 1; i++) {  /* along the lower side, and back along the upper one */
        const ptrdiff_t next = i < n ? i : 2 * n - 2 - i;
        first = i == n ? k + 1 : first;
        while (k >= first && side_of(p + 2 * corners[k - 2], p + 2 * corners[k - 1], p + 2 * next) <= 0.0)
            k--;
        corners[k++] = next;
    }
    k--;  /* the first point once more */
    for (ptrdiff_t i = 0; i < k; i++) {
        while (count >= 2 && is_straight(p, corners[count - 2], corners[count - 1], corners[i], slack))
            count--;
        corners[count++] = corners[i];
    }
    while (count >= 3 && is_straight(p, corners[count - 2], corners[count - 1], corners[0], slack))
        count--;
    if (count >= 3 && is_straight(p, corners[count - 1], corners[0], corners[1], slack))
        memmove(corners, corners + 1, --count * sizeof *corners);
    return count;
}

/* Twice the area, to the left of a ring of places. */
static double twice_area(const double *ring, ptrdiff_t n)
{
    double sum = 0.0;
    for (ptrdiff_t i = 1; i + 1 < n; i++)
        sum += (ring[2 * i] - ring[0]) * (ring[2 * i + 3] - ring[1]) - (ring[2 * i + 1] - ring[1]) * (ring[2 * i + 2] - ring[0]);
    return sum;
}

/* Rectangles whose areas differ by less than this share are as good as each other. */
#define AS_GOOD 1e-12

/* A rectangle: its longer side along (cosine, sine), its middle as seen along its sides, its sizes. */
typedef struct {
    double along[2], across[2], middle[2], size[2];
} Rectangle;

/* That of least area about a convex ring; it lies along an edge.

   Its other sides touch the corners that are farthest in their directions, which go round as the edge does (Toussaint,
   "Solving geometric problems with the rotating calipers", MELECON 1983). */
static Rectangle rectangle_about(const double *ring, ptrdiff_t n)
{
    Rectangle best = {{1.0, 0.0}, {0.0, 1.0}, {0.0, 0.0}, {0.0, 0.0}};
    double least = INFINITY;
    ptrdiff_t touching[3] = {1, 1, 1};  /* the farthest along the edge, across it, and back */
    for (ptrdiff_t i = 0; i < n; i++) {
        const double *corner = ring + 2 * i, *next = ring + 2 * ((i + 1) % n);
        const double x = next[0] - corner[0], y = next[1] - corner[1], length = sqrt(x * x + y * y);
        const double along[2] = {x / length, y / length}, across[2] = {-along[1], along[0]};
        const double ways[3][2] = {{along[0], along[1]}, {across[0], across[1]}, {-along[0], -along[1]}};
        double reached[3];
        for (int k = 0; k < 3; k++) {
            touching[k] = more(touching[k], k == 0 ? i + 1 : touching[k - 1]);
            for (ptrdiff_t j = touching[k];; j++) {
                const double *here = ring + 2 * (j % n), *there = ring + 2 * ((j + 1) % n);
                touching[k] = j;
                if (there[0] * ways[k][0] + there[1] * ways[k][1] <= here[0] * ways[k][0] + here[1] * ways[k][1] || j > i + n)
                    break;
            }
            const double *at = ring + 2 * (touching[k] % n);
            reached[k] = at[0] * ways[k][0] + at[1] * ways[k][1];
        }
        const double low[2] = {-reached[2], corner[0] * across[0] + corner[1] * across[1]};
        const double size[2] = {reached[0] - low[0], reached[1] - low[1]};
        if (!(size[0] * size[1] < (1.0 - AS_GOOD) * least))
            continue;
        least = size[0] * size[1];
        const int turned = size[1] > size[0];
        for (int k = 0; k < 2; k++) {
            best.along[k] = turned ? across[k] : along[k];
            best.across[k] = turned ? along[k] : across[k];
            best.size[k] = size[turned ? 1 - k : k];
            best.middle[k] = (low[0] + reached[0]) / 2.0 * along[k] + (low[1] + reached[1]) / 2.0 * across[k];
        }
    }
    return best;
}

/* A Delaunay triangulation: triangles as corners, counter-clockwise.

   Half-edge e runs from corner[e] to that of the half-edge after it in its triangle, e / 3. Its twin is the same edge of
   the neighbor, -1 on the hull. Of a point on the hull, `ahead` and `behind` are the points beside it there, `edge` the
   half-edge ahead.

   Points are added from left to right; each sees a part of the hull of those before it, is joined with that, and
   edges are flipped until no circle about a triangle holds the opposite corner of a neighbor (C. L. Lawson, "Software
   for C1 surface interpolation", Mathematical Software III, 1977). On which side of a line a point lies is decided
   exactly, so that what results is a triangulation whatever the points; edges are flipped only where rounding cannot be
   why, so that the flips come to an end. */
typedef struct {
    const double *points;
    ptrdiff_t n, triangles;
    int32_t *corner, *twin, *ahead, *behind, *edge, *stack;
} Mesh;

static inline ptrdiff_t mesh_room(ptrdiff_t n) { return 17 * n + 16; }

static inline int32_t after(int32_t e) { return e % 3 == 2 ? e - 2 : e + 1; }
static inline int32_t opposite(int32_t e) { return e % 3 == 0 ? e + 2 : e - 1; }

static inline void join(Mesh *mesh, int32_t one, int32_t other)
{
    mesh->twin[one] = other;
    if (other >= 0)
        mesh->twin[other] = one;
    else
        mesh->edge[mesh->corner[one]] = one;
}

static inline int32_t add_triangle(Mesh *mesh, int32_t a, int32_t b, int32_t c)
{
    const int32_t e = (int32_t)(3 * mesh->triangles++);
    mesh->corner[e] = a, mesh->corner[e + 1] = b, mesh->corner[e + 2] = c;
    return e;
}

static inline void follow(Mesh *mesh, int32_t a, int32_t b) { mesh->ahead[a] = b, mesh->behind[b] = a; }

/* Flip edges on the stack, each opposite to a new point in its triangle, where they are not Delaunay. */
static void flip_edges(Mesh *mesh, ptrdiff_t waiting)
{
    const double *p = mesh->points;
    int32_t *corner = mesh->corner;
    while (waiting > 0) {
        const int32_t e = mesh->stack[--waiting], t = mesh->twin[e];
        if (t < 0)
            continue;
        const int32_t e1 = after(e), e2 = opposite(e), t2 = opposite(t);
        const int32_t added = corner[e2], facing = corner[t2];
        if (!within_circle(p + 2 * corner[e], p + 2 * corner[e1], p + 2 * added, p + 2 * facing))
            continue;
        const int32_t beyond = mesh->twin[t2], before = mesh->twin[e2];
        corner[e] = facing, corner[t] = added;
        join(mesh, e, beyond);
        join(mesh, t, before);
        join(mesh, e2, t2);
        mesh->stack[waiting++] = e;
        mesh->stack[waiting++] = after(t);
    }
}

/* The triangles of the first points, all but the last of which are on one line; how many they are. 0: all are. */
static ptrdiff_t start_mesh(Mesh *mesh)
{
    const double *p = mesh->points;
    int32_t k = 2;
    double side = 0.0;
    while (k < mesh->n && (side = side_of(p, p + 2, p + 2 * k)) == 0.0)
        k++;
    if (k >= mesh->n)
        return 0;
    for (int32_t i = 0; i + 1 < k; i++) {
        const int32_t a = side > 0.0 ? i : i + 1, b = side > 0.0 ? i + 1 : i;
        const int32_t e = add_triangle(mesh, a, b, k), in = side > 0.0 ? e + 2 : e + 1, out = side > 0.0 ? e + 1 : e + 2;
        join(mesh, e, -1);
        join(mesh, in, i > 0 ? out - 3 : -1);
        if (i + 2 == k)
            join(mesh, out, -1);
        follow(mesh, a, b);
    }
    follow(mesh, side > 0.0 ? k - 1 : k, side > 0.0 ? k : k - 1);
    follow(mesh, side > 0.0 ? k : 0, side > 0.0 ? 0 : k);
    return k + 1;
}

/* Add the point k, to the right of all before it. */
static void add_point(Mesh *mesh, int32_t k)
{
    const double *p = mesh->points;
    ptrdiff_t waiting = 0;
    int32_t a = k - 1, low = k - 1, b, up = -1, down = -1;
    for (b = mesh->ahead[a]; side_of(p + 2 * a, p + 2 * b, p + 2 * k) < 0.0; a = b, b = mesh->ahead[a]) {
        const int32_t e = add_triangle(mesh, b, a, k);
        join(mesh, e, mesh->edge[a]);
        join(mesh, e + 1, up);
        join(mesh, e + 2, -1);
        down = down < 0 ? e + 1 : down;
        up = e + 2;
        mesh->stack[waiting++] = e;
    }
    const int32_t high = a;
    for (a = mesh->behind[low]; side_of(p + 2 * a, p + 2 * low, p + 2 * k) < 0.0; low = a, a = mesh->behind[a]) {
        const int32_t e = add_triangle(mesh, low, a, k);
        join(mesh, e, mesh->edge[a]);
        join(mesh, e + 2, down);
        join(mesh, e + 1, -1);
        down = e + 1;
        mesh->stack[waiting++] = e;
    }
    follow(mesh, low, k);
    follow(mesh, k, high);
    flip_edges(mesh, waiting);
}

/* Triangulate different points (n, 2) that are sorted by x, and by y where that is the same; none if all are on a line. */
static void triangulate(Mesh *mesh, const double *points, ptrdiff_t n, int32_t *room)
{
    mesh->points = points, mesh->n = n, mesh->triangles = 0;
    mesh->corner = room, mesh->twin = room + 6 * n;
    mesh->ahead = room + 12 * n, mesh->behind = room + 13 * n, mesh->edge = room + 14 * n, mesh->stack = room + 15 * n;
    for (ptrdiff_t k = start_mesh(mesh); k > 0 && k < n; k++)
        add_point(mesh, (int32_t)k);
}
