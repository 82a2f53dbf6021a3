# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Where the points of each kind begin and end, compiled."""

from libc.math cimport INFINITY, acos, asin, atan2, cos, fabs, log, sin, sqrt
from libc.stdint cimport int32_t
from libc.stdlib cimport free, malloc

import numpy as np

cdef extern from "geometry/vectors.h" nogil:
    double TINY
    double dot(const double *a, const double *b)
    void basis(const double *axis, double *u, double *v)
    void normalize(double *direction)

cdef extern from "geometry/median.h" nogil:
    double median(double *values, Py_ssize_t n)
    double selected(double *values, Py_ssize_t n, Py_ssize_t rank)

cdef extern from "geometry/room.h":
    double *room_for(Py_ssize_t numbers) except NULL

cdef extern from "geometry/planar.h" nogil:
    ctypedef struct Rectangle:
        double along[2]
        double across[2]
        double middle[2]
        double size[2]
    ctypedef struct Mesh:
        Py_ssize_t triangles
        int32_t *corner
    Py_ssize_t hull_of(const double *p, Py_ssize_t n, Py_ssize_t *corners)
    double twice_area(const double *ring, Py_ssize_t n)
    Rectangle rectangle_about(const double *ring, Py_ssize_t n)
    Py_ssize_t mesh_room(Py_ssize_t n)
    void triangulate(Mesh *mesh, const double *points, Py_ssize_t n, int32_t *room)

cdef extern from "extents/spread.h" nogil:
    double TURN, CHANCE, USUAL
    Py_ssize_t FEWEST, MOST_STRAY, USUAL_GAPS
    ctypedef struct Arc:
        double start, span
        bint full
    void sort_numbers(double *values, Py_ssize_t n, double *room)
    void ends(const double *values, Py_ssize_t n, double blur_low, double blur_high, double *low, double *high)
    Arc arc_of(double *angles, Py_ssize_t n, double blur, double evenness, double *room)
    double beyond(double angle, double other)
    double along_arc(double angle, double start, double span)
    double covered(const double *along, const double *across, Py_ssize_t n, double aspect, unsigned char *room)

cdef extern from "extents/flat.h" nogil:
    Py_ssize_t SMALLEST
    ctypedef struct Near:
        double *rows
        double *edge
        Py_ssize_t n, edges
        double mean_spacing
    ctypedef struct Cover:
        double *needed
        double *areas
        int32_t *edges
        int32_t *starts
        int32_t *of
        Py_ssize_t rings
    void sort_places(double *rows, Py_ssize_t n, int width, double *room)
    Py_ssize_t once_each(const double *rows, Py_ssize_t n, int width, double *left)
    void take(const double *p, const Py_ssize_t *which, Py_ssize_t n, double *taken)
    Py_ssize_t outlined(double *p, Py_ssize_t n, Py_ssize_t *corners, double *ring, Py_ssize_t *count)
    Py_ssize_t between_ends(
        const double *p, Py_ssize_t n, const double *along, double blur, double *kept, double *room
    )
    double covered_inside(const double *p, Py_ssize_t n, const double *ring, Py_ssize_t corners)
    bint near_edges(const double *p, Py_ssize_t n, Near *near)
    bint room_of_cover(Cover *cover, const Mesh *mesh)
    void cover_most(Cover *cover, const double *spacing, double reach, double smallest, Py_ssize_t most)
    double depth_in(const double *edges, Py_ssize_t n, double x, double y)
    bint fills(const Cover *cover, const double *ring, Py_ssize_t corners, double depth)

cdef double NEAR_AXIS = 0.25
"""Points nearer to the axis than this share of the farthest say little about angles."""

cdef int DIRECTIONS = 256
"""Directions that are asked where a sphere is empty ..."""

cdef Py_ssize_t ASKED = 2000
"""... with so many of the points."""

cdef int NEAREST = 3
"""Fewer points than this in it do not fill a hole."""

cdef Py_ssize_t OUTERMOST = 1000
"""So many points nearest to the rim of a cap move its axis ..."""

cdef Py_ssize_t ALL_ROUND = 500
"""... with about so many of all, since those nearest may lie on one side."""

cdef double LARGEST_STEP = 0.2, SMALLEST_STEP = 0.001
"""Angles by which the axis of a cap is moved while that makes the cap smaller."""

cdef int WAYS = 12
"""Directions of the moves that are tried, across the axis."""

cdef Py_ssize_t MOST_OUTER = 100
cdef double OUTER_SHARE = 0.25
"""Where more of the points than both are corners of the convex outline they lie on a circle, not in it, and that is
their outline."""


def coverage(along, across, double aspect):
    """Share of a trimmed surface near which there are points, by shares (N,) of its sides; see `spread.h`."""
    cdef const double[::1] first = np.ascontiguousarray(along, dtype=float)
    cdef const double[::1] second = np.ascontiguousarray(across, dtype=float)
    cdef double *room = room_for(first.shape[0])
    found = covered(&first[0], &second[0], first.shape[0], aspect, <unsigned char *> room)
    free(room)
    return found


cdef void see(
    const double[:, ::1] points, const double[::1] origin, const double[::1] axis, double *x, double *y, double *height
) noexcept nogil:
    """Coordinates (n,) of points across an axis, in its basis, and along it."""
    cdef double u[3]
    cdef double v[3]
    cdef double away[3]
    cdef Py_ssize_t i
    cdef int k
    basis(&axis[0], u, v)
    for i in range(points.shape[0]):
        for k in range(3):
            away[k] = points[i, k] - origin[k]
        x[i], y[i], height[i] = dot(away, u), dot(away, v), dot(away, &axis[0])


cdef double steady_of(double *angle, double *rho, Py_ssize_t n, Py_ssize_t *count) noexcept nogil:
    """Bring the angles of the points to the front that are not near the axis; their median distance from it.

    Both arrays are used up.
    """
    cdef double least = 0.0
    cdef Py_ssize_t i, left = 0
    for i in range(n):
        least = max(least, rho[i])
    least *= NEAR_AXIS
    for i in range(n):
        if rho[i] >= least:
            angle[left], rho[left] = angle[i], rho[i]
            left += 1
    count[0] = left
    return median(rho, left)


def cylinder(
    const double[:, ::1] points, const double[::1] point, const double[::1] axis, double radius, double blur
):
    """Of points (N, 3): low, high, start, span, whether a full turn, coverage; see `fitting.extents.cylinder`."""
    cdef Py_ssize_t i, n = points.shape[0]
    cdef double *room = room_for(5 * n)
    cdef double *height = room + n
    cdef double *used = room + 2 * n
    cdef double *spare = room + 3 * n
    cdef double low, high, found
    cdef Arc arc
    with nogil:
        see(points, point, axis, room, spare, height)
        for i in range(n):
            room[i] = atan2(spare[i], room[i])
            used[i] = height[i]
        sort_numbers(used, n, spare)
        ends(used, n, blur, blur, &low, &high)
        for i in range(n):
            used[i] = room[i]
        arc = arc_of(used, n, blur / radius, 1.0, spare)
        for i in range(n):
            height[i] = (height[i] - low) / max(high - low, TINY)
            room[i] = along_arc(room[i], arc.start, arc.span)
        found = covered(height, room, n, (high - low) / max(arc.span * radius, TINY), <unsigned char *> spare)
    free(room)
    return low, high, arc.start, arc.span, arc.full, found


def cone(
    const double[:, ::1] points, const double[::1] apex, const double[::1] axis, double half_angle, double blur
):
    """Of points (N, 3): low, high, start, span, whether a full turn, coverage; see `fitting.extents.cone`.

    The low end is 0 where the apex is inside.
    """
    cdef Py_ssize_t i, n = points.shape[0], count
    cdef double *room = room_for(5 * n)
    cdef double *height = room + n
    cdef double *used = room + 2 * n
    cdef double *rho = room + 3 * n
    cdef double *spare = room + 4 * n
    cdef double sine = sin(half_angle), cosine = cos(half_angle), tangent = sine / cosine
    cdef double away, least = INFINITY, most = -INFINITY, low, high, low2, high2, middle, length, found
    cdef Arc arc
    with nogil:
        see(points, apex, axis, room, spare, height)
        for i in range(n):
            away = sqrt(room[i] * room[i] + spare[i] * spare[i])
            length = max(height[i] * cosine + away * sine, 0.0)  # the foot's distance from the apex
            room[i] = atan2(spare[i], room[i])
            height[i], rho[i] = length * cosine, length * sine
            least, most = min(least, height[i]), max(most, height[i])
            height[i] *= height[i]
            used[i] = height[i]
        # Squares of heights are areas: along them points are evenly dense.
        sort_numbers(used, n, spare)
        ends(used, n, 2.0 * blur * cosine * least, 2.0 * blur * cosine * most, &low2, &high2)
        low = 0.0 if low2 * n <= CHANCE * (high2 - low2) else sqrt(low2)
        high = sqrt(high2)
        for i in range(n):
            used[i] = room[i]
        middle = steady_of(used, rho, n, &count)
        arc = arc_of(used, count, blur / max(middle, TINY), 1.0, spare)
        for i in range(n):
            height[i] = (height[i] - low * low) / max(high * high - low * low, TINY)
            room[i] = along_arc(room[i], arc.start, arc.span)
        length = arc.span * tangent * (low + high) / 2.0
        found = covered(height, room, n, (high - low) / cosine / max(length, TINY), <unsigned char *> spare)
    free(room)
    return low, high, arc.start, arc.span, arc.full, found


cdef double grown(double angle, double low, double major, double minor) noexcept nogil:
    """The area of a torus from one angle around the tube to another, over its minor radius and span."""
    return major * (angle - low) + minor * (sin(angle) - sin(low))


def torus(
    const double[:, ::1] points, const double[::1] center, const double[::1] axis, double major, double minor,
    double blur
):
    """Of points (N, 3): both arcs, as start, span and whether a full turn, area, coverage; see `fitting.extents.torus`."""
    cdef Py_ssize_t i, n = points.shape[0], count
    cdef double *room = room_for(5 * n)
    cdef double *tube = room + n
    cdef double *used = room + 2 * n
    cdef double *rho = room + 3 * n
    cdef double *spare = room + 4 * n
    cdef double away, side, whole, area, found
    cdef Arc arc, tubes
    with nogil:
        see(points, center, axis, room, spare, tube)
        for i in range(n):
            away = sqrt(room[i] * room[i] + spare[i] * spare[i])
            rho[i] = major + minor * (away - major) / (sqrt((away - major) * (away - major) + tube[i] * tube[i]) + TINY)
            side = -1.0 if rho[i] < 0.0 else 1.0  # a foot beyond the axis
            room[i] = atan2(side * spare[i], side * room[i])
            tube[i] *= minor / (sqrt((away - major) * (away - major) + tube[i] * tube[i]) + TINY)
            rho[i] = fabs(rho[i])
            tube[i] = atan2(tube[i], rho[i] - major)
            used[i] = room[i]
        away = steady_of(used, rho, n, &count)
        arc = arc_of(used, count, blur / max(away, TINY), 1.0, spare)
        for i in range(n):
            used[i] = tube[i]
        if major > minor:
            tubes = arc_of(used, n, blur / max(minor, TINY), (major - minor) / major, spare)
        else:
            sort_numbers(used, n, spare)
            ends(used, n, blur / max(minor, TINY), blur / max(minor, TINY), &tubes.start, &tubes.span)
            tubes.span -= tubes.start
            tubes.full = False
        whole = grown(tubes.start + tubes.span, tubes.start, major, minor)
        area = minor * arc.span * whole
        for i in range(n):
            away = tubes.start + tubes.span / 2.0
            away += beyond(tube[i], away)
            tube[i] = grown(away, tubes.start, major, minor) / max(whole, TINY)
            room[i] = along_arc(room[i], arc.start, arc.span)
        found = covered(
            tube, room, n, (minor * tubes.span) * (minor * tubes.span) / max(area, TINY), <unsigned char *> spare
        )
    free(room)
    return (
        arc.start, arc.span, arc.full, tubes.start % TURN + (TURN if tubes.start < 0.0 else 0.0), tubes.span,
        tubes.full, area, found,
    )


cdef void heights_about(
    const double *x, const double *y, const double *z, Py_ssize_t n, const double *axis, double *height
) noexcept nogil:
    """1 - cos of the angles of directions (n,) to an axis; of small caps, too, whose cosines are all 1."""
    cdef double a, b, c
    cdef Py_ssize_t i
    for i in range(n):
        a, b, c = x[i] - axis[0], y[i] - axis[1], z[i] - axis[2]
        height[i] = (a * a + b * b + c * c) / 2.0


cdef double rim_of(const double *height, Py_ssize_t n, double blur, double *room) noexcept nogil:
    """Where the heights of the points on a cap end; equal heights are equal areas. The room is (2 n,)."""
    cdef double highest, low, high
    cdef Py_ssize_t i
    for i in range(n):
        room[i] = height[i]
    sort_numbers(room, n, room + n)
    highest = min(room[n - 1], 2.0)
    ends(room, n, 0.0, blur * sqrt(max(highest * (2.0 - highest), 0.0)), &low, &high)
    return min(max(high, TINY), 2.0)


cdef double nearest_to(
    const double *x, const double *y, const double *z, Py_ssize_t n, const double *way, int rank, double enough
) noexcept nogil:
    """The cosine of the angle to a direction of the so many nearest of others (n,), or one that is `enough`."""
    cdef double largest[3]
    cdef double block[128]
    cdef double most
    cdef Py_ssize_t start, i, count
    cdef int k
    largest[0] = largest[1] = largest[2] = -INFINITY
    for start in range(0, n, 128):
        count = min(128, n - start)
        most = -INFINITY
        for i in range(count):
            block[i] = x[start + i] * way[0] + y[start + i] * way[1] + z[start + i] * way[2]
        for i in range(count):
            if block[i] <= largest[rank - 1]:
                continue
            k = rank - 1
            while k > 0 and largest[k - 1] < block[i]:
                largest[k] = largest[k - 1]
                k -= 1
            largest[k] = block[i]
        if largest[rank - 1] >= enough:
            break
    return largest[rank - 1]


cdef void away_from_empty(
    const double *x, const double *y, const double *z, Py_ssize_t n, const double[:, ::1] spread, double *sample,
    double *axis
) noexcept nogil:
    """The direction of some that is farthest from where there are few points; the room is (3 n,)."""
    cdef Py_ssize_t stride = (n + ASKED - 1) // ASKED, count = 0, i
    cdef double least = INFINITY, found
    cdef double way[3]
    cdef int j, k
    while count * stride < n:
        i = count * stride
        sample[count], sample[n + count], sample[2 * n + count] = x[i], y[i], z[i]
        count += 1
    for j in range(spread.shape[0]):
        for k in range(3):
            way[k] = -spread[j, k]
        found = nearest_to(sample, sample + n, sample + 2 * n, count, way, min(NEAREST, count), least)
        if found < least:
            least = found
            for k in range(3):
                axis[k] = spread[j, k]
    normalize(axis)


cdef double lowest_of(double *held, Py_ssize_t n, const double *axis, double enough) noexcept nogil:
    """The least cosine of directions (n, 3) to an axis, or one that is at most `enough`: then whose it is moves ahead."""
    cdef double least = INFINITY, found, swap
    cdef Py_ssize_t i, ahead
    cdef int k
    for i in range(n):
        found = dot(held + 3 * i, axis)
        if found >= least:
            continue
        least = found
        if least <= enough:
            ahead = i // 2
            for k in range(3):
                swap = held[3 * i + k]
                held[3 * i + k] = held[3 * ahead + k]
                held[3 * ahead + k] = swap
            return least
    return least


cdef void tighten(double *axis, double *held, Py_ssize_t n) noexcept nogil:
    """Move the axis of a cap about directions (n, 3) while the cap becomes smaller."""
    cdef double step = LARGEST_STEP, lowest = lowest_of(held, n, axis, -INFINITY), best, found
    cdef double u[3]
    cdef double v[3]
    cdef double tried[3]
    cdef double moved[3]
    cdef int way, k
    while step > SMALLEST_STEP:
        basis(axis, u, v)
        best = lowest
        moved[0], moved[1], moved[2] = axis[0], axis[1], axis[2]
        for way in range(WAYS):
            for k in range(3):
                tried[k] = cos(step) * axis[k] + sin(step) * (
                    cos(way * TURN / WAYS) * u[k] + sin(way * TURN / WAYS) * v[k]
                )
            found = lowest_of(held, n, tried, best)
            if found > best:
                best = found
                for k in range(3):
                    moved[k] = tried[k]
        if best == lowest:
            step /= 2.0
        lowest = best
        for k in range(3):
            axis[k] = moved[k]
    normalize(axis)


cdef double cap_about(
    const double *x, const double *y, const double *z, Py_ssize_t n, double blur, double *axis, double *room
) noexcept nogil:
    """Bring an axis to that of the smallest cap about directions (n,), and say its height; the room is (8 n,)."""
    cdef double *height = room
    cdef double *cosine = room + n
    cdef double *held = room + 2 * n
    cdef double depth, last
    cdef Py_ssize_t i, count, within, stride
    cdef int turn
    for turn in range(2):
        heights_about(x, y, z, n, axis, height)
        depth = rim_of(height, n, blur, cosine)
        within = 0
        for i in range(n):
            if height[i] <= depth:
                cosine[within] = 1.0 - height[i]
                within += 1
        if within < 3:
            break
        stride = (within + ALL_ROUND - 1) // ALL_ROUND
        last = selected(cosine, within, OUTERMOST - 1) if within > OUTERMOST else INFINITY
        count = within = 0
        for i in range(n):
            if height[i] > depth:
                continue
            if 1.0 - height[i] <= last or within % stride == 0:
                held[3 * count], held[3 * count + 1], held[3 * count + 2] = x[i], y[i], z[i]
                count += 1
            within += 1
        tighten(axis, held, count)
    heights_about(x, y, z, n, axis, height)
    return rim_of(height, n, blur, cosine)


cdef double hole_below(
    const double *height, double *azimuth, Py_ssize_t n, double depth, double blur, double *room
) noexcept nogil:
    """The height where a zone begins; 0 of a cap, whose middle holds points or which is not full around.

    Azimuths are used up; the room is (2 n,).
    """
    cdef double least = INFINITY, low, high, usual
    cdef Py_ssize_t i
    for i in range(n):
        room[i] = height[i]
        least = min(least, height[i])
    least = max(least, 0.0)
    if least * n <= CHANCE * depth:
        return 0.0
    sort_numbers(room, n, room + n)
    ends(room, n, blur * sqrt(least * (2.0 - least)), 0.0, &low, &high)
    low = min(max(low, 0.0), depth)
    for i in range(n):
        room[i] = acos(1.0 - min(max(room[i], 0.0), 2.0))
    for i in range(n - 1):
        room[n + i] = room[i + 1] - room[i]
    usual = selected(room + n, n - 1, n - 1 - USUAL_GAPS) if n > USUAL_GAPS else 0.0
    if angle_of(low) <= USUAL * usual or low >= depth or not arc_of(azimuth, n, 0.0, 1.0, room).full:
        return 0.0
    return low


def sphere(
    const double[:, ::1] points, const double[::1] center, double radius, double blur, const double[:, ::1] spread
):
    """Of points (N, 3): axis, depth, low, whether full, coverage; see `fitting.extents.sphere`.

    Depth and low are heights of rims, 1 - cos of their angles to the axis; `spread` (K, 3) are directions that are
    asked where the sphere is empty.
    """
    cdef Py_ssize_t i, n = points.shape[0]
    cdef double *room = room_for(13 * n)
    cdef double *x = room
    cdef double *y = room + n
    cdef double *z = room + 2 * n
    cdef double *azimuth = room + 3 * n
    cdef double *across = room + 4 * n
    cdef double *spare = room + 5 * n
    cdef double axis[3]
    cdef double u[3]
    cdef double v[3]
    cdef double away[3]
    cdef double size, depth, low = 0.0, found, middle
    cdef bint full
    cdef int k
    with nogil:
        axis[0] = axis[1] = axis[2] = 0.0
        for i in range(n):
            for k in range(3):
                away[k] = points[i, k] - center[k]
            size = sqrt(dot(away, away)) + TINY
            x[i], y[i], z[i] = away[0] / size, away[1] / size, away[2] / size
            axis[0], axis[1], axis[2] = axis[0] + x[i], axis[1] + y[i], axis[2] + z[i]
        if sqrt(dot(axis, axis)) > 0.5 * n:  # the mean of a hemisphere
            normalize(axis)
        else:
            away_from_empty(x, y, z, n, spread, spare, axis)
        depth = cap_about(x, y, z, n, blur / radius, axis, spare)
        # Points left to chance leave a cap empty, of this share of the area at most.
        full = (2.0 - depth) / 2.0 <= min((log(<double> n) + CHANCE + 2.0) / n, 0.25)
        if full:
            axis[0], axis[1], axis[2], depth = 0.0, 0.0, 1.0, 2.0
        basis(axis, u, v)
        for i in range(n):
            azimuth[i] = atan2(x[i] * v[0] + y[i] * v[1] + z[i] * v[2], x[i] * u[0] + y[i] * u[1] + z[i] * u[2])
            across[i] = azimuth[i] / TURN + 0.5
        heights_about(x, y, z, n, axis, x)
        if not full:
            low = hole_below(x, azimuth, n, depth, blur / radius, spare)
        for i in range(n):
            x[i] = (x[i] - low) / (depth - low)
        middle = max(sqrt(1.0 - (1.0 - (low + depth) / 2.0) * (1.0 - (low + depth) / 2.0)), TINY)
        size = angle_of(depth) - angle_of(low)
        found = covered(x, across, n, size / (TURN * middle), <unsigned char *> spare)
    free(room)
    return (axis[0], axis[1], axis[2]), depth, low, full, found


cdef double angle_of(double height) noexcept nogil:
    """From the axis; of 1 - cos of it."""
    return 2.0 * asin(sqrt(height / 2.0))


cdef object ring_of(const Cover *cover, Py_ssize_t ring, const Mesh *mesh, const double *places):
    """The corners (K, 2) of a ring, from the first place on."""
    cdef Py_ssize_t start = cover.starts[ring], count = cover.starts[ring + 1] - start, i, lowest = 0
    cdef int32_t corner
    cdef double[:, ::1] view
    found = np.empty((count, 2))
    view = found
    for i in range(count):
        if mesh.corner[cover.edges[start + i]] < mesh.corner[cover.edges[start + lowest]]:
            lowest = i
    for i in range(count):
        corner = mesh.corner[cover.edges[start + (lowest + i) % count]]
        view[i, 0], view[i, 1] = places[2 * corner], places[2 * corner + 1]
    return found


cdef object pieces_of(const Cover *cover, const Mesh *mesh, const double *places):
    """Each outer ring, and the holes in it."""
    cdef Py_ssize_t k, l
    found = []
    for k in range(cover.rings):
        if cover.areas[k] > 0.0:
            holes = [l for l in range(cover.rings) if cover.areas[l] < 0.0 and cover.of[l] == cover.of[k]]
            found.append([ring_of(cover, l, mesh, places) for l in [k, *holes]])
    return found


cdef object concave(const double *places, Py_ssize_t n, const double *ring, Py_ssize_t corners):
    """What different places (n, 2) fill, as pieces, mean spacing, and the places (E, 2) at their edges.

    None where that is their convex outline (corners, 2).
    """
    cdef double reach = 2.0 * sqrt((log(<double> n) + CHANCE + 3.0) / (TURN / 2.0))
    cdef Py_ssize_t i, count
    cdef Near near
    cdef Mesh mesh
    cdef Cover cover
    cdef int32_t *triangles = NULL
    cdef double *seen = NULL
    cdef bint filled = True, enough = False
    near.rows, cover.needed, mesh.triangles = NULL, NULL, 0
    with nogil:
        if near_edges(places, n, &near):
            seen = <double *> malloc((6 * near.n + 1) * sizeof(double))
            triangles = <int32_t *> malloc(mesh_room(near.n) * sizeof(int32_t))
        if seen != NULL and triangles != NULL:
            sort_places(near.rows, near.n, 3, seen)
            count = once_each(near.rows, near.n, 3, near.rows)
            for i in range(count):
                seen[2 * i], seen[2 * i + 1], seen[2 * near.n + i] = (
                    near.rows[3 * i], near.rows[3 * i + 1], near.rows[3 * i + 2]
                )
            if count >= 3:
                triangulate(&mesh, seen, count, triangles)
            enough = mesh.triangles == 0 or room_of_cover(&cover, &mesh)
            if enough and mesh.triangles > 0:
                cover_most(
                    &cover, seen + 2 * near.n, reach, SMALLEST * near.mean_spacing * near.mean_spacing, n // MOST_STRAY
                )
                filled = fills(&cover, ring, corners, reach * near.mean_spacing / 2.0)
    try:
        if not enough:
            raise MemoryError
        pieces = None if filled else pieces_of(&cover, &mesh, seen)
        if not pieces:
            return None
        return pieces, near.mean_spacing, copied(near.edge, near.edges)
    finally:
        free(cover.needed)
        free(triangles)
        free(seen)
        free(near.rows)


cdef object copied(const double *places, Py_ssize_t n):
    cdef Py_ssize_t i
    cdef double[:, ::1] view
    found = np.empty((n, 2))
    view = found
    for i in range(n):
        view[i, 0], view[i, 1] = places[2 * i], places[2 * i + 1]
    return found


cdef void turn(const double *places, Py_ssize_t n, const double *along, double *turned) noexcept nogil:
    """Places (n, 2) as seen along a direction and across it, to its left."""
    cdef double x, y
    cdef Py_ssize_t i
    for i in range(n):
        x, y = places[2 * i], places[2 * i + 1]
        turned[2 * i], turned[2 * i + 1] = x * along[0] + y * along[1], y * along[0] - x * along[1]


def plane(
    const double[:, ::1] points, const double[::1] point, const double[::1] first, const double[::1] second,
    double blur
):
    """Of points (N, 3), seen along two directions across the normal; see `fitting.extents.plane`.

    None where they are on one line. Else the corners (K, 2) of the convex outline, its area, its coverage; its rectangle
    as the direction of the longer side, that of the shorter one, middle, and sizes; a direction (2,), and what `concave`
    answers as seen along that and across it, to its left.
    """
    cdef Py_ssize_t i, n = points.shape[0], count, left = 0
    cdef double *room = room_for(14 * n + 16)
    cdef double *ended = room + 2 * n
    cdef double *ring = room + 4 * n
    cdef double *spare = room + 6 * n + 4
    cdef Py_ssize_t *corners = <Py_ssize_t *> (room + 12 * n + 8)
    cdef double away[3]
    cdef double area, coverage
    cdef Rectangle even, about
    cdef int k
    with nogil:
        for i in range(n):
            for k in range(3):
                away[k] = points[i, k] - point[k]
            room[2 * i], room[2 * i + 1] = dot(away, &first[0]), dot(away, &second[0])
        sort_places(room, n, 2, spare)
        n = outlined(room, n, corners, ring, &count)
        if count > 0:
            even = rectangle_about(ring, count)
            left = between_ends(room, n, even.along, blur, ended, spare)
            count = hull_of(ended, left, corners) if left > 2 else 0
        if count > 2:
            take(ended, corners, count, ring)
            area = twice_area(ring, count) / 2.0
            about = rectangle_about(ring, count)
            turn(ended, left, about.along, ended)
            turn(ring, count, about.along, spare)
            coverage = covered_inside(ended, left, spare, count)
            n = once_each(room, n, 2, room)
            turn(room, n, even.along, room)
            turn(ring, count, even.along, spare)
    try:
        if count < 3:
            return None
        if coverage < 0.0:
            raise MemoryError
        pieces = None
        if n >= FEWEST and count <= max(MOST_OUTER, OUTER_SHARE * n):
            pieces = concave(room, n, spare, count)
        sides = np.array([about.along, about.across, about.middle, about.size])
        return copied(ring, count), area, coverage, sides, np.array(even.along), pieces
    finally:
        free(room)


def depths(const double[:, ::1] places, const double[:, ::1] edges):
    """How deep places (N, 2) are inside rings, negative outside, by the two ends (E, 4) of each edge of all rings."""
    cdef Py_ssize_t i, n = edges.shape[0]
    cdef double x, y
    cdef double *room = room_for(5 * n)
    cdef double[::1] view
    found = np.empty(places.shape[0])
    view = found
    with nogil:
        for i in range(n):
            x, y = edges[i, 2] - edges[i, 0], edges[i, 3] - edges[i, 1]
            room[i], room[n + i], room[2 * n + i], room[3 * n + i] = edges[i, 0], edges[i, 1], x, y
            room[4 * n + i] = 1.0 / (x * x + y * y + TINY)
        for i in range(places.shape[0]):
            view[i] = depth_in(room, n, places[i, 0], places[i, 1])
    free(room)
    return found
