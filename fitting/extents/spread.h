/* Where points begin and end along a line or around a circle, and how densely they cover what is between.

   A few stray points beyond an end, and noise along the surface, must not widen it. */
#pragma once

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "geometry/median.h"
#include "geometry/vectors.h"

#define TURN 6.283185307179586
#define HALF_TURN 3.141592653589793

/* An outermost point is stray if it and the next four are this many times as far apart as those inside. */
#define NEXT 4
#define STRAY 5.0

/* At most one in so many points is dropped at an end. */
#define MOST_STRAY 20

/* Values that differ by less than this share of all that they span are the same, but rounding. */
#define SAME 1e-12

/* With fewer points the outermost ones are the ends. */
#define FEWEST 40

/* Noise carries points over a sharp end: as many as there are in this many of its standard deviations. */
#define BLURRED 0.4

/* Width, in standard deviations, in which the points at an end are counted for that. */
#define BLUR_BAND 10.0

/* A gap is real if fewer than one in 100 of clouds without a gap have one: -log 0.01. */
#define CHANCE 4.6

/* It must also be this many times the fifth largest gap: scan lines leave equal ones. */
#define USUAL_GAPS 5
#define USUAL 2.0

/* Sectors with less than this share of the mean number of points may be part of a gap. */
#define SPARSE 0.1
#define MOST_SECTORS 720

/* Cells that points are counted in hold so many on average; of random points 0.7% of the cells are empty. */
#define POINTS_A_CELL 5

/* The bits of a number as an integer of the same order. */
static inline uint64_t rank_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits ^ ((uint64_t)((int64_t)bits >> 63) | 0x8000000000000000u);
}

/* Sort n rows of so many numbers by their first, by its bytes from the last one on; the room is as large as the rows. */
EVERYWHERE void sort_rows(double *rows, ptrdiff_t n, const int width, double *room)
{
    if (n < 48) {
        for (ptrdiff_t i = 1; i < n; i++) {
            double row[4];
            ptrdiff_t j = i;
            memcpy(row, rows + i * width, width * sizeof *row);
            for (; j > 0 && rows[(j - 1) * width] > row[0]; j--)
                memcpy(rows + j * width, rows + (j - 1) * width, width * sizeof *row);
            memcpy(rows + j * width, row, width * sizeof *row);
        }
        return;
    }
    uint32_t counts[8][256] = {{0}};
    for (ptrdiff_t i = 0; i < n; i++) {
        const uint64_t rank = rank_of(rows[i * width]);
        for (int k = 0; k < 8; k++)
            counts[k][rank >> 8 * k & 255]++;
    }
    double *from = rows, *to = room;
    for (int k = 0; k < 8; k++) {
        if (counts[k][rank_of(from[0]) >> 8 * k & 255] == (uint32_t)n)
            continue;
        uint32_t before = 0;
        for (int byte = 0; byte < 256; byte++) {
            const uint32_t count = counts[k][byte];
            counts[k][byte] = before;
            before += count;
        }
        for (ptrdiff_t i = 0; i < n; i++) {
            const ptrdiff_t place = counts[k][rank_of(from[i * width]) >> 8 * k & 255]++;
            memcpy(to + place * width, from + i * width, width * sizeof *to);
        }
        double *const swap = from;
        from = to, to = swap;
    }
    if (from != rows)
        memcpy(rows, from, n * width * sizeof *rows);
}

static inline void sort_numbers(double *values, ptrdiff_t n, double *room) { sort_rows(values, n, 1, room); }

/* Sorted numbers seen from a place among them: those from `first` on, then, a turn later, those before. */
typedef struct {
    const double *values;
    ptrdiff_t n, first;
    double from;
} Ordered;

static inline double ordered_at(const Ordered *o, ptrdiff_t k)
{
    k += o->first;
    return k < o->n ? o->values[k] - o->from : o->values[k - o->n] - o->from + TURN;
}

/* The same from the upper end downwards. */
static inline double from_end(const Ordered *o, ptrdiff_t k, int upper)
{
    return upper ? -ordered_at(o, o->n - 1 - k) : ordered_at(o, k);
}

/* How many of the numbers lie before a value, as seen from that end. */
static inline ptrdiff_t before(const Ordered *o, double value, int upper)
{
    ptrdiff_t low = 0, high = o->n;
    while (low < high) {
        const ptrdiff_t middle = (low + high) / 2;
        if (from_end(o, middle, upper) < value)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* One end: without the stray points before it, and without what noise of a standard deviation carried over it. */
static double end_of(const Ordered *o, double blur, int upper)
{
    ptrdiff_t n = o->n, start = 0;
    if (n >= FEWEST) {
        const ptrdiff_t inner = more(20, n / MOST_STRAY);
        const double same = SAME * (ordered_at(o, n - 1) - ordered_at(o, 0));
        for (ptrdiff_t k = 0; k <= n / MOST_STRAY; k++) {
            const double outer = from_end(o, k, upper), next = from_end(o, k + NEXT, upper);
            const double usual = (from_end(o, k + NEXT + inner, upper) - next) / inner;
            if (!(next - outer > NEXT * STRAY * usual + same)) {
                start = k;
                break;
            }
        }
    }
    if (blur > 0.0) {
        const ptrdiff_t near = before(o, from_end(o, start, upper) + BLUR_BAND * blur, upper) - start;
        start += (ptrdiff_t)(BLURRED / BLUR_BAND * near);
    }
    const double end = from_end(o, fewer(start, n - 1), upper);
    return upper ? -end : end;
}

/* Where sorted values of about even density begin and end; the blurs are the standard deviations of the noise there. */
static inline void ends(const double *values, ptrdiff_t n, double blur_low, double blur_high, double *low, double *high)
{
    const Ordered o = {values, n, 0, 0.0};
    *low = end_of(&o, blur_low, 0);
    *high = end_of(&o, blur_high, 1);
}

/* Start and span of sorted angles seen from a place where there are none. */
static void arc_from(const double *circle, ptrdiff_t n, double cut, double blur, double *start, double *span)
{
    Ordered o = {circle, n, 0, 0.0};
    o.first = before(&o, cut, 0), o.from = cut;
    const double low = end_of(&o, blur, 0), high = end_of(&o, blur, 1);
    *start = low + cut, *span = high - low;
}

/* The middle of the longest run of sectors that hold few points, stray ones for instance. */
static double sparsest(const double *circle, ptrdiff_t n)
{
    uint32_t counts[MOST_SECTORS] = {0};
    const ptrdiff_t sectors = more(8, fewer(n / 40, MOST_SECTORS));
    const double few = SPARSE * n / sectors;
    for (ptrdiff_t i = 0; i < n; i++)
        counts[(ptrdiff_t)(circle[i] * (sectors / TURN)) % sectors]++;
    ptrdiff_t first = -1, last = -1, longest = 0, place = 0;
    for (ptrdiff_t k = 0; k < sectors; k++) {
        if (counts[k] < few)
            continue;
        if (first < 0)
            first = k;
        else if (k - last > longest)
            longest = k - last, place = last;
        last = k;
    }
    if (first < 0)
        return 0.0;
    if (first + sectors - last > longest)
        longest = first + sectors - last, place = last;
    return longest == 1 ? 0.0 : (place + 0.5 + longest / 2.0) * 2.0 * HALF_TURN / sectors;
}

typedef struct {
    double start, span;
    int full;
} Arc;

/* The arc that angles in [-pi, pi] fill: what the largest gap leaves of the circle.

   `evenness` is the density of the points where it is lowest, over its mean. The arc is the full circle, from 0 on,
   if no gap is larger than chance or the pattern of a scan explains. Angles become sorted, in [0, 2 pi); the room
   is as large. */
static Arc arc_of(double *angles, ptrdiff_t n, double blur, double evenness, double *room)
{
    const Arc whole = {0.0, TURN, 1};
    for (ptrdiff_t i = 0; i < n; i++)
        angles[i] += angles[i] < 0.0 ? TURN : 0.0;
    sort_numbers(angles, n, room);
    double largest[USUAL_GAPS] = {0.0}, widest = -1.0, cuts[2] = {0.0};
    for (ptrdiff_t i = 0; i < n; i++) {
        const double gap = i + 1 < n ? angles[i + 1] - angles[i] : angles[0] + TURN - angles[i];
        if (gap > widest)
            widest = gap, cuts[0] = angles[i] + gap / 2.0;
        if (gap > largest[USUAL_GAPS - 1]) {
            int k = USUAL_GAPS - 1;
            for (; k > 0 && largest[k - 1] < gap; k--)
                largest[k] = largest[k - 1];
            largest[k] = gap;
        }
    }
    cuts[1] = sparsest(angles, n);
    double gap = -1.0, cut = 0.0;
    for (int k = 0; k < 2; k++) {
        double start, span;
        arc_from(angles, n, cuts[k], 0.0, &start, &span);
        if (TURN - span > gap || (TURN - span == gap && cuts[k] > cut))
            gap = TURN - span, cut = cuts[k];
    }
    const double chance = TURN * (log((double)n) + CHANCE) / (n * greater(evenness, 1e-9));
    const double usual = n > USUAL_GAPS ? USUAL * largest[USUAL_GAPS - 1] : 0.0;
    if (gap <= greater(lesser(chance, HALF_TURN), usual))
        return whole;
    Arc arc = {0.0, 0.0, 0};
    arc_from(angles, n, cut, blur, &arc.start, &arc.span);
    arc.start = fmod(arc.start, TURN);
    return arc;
}

/* How far an angle is beyond another, in [-pi, pi). */
static inline double beyond(double angle, double other)
{
    double off = angle - other + HALF_TURN;
    while (off < 0.0)
        off += TURN;
    while (off >= TURN)
        off -= TURN;
    return off - HALF_TURN;
}

/* How far round an arc an angle is: 0 at its start, 1 at its end; others near one of them. */
static inline double along_arc(double angle, double start, double span)
{
    return 0.5 + beyond(angle, start + span / 2.0) / greater(span, TINY);
}

/* In which of a number of equal parts of [0, 1] a share lies; those of a span of 0 in the first. */
static inline ptrdiff_t part_of(double share, ptrdiff_t number)
{
    return share > 0.0 ? fewer((ptrdiff_t)(lesser(share, 1.0) * number), number - 1) : 0;
}

/* Share of a trimmed surface near which there are points, whose coordinates `along` and `across` it are shares.

   Equal areas of the surface are equal areas of the unit square, and points outside it count at its edge; `aspect` is
   the length of the surface along the first over its length along the second. The surface is cut into cells of
   equal area, as nearly square as their number allows, POINTS_A_CELL times as large as the share of one point; a
   cell is covered that holds a point. The room is for n + 1 bytes. */
static double covered(const double *along, const double *across, ptrdiff_t n, double aspect, unsigned char *room)
{
    const double wanted = greater((double)n / POINTS_A_CELL, 1.0);
    const ptrdiff_t rows = (ptrdiff_t)lesser(greater(rint(sqrt(wanted * aspect)), 1.0), wanted);
    const ptrdiff_t columns = more((ptrdiff_t)(wanted / rows), 1);
    ptrdiff_t count = 0;
    memset(room, 0, rows * columns);
    for (ptrdiff_t i = 0; i < n; i++)
        room[part_of(along[i], rows) * columns + part_of(across[i], columns)] = 1;
    for (ptrdiff_t k = 0; k < rows * columns; k++)
        count += room[k];
    return (double)count / (rows * columns);
}
