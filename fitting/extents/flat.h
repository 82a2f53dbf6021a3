/* Points in a plane: their convex outline, the rectangle of least area about it, square cells over them, and the pieces
   that they fill. Places are pairs of coordinates, sorted by the first, and by the second where that is the same. */
#pragma once

#include "extents/spread.h"
#include "geometry/planar.h"

/* A corner of the outline is stray that has fewer than so many points within so many mean spacings. */
#define NEIGHBOURS 6
#define REACH 3.0

/* Cells about the edge hold so many points on average; of random points 0.1% of the cells are empty. */
#define IN_A_CELL 7

/* Points in a cell and its eight neighbors; where there are fewer (63 is usual), they are stray. */
#define FEWEST_AROUND 7

/* Where much of the rectangle is empty the cells are smaller, by this factor at most. */
#define FINEST 8.0

/* Rows of cells, at most so many times the number of points. */
#define MOST_CELLS 16

/* Triangles whose height is less than this share of their longest edge join points of one line but for rounding: they
   cover nothing. */
#define FLAT 1e-12

/* A reach that leaves out too many points is made wider by this factor. */
#define WIDER 1.5

/* Pieces and holes of less than the area of so many points are none. */
#define SMALLEST 20

/* Middles of cells are moved off their rows by so much of the cell, evenly, by multiples of roots, since many points on
   one circle have no one triangulation. */
#define JITTER 0.2
#define ROOT_OF_2 1.4142135623730951
#define ROOT_OF_3 1.7320508075688772

/* Sort rows of so many numbers by their first, and by their second where that is the same. */
EVERYWHERE void sort_places(double *rows, ptrdiff_t n, const int width, double *room)
{
    sort_rows(rows, n, width, room);
    for (ptrdiff_t i = 0, j; i < n; i = j) {
        for (j = i + 1; j < n && rows[j * width] == rows[i * width]; j++)
            ;
        if (j - i == 1)
            continue;
        for (int turn = 0; turn < 2; turn++) {
            for (ptrdiff_t k = i; k < j; k++) {
                const double swap = rows[k * width];
                rows[k * width] = rows[k * width + 1], rows[k * width + 1] = swap;
            }
            if (turn == 0)
                sort_rows(rows + i * width, j - i, width, room);
        }
    }
}

/* Let only one of equal rows stay; how many are left. */
EVERYWHERE ptrdiff_t once_each(const double *rows, ptrdiff_t n, const int width, double *left)
{
    ptrdiff_t count = 0;
    for (ptrdiff_t i = 0; i < n; i++)
        if (i == 0 || rows[i * width] != rows[(i - 1) * width] || rows[i * width + 1] != rows[(i - 1) * width + 1])
            memmove(left + width * count++, rows + i * width, width * sizeof *rows);
    return count;
}

static void take(const double *p, const ptrdiff_t *which, ptrdiff_t n, double *taken)
{
    for (ptrdiff_t i = 0; i < n; i++)
        taken[2 * i] = p[2 * which[i]], taken[2 * i + 1] = p[2 * which[i] + 1];
}

/* Whether fewer than so many other places lie within a distance of place k. */
static int is_stray(const double *p, ptrdiff_t n, ptrdiff_t k, double reach)
{
    const double x = p[2 * k], y = p[2 * k + 1];
    int found = 0;
    for (int step = -1; step <= 1; step += 2)
        for (ptrdiff_t i = k + step; i >= 0 && i < n && fabs(p[2 * i] - x) <= reach; i += step) {
            const double across = p[2 * i] - x, along = p[2 * i + 1] - y;
            found += sqrt(across * across + along * along) <= reach;
            if (found >= NEIGHBOURS)
                return 0;
        }
    return 1;
}

/* Drop places that are stray corners of the convex hull, one in MOST_STRAY at most; how many are left.

   `ring` holds their hull then, of `*count` corners; none where they are on one line. */
static ptrdiff_t outlined(double *p, ptrdiff_t n, ptrdiff_t *corners, double *ring, ptrdiff_t *count)
{
    ptrdiff_t dropped = 0, most = n / MOST_STRAY;
    for (;;) {
        const ptrdiff_t k = hull_of(p, n, corners);
        *count = k < 3 ? 0 : k;
        if (k < 3)
            return n;
        take(p, corners, k, ring);
        const double reach = REACH * sqrt(twice_area(ring, k) / 2.0 / n);
        ptrdiff_t strays = 0;
        for (ptrdiff_t i = 0; i < k; i++)
            if (is_stray(p, n, corners[i], reach))
                corners[strays++] = corners[i];
        dropped += strays;
        if (strays == 0 || dropped > most)
            return n;
        for (ptrdiff_t i = 0; i < strays; i++)
            p[2 * corners[i]] = NAN;
        ptrdiff_t left = 0;
        for (ptrdiff_t i = 0; i < n; i++)
            if (p[2 * i] == p[2 * i])
                p[2 * left] = p[2 * i], p[2 * left + 1] = p[2 * i + 1], left++;
        n = left;
    }
}

/* Keep the places that lie between the ends along both sides of a rectangle; how many they are. Room for 6 n. */
static ptrdiff_t between_ends(
    const double *p, ptrdiff_t n, const double *along, double blur, double *kept, double *room)
{
    double low[2], high[2];
    const double ways[2][2] = {{along[0], along[1]}, {-along[1], along[0]}};
    for (int k = 0; k < 2; k++) {
        double *seen = room + k * n, *sorted = room + 2 * n;
        for (ptrdiff_t i = 0; i < n; i++)
            sorted[i] = seen[i] = p[2 * i] * ways[k][0] + p[2 * i + 1] * ways[k][1];
        sort_numbers(sorted, n, room + 3 * n);
        ends(sorted, n, blur, blur, &low[k], &high[k]);
        low[k] -= SAME * (sorted[n - 1] - sorted[0]);  /* both corners of a side that lies along the rectangle */
        high[k] += SAME * (sorted[n - 1] - sorted[0]);
    }
    ptrdiff_t left = 0;
    for (ptrdiff_t i = 0; i < n; i++)
        if (room[i] >= low[0] && room[i] <= high[0] && room[n + i] >= low[1] && room[n + i] <= high[1])
            kept[2 * left] = p[2 * i], kept[2 * left + 1] = p[2 * i + 1], left++;
    return left;
}

/* Square cells over a rectangle, in rows along the first coordinate and columns along the second. */
typedef struct {
    double low[2], step[2];
    ptrdiff_t rows, columns;
} Grid;

static Grid grid_over(const double *low, const double *size, double side, ptrdiff_t most)
{
    Grid grid;
    ptrdiff_t shape[2];
    for (int k = 0; k < 2; k++) {
        shape[k] = (ptrdiff_t)lesser(greater(rint(size[k] / side), 1.0), (double)most);
        grid.low[k] = low[k], grid.step[k] = size[k] / shape[k];
    }
    grid.rows = shape[0], grid.columns = shape[1];
    return grid;
}

/* The cell of a place, row by row; of one outside the rectangle that at its edge. */
static inline ptrdiff_t cell_of(const Grid *grid, const double *place)
{
    const double row = (place[0] - grid->low[0]) / grid->step[0], column = (place[1] - grid->low[1]) / grid->step[1];
    const ptrdiff_t i = row > 0.0 ? fewer((ptrdiff_t)row, grid->rows - 1) : 0;
    return i * grid->columns + (column > 0.0 ? fewer((ptrdiff_t)column, grid->columns - 1) : 0);
}

static void bounds_of(const double *p, ptrdiff_t n, double *low, double *size)
{
    for (int k = 0; k < 2; k++) {
        double least = p[k], most = p[k];
        for (ptrdiff_t i = 1; i < n; i++)
            least = lesser(least, p[2 * i + k]), most = greater(most, p[2 * i + k]);
        low[k] = least, size[k] = most - least;
    }
}

/* The part of the line at x = `at` that lies within a convex ring; 0: none does. */
static int chord_at(const double *ring, ptrdiff_t n, double at, double *low, double *high)
{
    *low = INFINITY, *high = -INFINITY;
    for (ptrdiff_t i = 0; i < n; i++) {
        const double *a = ring + 2 * i, *b = ring + 2 * ((i + 1) % n);
        if ((a[0] < at && b[0] < at) || (a[0] > at && b[0] > at))
            continue;
        const double share = a[0] == b[0] ? 0.0 : (at - a[0]) / (b[0] - a[0]), y = a[1] + share * (b[1] - a[1]);
        *low = lesser(*low, a[0] == b[0] ? lesser(a[1], b[1]) : y);
        *high = greater(*high, a[0] == b[0] ? greater(a[1], b[1]) : y);
    }
    return *low <= *high;
}

/* Share of the cells with their middle inside a convex ring that hold places; see `covered`. -1: no memory. */
static double covered_inside(const double *p, ptrdiff_t n, const double *ring, ptrdiff_t corners)
{
    double low[2], size[2], from, to;
    bounds_of(ring, corners, low, size);
    const double side = sqrt(POINTS_A_CELL * fabs(twice_area(ring, corners) / 2.0) / n);
    const Grid grid = grid_over(low, size, side, MOST_CELLS * n + MOST_CELLS);
    unsigned char *held = calloc(grid.rows * grid.columns, 1);
    if (!held)
        return -1.0;
    for (ptrdiff_t i = 0; i < n; i++)
        held[cell_of(&grid, p + 2 * i)] = 1;
    ptrdiff_t inside = 0, count = 0;
    for (ptrdiff_t row = 0; row < grid.rows; row++) {
        if (!chord_at(ring, corners, low[0] + (row + 0.5) * grid.step[0], &from, &to))
            continue;
        for (ptrdiff_t column = 0; column < grid.columns; column++) {
            const double at = low[1] + (column + 0.5) * grid.step[1];
            if (at >= from && at <= to)
                inside++, count += held[row * grid.columns + column];
        }
    }
    free(held);
    return inside ? (double)count / inside : 1.0;
}

/* What is triangulated: the places near an edge, then about the middles of the full cells next to them, each with the
   local spacing, 0 of a middle; and those that are looked at for noise, up to a cell farther in. */
typedef struct {
    double *rows, *edge;
    ptrdiff_t n, edges;
    double mean_spacing;
} Near;

/* The sum over each cell and its eight neighbors, or the largest; beyond the edge there is 0. */
static void around(const Grid *grid, const int32_t *values, int32_t *found, int largest)
{
    for (ptrdiff_t i = 0; i < grid->rows; i++)
        for (ptrdiff_t j = 0; j < grid->columns; j++) {
            int32_t sum = 0;
            for (ptrdiff_t k = more(i - 1, 0); k <= fewer(i + 1, grid->rows - 1); k++)
                for (ptrdiff_t l = more(j - 1, 0); l <= fewer(j + 1, grid->columns - 1); l++) {
                    const int32_t value = values[k * grid->columns + l];
                    sum = !largest ? sum + value : value > sum ? value : sum;
                }
            found[i * grid->columns + j] = sum;
        }
}

static void count_in_cells(const Grid *grid, const double *p, ptrdiff_t n, int32_t *counts)
{
    memset(counts, 0, grid->rows * grid->columns * sizeof *counts);
    for (ptrdiff_t i = 0; i < n; i++)
        counts[cell_of(grid, p + 2 * i)]++;
}

static ptrdiff_t occupied_of(const Grid *grid, const int32_t *counts)
{
    ptrdiff_t occupied = 0;
    for (ptrdiff_t k = 0; k < grid->rows * grid->columns; k++)
        occupied += counts[k] > 0;
    return occupied;
}

/* The cells, and how many of the different places each of them holds; null where there is no memory. */
static int32_t *cells_about(const double *p, ptrdiff_t n, Grid *grid)
{
    double low[2], size[2];
    bounds_of(p, n, low, size);
    const double side = sqrt(IN_A_CELL * (size[0] * size[1]) / n);
    *grid = grid_over(low, size, side, MOST_CELLS * n);
    int32_t *counts = malloc(5 * grid->rows * grid->columns * sizeof *counts);
    if (!counts)
        return NULL;
    count_in_cells(grid, p, n, counts);
    const double taken = (double)occupied_of(grid, counts) / (grid->rows * grid->columns);
    if (taken >= 0.5)
        return counts;
    free(counts);
    *grid = grid_over(low, size, side * greater(sqrt(taken), 1.0 / FINEST), MOST_CELLS * n);
    counts = malloc(5 * grid->rows * grid->columns * sizeof *counts);
    if (counts)
        count_in_cells(grid, p, n, counts);
    return counts;
}

/* What is near an edge of different places (n, 2); whether there is memory. Near.rows is to be given back. */
static int near_edges(const double *p, ptrdiff_t n, Near *near)
{
    Grid grid;
    int32_t *counts = cells_about(p, n, &grid);
    if (!counts)
        return 0;
    const ptrdiff_t cells = grid.rows * grid.columns, occupied = occupied_of(&grid, counts);
    int32_t *sums = counts + cells, *full = counts + 2 * cells, *within = counts + 3 * cells, *room = counts + 4 * cells;
    const double cell = grid.step[0] * grid.step[1];
    near->mean_spacing = sqrt(occupied * cell / n);
    around(&grid, counts, sums, 0);
    for (ptrdiff_t k = 0; k < cells; k++)
        room[k] = counts[k] > 0;
    around(&grid, room, full, 0);
    ptrdiff_t middles = 0;
    for (ptrdiff_t k = 0; k < cells; k++)
        middles += full[k] = full[k] == 9;
    around(&grid, full, within, 0);
    around(&grid, sums, room, 1);  /* of the windows about a cell the fullest one is not cut by an edge */
    near->rows = malloc(((n + middles) * 3 + 2 * n) * sizeof *near->rows);
    if (!near->rows) {
        free(counts);
        return 0;
    }
    near->edge = near->rows + 3 * (n + middles);
    near->n = near->edges = 0;
    for (ptrdiff_t i = 0; i < n; i++) {
        const ptrdiff_t k = cell_of(&grid, p + 2 * i);
        if (sums[k] < FEWEST_AROUND || within[k] == 9)
            continue;
        memcpy(near->edge + 2 * near->edges++, p + 2 * i, 2 * sizeof *p);
        if (full[k])
            continue;
        double *row = near->rows + 3 * near->n++;
        row[0] = p[2 * i], row[1] = p[2 * i + 1];
        row[2] = greater(sqrt(9.0 * cell / room[k]), near->mean_spacing);
    }
    for (ptrdiff_t k = 0, m = 0; k < cells; k++) {
        if (!full[k] || within[k] == 9)
            continue;
        double *row = near->rows + 3 * near->n++;
        const double off[2] = {fmod(m * ROOT_OF_2, JITTER), fmod(m * ROOT_OF_3, JITTER)};
        row[0] = grid.low[0] + (k / grid.columns + 0.5) * grid.step[0] + grid.step[0] * (off[0] - JITTER / 2.0);
        row[1] = grid.low[1] + (k % grid.columns + 0.5) * grid.step[1] + grid.step[1] * (off[1] - JITTER / 2.0);
        row[2] = 0.0;
        m++;
    }
    free(counts);
    return 1;
}

/* Twice the area of a triangle. */
static inline double twice_within(const double *p, const int32_t *corner)
{
    const double *a = p + 2 * corner[0], *b = p + 2 * corner[1], *c = p + 2 * corner[2];
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* The longest edge of a triangle in local spacings, of its corners the median; 0 where one is in the midst of points,
   infinite of a flat one. */
static double needed_by(const Mesh *mesh, const double *spacing, ptrdiff_t triangle)
{
    const int32_t *corner = mesh->corner + 3 * triangle;
    double longest = 0.0;
    for (int k = 0; k < 3; k++) {
        const double *a = mesh->points + 2 * corner[k], *b = mesh->points + 2 * corner[(k + 1) % 3];
        longest = greater(longest, (a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]));
    }
    if (twice_within(mesh->points, corner) <= FLAT * longest)
        return INFINITY;
    const double a = spacing[corner[0]], b = spacing[corner[1]], c = spacing[corner[2]];
    const double median = greater(lesser(a, b), lesser(greater(a, b), c));
    return lesser(lesser(a, b), c) == 0.0 ? 0.0 : sqrt(longest) / greater(median, TINY);
}

/* What triangles cover: rings of half-edges, the triangles to their left, in the order that they were found.

   Ring k holds edges[starts[k]] to edges[starts[k + 1]], and bounds the part of[k], whose triangles hang together;
   areas are positive of outer rings, negative of holes. */
typedef struct {
    const Mesh *mesh;
    double *needed, *areas;
    int32_t *part, *place, *path, *edges, *starts, *of, *stack;
    unsigned char *kept, *done, *wall, *held, *large;
    ptrdiff_t rings, n_edges, parts;
} Cover;

static int room_of_cover(Cover *cover, const Mesh *mesh)
{
    const ptrdiff_t t = mesh->triangles, e = 3 * t + 2, n = mesh->n;
    char *room = calloc(1, (t + e) * sizeof(double) + (2 * t + n + 4 * e) * sizeof(int32_t) + 3 * t + 2 * e + n);
    cover->mesh = mesh;
    cover->needed = (double *)room, cover->areas = cover->needed + t;
    cover->part = (int32_t *)(cover->areas + e), cover->stack = cover->part + t, cover->place = cover->stack + t;
    cover->path = cover->place + n, cover->edges = cover->path + e, cover->starts = cover->edges + e;
    cover->of = cover->starts + e;
    cover->kept = (unsigned char *)(cover->of + e), cover->large = cover->kept + t;
    cover->done = cover->large + 2 * t, cover->wall = cover->done + e, cover->held = cover->wall + e;
    return room != NULL;
}

/* Number the parts of the kept triangles that hang together by edges. */
static void number_parts(Cover *cover)
{
    const Mesh *mesh = cover->mesh;
    for (ptrdiff_t t = 0; t < mesh->triangles; t++)
        cover->part[t] = -1;
    cover->parts = 0;
    for (ptrdiff_t t = 0; t < mesh->triangles; t++) {
        if (!cover->kept[t] || cover->part[t] >= 0)
            continue;
        ptrdiff_t waiting = 0;
        cover->part[t] = (int32_t)cover->parts;
        cover->stack[waiting++] = (int32_t)t;
        while (waiting) {
            const int32_t here = cover->stack[--waiting];
            for (int k = 0; k < 3; k++) {
                const int32_t twin = mesh->twin[3 * here + k];
                if (twin < 0 || !cover->kept[twin / 3] || cover->part[twin / 3] >= 0)
                    continue;
                cover->part[twin / 3] = (int32_t)cover->parts;
                cover->stack[waiting++] = twin / 3;
            }
        }
        cover->parts++;
    }
}

static inline int bounds(const Cover *cover, int32_t e)
{
    const int32_t twin = cover->mesh->twin[e];
    return cover->kept[e / 3] && (twin < 0 || !cover->kept[twin / 3]);
}

/* Add a ring of half-edges. */
static void add_ring(Cover *cover, const int32_t *path, ptrdiff_t n)
{
    const Mesh *mesh = cover->mesh;
    const double *origin = mesh->points + 2 * mesh->corner[path[0]];
    double twice = 0.0;
    for (ptrdiff_t i = 0; i < n; i++) {
        const double *a = mesh->points + 2 * mesh->corner[path[i]], *b = mesh->points + 2 * mesh->corner[path[(i + 1) % n]];
        twice += (a[0] - origin[0]) * (b[1] - origin[1]) - (a[1] - origin[1]) * (b[0] - origin[0]);
        cover->place[mesh->corner[path[i]]] = -1;
    }
    memcpy(cover->edges + cover->n_edges, path, n * sizeof *path);
    cover->starts[cover->rings] = (int32_t)cover->n_edges;
    cover->of[cover->rings] = cover->part[path[0] / 3];
    cover->areas[cover->rings++] = twice / 2.0;
    cover->n_edges += n;
    cover->starts[cover->rings] = (int32_t)cover->n_edges;
}

/* Follow the boundary of the kept triangles; where it comes to a corner again, a ring is cut off. */
static void trace_rings(Cover *cover)
{
    const Mesh *mesh = cover->mesh;
    cover->rings = cover->n_edges = 0;
    memset(cover->done, 0, 3 * mesh->triangles);
    for (ptrdiff_t v = 0; v < mesh->n; v++)
        cover->place[v] = -1;
    for (int32_t first = 0; first < 3 * mesh->triangles; first++) {
        if (cover->done[first] || !bounds(cover, first))
            continue;
        ptrdiff_t length = 0;
        int32_t e = first;
        do {
            const int32_t corner = mesh->corner[e], before = cover->place[corner];
            if (before >= 0) {
                add_ring(cover, cover->path + before, length - before);
                length = before;
            }
            cover->done[e] = 1;
            cover->place[corner] = (int32_t)length;
            cover->path[length++] = e;
            for (e = after(e); !bounds(cover, e); e = after(mesh->twin[e]))
                ;
        } while (e != first);
        add_ring(cover, cover->path, length);
    }
}

/* Hold the corners of all triangles inside a hole that is too small to be one. */
static void fill_hole(Cover *cover, ptrdiff_t ring)
{
    const Mesh *mesh = cover->mesh;
    ptrdiff_t waiting = 0;
    for (ptrdiff_t i = cover->starts[ring]; i < cover->starts[ring + 1]; i++)
        cover->wall[cover->edges[i]] = 1;
    for (ptrdiff_t i = cover->starts[ring]; i < cover->starts[ring + 1]; i++) {
        const int32_t twin = mesh->twin[cover->edges[i]];
        if (twin >= 0 && !cover->large[mesh->triangles + twin / 3]) {
            cover->large[mesh->triangles + twin / 3] = 1;
            cover->stack[waiting++] = twin / 3;
        }
    }
    while (waiting) {
        const int32_t here = cover->stack[--waiting];
        for (int k = 0; k < 3; k++) {
            const int32_t twin = mesh->twin[3 * here + k];
            cover->held[mesh->corner[3 * here + k]] = 1;
            if (twin < 0 || cover->wall[twin] || cover->large[mesh->triangles + twin / 3])
                continue;
            cover->large[mesh->triangles + twin / 3] = 1;
            cover->stack[waiting++] = twin / 3;
        }
    }
}

/* What triangles cover that need no more than a reach; how many places that leaves outside. Areas are 0 of pieces and
   holes that are too small. */
static ptrdiff_t cover_within(Cover *cover, double reach, double smallest)
{
    const Mesh *mesh = cover->mesh;
    for (ptrdiff_t t = 0; t < mesh->triangles; t++)
        cover->kept[t] = cover->needed[t] <= reach;
    number_parts(cover);
    trace_rings(cover);
    memset(cover->large, 0, 2 * mesh->triangles);
    memset(cover->wall, 0, 3 * mesh->triangles);
    memset(cover->held, 0, mesh->n);
    for (ptrdiff_t k = 0; k < cover->rings; k++)
        cover->large[cover->of[k]] |= cover->areas[k] > 0.0 && cover->areas[k] >= smallest;
    for (ptrdiff_t t = 0; t < mesh->triangles; t++)
        for (int k = 0; k < 3; k++)
            if (cover->kept[t] && cover->large[cover->part[t]])
                cover->held[mesh->corner[3 * t + k]] = 1;
    for (ptrdiff_t k = 0; k < cover->rings; k++) {
        if (cover->large[cover->of[k]] && cover->areas[k] < 0.0 && -cover->areas[k] < smallest)
            fill_hole(cover, k);
        if (!cover->large[cover->of[k]] || fabs(cover->areas[k]) < smallest)
            cover->areas[k] = 0.0;
    }
    ptrdiff_t out = mesh->n;
    for (ptrdiff_t v = 0; v < mesh->n; v++)
        out -= cover->held[v];
    return out;
}

/* The same with a reach that is made wider while that leaves out more than `most`, as far scan lines would. */
static void cover_most(Cover *cover, const double *spacing, double reach, double smallest, ptrdiff_t most)
{
    double widest = 0.0;
    for (ptrdiff_t t = 0; t < cover->mesh->triangles; t++) {
        cover->needed[t] = needed_by(cover->mesh, spacing, t);
        widest = isfinite(cover->needed[t]) ? greater(widest, cover->needed[t]) : widest;
    }
    while (cover_within(cover, reach, smallest) > most && reach < widest)
        reach *= WIDER;
}

/* Whether it is one piece without holes, and nowhere deeper than so within a convex ring. */
static int fills(const Cover *cover, const double *ring, ptrdiff_t corners, double depth)
{
    ptrdiff_t found = -1, count = 0;
    for (ptrdiff_t k = 0; k < cover->rings; k++)
        if (cover->areas[k] != 0.0)
            found = k, count++;
    if (count != 1)
        return 0;
    for (ptrdiff_t i = cover->starts[found]; i < cover->starts[found + 1]; i++) {
        const double *at = cover->mesh->points + 2 * cover->mesh->corner[cover->edges[i]];
        double nearest = INFINITY;
        for (ptrdiff_t k = 0; k < corners && nearest > depth; k++) {
            const double *a = ring + 2 * k, *b = ring + 2 * ((k + 1) % corners);
            const double x = b[0] - a[0], y = b[1] - a[1];
            nearest = lesser(nearest, (x * (at[1] - a[1]) - y * (at[0] - a[0])) / sqrt(x * x + y * y));
        }
        if (nearest > depth)
            return 0;
    }
    return 1;
}

/* How deep a place is inside the rings whose n edges are given as rows of x, y, length along x, along y and the inverse of
   the length squared; negative outside. */
VECTOR_UNITS static double depth_in(const double *edges, ptrdiff_t n, double x, double y)
{
    const double *restrict ax = edges, *restrict ay = edges + n, *restrict dx = edges + 2 * n, *restrict dy = edges + 3 * n;
    const double *restrict inverse = edges + 4 * n;
    double nearest = INFINITY, crossed = 0.0;  /* by a ray to the right */
#pragma omp simd reduction(min : nearest) reduction(+ : crossed)
    for (ptrdiff_t i = 0; i < n; i++) {
        const double to_x = x - ax[i], to_y = y - ay[i];
        double share = (to_x * dx[i] + to_y * dy[i]) * inverse[i];
        share = share > 0.0 ? share : 0.0;
        share = share < 1.0 ? share : 1.0;
        const double off_x = to_x - share * dx[i], off_y = to_y - share * dy[i], off = off_x * off_x + off_y * off_y;
        nearest = off < nearest ? off : nearest;
        const double start = to_y < 0.0 ? -1.0 : 1.0, end = to_y < dy[i] ? -1.0 : 1.0;
        crossed += (end - start) * (to_x * dy[i] - to_y * dx[i]) > 0.0 ? 1.0 : 0.0;
    }
    return fmod(crossed, 2.0) == 1.0 ? sqrt(nearest) : -sqrt(nearest);
}
