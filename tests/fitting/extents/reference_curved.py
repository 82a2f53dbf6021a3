"""What is compiled of the extents of curved kinds, in NumPy: the same answers, tens of calls each."""

import math
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from scipy.spatial import cKDTree

from primfit.fitting.extents.sphere import SPREAD
from primfit.fitting.geometry.vectors import TINY, Z_AXIS, Array, around_axis, basis, unit, vector
from primfit.fitting.primitives.primitive import Primitive

NEXT = 4
STRAY = 5.0
"""An outermost point is stray if it and the next four are this many times as far apart as those inside."""

MOST_STRAY = 20
"""At most one in so many points is dropped at an end."""

FEWEST = 40
"""With fewer points the outermost ones are the ends."""

BLURRED = 0.4
"""Noise carries points over a sharp end: as many as there are in this many of its standard deviations."""

BLUR_BAND = 10.0
"""Width, in standard deviations, in which the points at an end are counted for that."""

CHANCE = 4.6
"""A gap is real if fewer than one in 100 of clouds without a gap have one: -log 0.01."""

USUAL_GAPS = 5
USUAL = 2.0
"""It must also be this many times the fifth largest gap: scan lines leave equal ones."""

SPARSE = 0.1
"""Sectors with less than this share of the mean number of points may be part of a gap."""

POINTS_A_CELL = 5
"""Cells that points are counted in hold so many on average; of random points 0.7% of the cells are empty."""


ASKED = 2000
"""... with so many of the points."""

NEAREST = 3
"""Fewer points than this in it do not fill a hole."""

OUTERMOST = 1000
"""So many points nearest to the rim of a cap move its axis ..."""

ALL_ROUND = 500
"""... with about so many of all, since those nearest may lie on one side."""

LARGEST_STEP, SMALLEST_STEP = 0.2, 0.001
"""Angles by which the axis of a cap is moved while that makes the cap smaller."""

WAYS = np.stack([np.cos(np.arange(12) * np.pi / 6.0), np.sin(np.arange(12) * np.pi / 6.0)], axis=1)
"""Directions of the moves that are tried, across the axis."""


NEAR_AXIS = 0.25


@dataclass(frozen=True)
class Around:
    """Cylindrical coordinates: `angle` counts from `reference` towards axis x reference, as in `surface`."""

    reference: Array
    angle: Array
    rho: Array
    height: Array

    @classmethod
    def of(cls, points: Array, origin: Array, axis: Array) -> Self:
        radial, rho, height = around_axis(points, origin, axis)
        first, second = basis(axis)
        return cls(vector(first), np.arctan2(radial @ second, radial @ first), rho, height)

    @property
    def steady(self) -> np.ndarray:
        """Mask of the points whose angles count."""
        return self.rho >= NEAR_AXIS * self.rho.max()

    def share(self, start: float, span: float) -> Array:
        """How far round the arc each point is: 0 at its start, 1 at its end; others near one of them."""
        middle = start + span / 2.0
        off = np.mod(self.angle - middle + np.pi, 2.0 * np.pi) - np.pi
        return 0.5 + off / max(span, TINY)


def ends(values: Array, blur: tuple[float, float] = (0.0, 0.0)) -> tuple[float, float]:
    """Where values (N,) of about even density begin and end.

    Parameters
    ----------
    blur : standard deviation of the noise in the values at the lower and at the upper end
    """
    return _ends(np.sort(values), blur)


def _ends(ordered: Array, blur: tuple[float, float]) -> tuple[float, float]:
    return _first(ordered, blur[0]), -_first(-ordered[::-1], blur[1])


def _first(ordered: Array, blur: float) -> float:
    """The lower end: without the stray points before it, and without what noise carried over it."""
    n, start = len(ordered), 0
    same = 1e-12 * (ordered[-1] - ordered[0])
    if n >= FEWEST:
        inner = max(20, n // MOST_STRAY)
        k = np.arange(n // MOST_STRAY + 1)
        usual = (ordered[k + NEXT + inner] - ordered[k + NEXT]) / inner
        start = int(np.argmin(ordered[k + NEXT] - ordered[k] > NEXT * STRAY * usual + same))
    if blur > 0.0:
        near = np.searchsorted(ordered, ordered[start] + BLUR_BAND * blur) - start
        start += int(BLURRED / BLUR_BAND * near)
    return float(ordered[min(start, n - 1)])


def turn(angles: Array, blur: float = 0.0, evenness: float = 1.0) -> tuple[float, float, bool]:
    """The arc that angles (N,) fill: what the largest gap leaves of the circle.

    Parameters
    ----------
    blur : standard deviation of the noise in the angles
    evenness : density of the points where it is lowest, over its mean

    Returns
    -------
    start in [0, 2 pi), span, and whether it is the full circle: no gap larger than chance or the pattern of
    a scan explains. Then start is 0 and span 2 pi.
    """
    n = len(angles)
    circle = np.sort(np.mod(angles, 2.0 * np.pi))
    gaps = np.diff(circle, append=circle[0] + 2.0 * np.pi)
    widest = int(np.argmax(gaps))
    cuts = (circle[widest] + gaps[widest] / 2.0, _sparsest(circle))
    gap, cut = max((2.0 * np.pi - _arc(circle, cut, 0.0)[1], float(cut)) for cut in cuts)
    chance = 2.0 * np.pi * (np.log(n) + CHANCE) / (n * max(evenness, 1e-9))
    usual = USUAL * float(np.partition(gaps, -USUAL_GAPS)[-USUAL_GAPS]) if n > USUAL_GAPS else 0.0
    if gap <= max(min(chance, np.pi), usual):
        return 0.0, 2.0 * np.pi, True
    start, span = _arc(circle, cut, blur)
    return float(np.mod(start, 2.0 * np.pi)), span, False


def _arc(circle: Array, cut: float, blur: float) -> tuple[float, float]:
    """Start and span of sorted angles seen from a place where there are none."""
    first = int(np.searchsorted(circle, cut))
    ordered = np.concatenate([circle[first:] - cut, circle[:first] - cut + 2.0 * np.pi])
    low, high = _ends(ordered, (blur, blur))
    return low + cut, high - low


def _sparsest(circle: Array) -> float:
    """The middle of the longest run of sectors that hold few points, stray ones for instance."""
    sectors = int(np.clip(len(circle) // 40, 8, 720))
    counts = np.bincount((circle * (sectors / (2.0 * np.pi))).astype(np.intp) % sectors, minlength=sectors)
    sparse = counts < SPARSE * len(circle) / sectors
    if not sparse.any() or sparse.all():
        return 0.0
    dense = np.flatnonzero(~sparse)
    runs = np.diff(dense, append=dense[0] + sectors)
    longest = int(np.argmax(runs))
    return float((dense[longest] + 0.5 + runs[longest] / 2.0) * 2.0 * np.pi / sectors)


def coverage(along: Array, across: Array, aspect: float) -> float:
    """Share of a trimmed surface near which there are points.

    The surface is cut into cells of equal area, as nearly square as their number allows, `POINTS_A_CELL`
    times as large as the share of one point; a cell is covered that holds a point.

    Parameters
    ----------
    along, across : (N,) coordinates of the points; equal areas of the surface are equal areas of the unit
        square, and points outside it count at its edge
    aspect : length of the surface along the first over its length along the second
    """
    wanted = max(len(along) / POINTS_A_CELL, 1.0)
    rows = int(np.clip(np.round(np.sqrt(wanted * aspect)), 1, wanted))
    columns = max(int(wanted / rows), 1)
    cells = cell(along, rows) * columns + cell(across, columns)
    return float(np.count_nonzero(np.bincount(cells)) / (rows * columns))


def cell(shares: Array, number: int) -> np.ndarray:
    """In which of a number of equal parts of [0, 1] each value lies; values over a span of 0 in the first."""
    return np.clip((np.clip(np.nan_to_num(shares), 0.0, 1.0) * number).astype(np.intp), 0, number - 1)


def cylinder(primitive: Any, feet: Array, blur: float) -> dict[str, Any]:
    seen = Around.of(feet, primitive.point, primitive.axis)
    low, high = ends(seen.height, (blur, blur))
    start, span, full = turn(seen.angle, blur / primitive.radius)
    tall, arc = high - low, span * primitive.radius
    along = (seen.height - low) / max(tall, TINY)
    share = seen.share(start, span)
    return {
        "length": tall,
        "start_angle": start,
        "span": span,
        "full_turn": full,
        "area": arc * tall,
        "coverage": coverage(along, share, tall / max(arc, TINY)),
        "start": primitive.point + low * primitive.axis,
    }


def cone(primitive: Any, feet: Array, blur: float) -> dict[str, Any]:
    seen = Around.of(feet, primitive.apex, primitive.axis)
    height = np.maximum(seen.height, 0.0)
    # Squares of heights are areas: along them points are evenly dense.
    steepness = 2.0 * blur * np.cos(primitive.half_angle)
    low2, high2 = ends(height**2, (steepness * height.min(), steepness * height.max()))
    inside = low2 * len(feet) <= CHANCE * (high2 - low2)
    low, high = 0.0 if inside else float(np.sqrt(low2)), float(np.sqrt(high2))
    steady = seen.steady
    start, span, full = turn(seen.angle[steady], blur / max(float(np.median(seen.rho[steady])), TINY))
    tangent = float(np.tan(primitive.half_angle))
    arc, slant = span * tangent * (low + high) / 2.0, (high - low) / np.cos(primitive.half_angle)
    along = (height**2 - low**2) / max(high**2 - low**2, TINY)
    return {
        "start_height": low,
        "end_height": high,
        "apex_inside": bool(inside),
        "start_angle": start,
        "span": span,
        "full_turn": full,
        "area": float(arc * slant),
        "coverage": coverage(along, seen.share(start, span), slant / max(arc, TINY)),
    }


def torus(primitive: Any, feet: Array, blur: float) -> dict[str, Any]:
    major, minor = primitive.major_radius, primitive.minor_radius
    seen = Around.of(feet, primitive.center, primitive.axis)
    seen = Around.of(feet, primitive.center, primitive.axis)
    steady = seen.steady
    start, span, full = turn(seen.angle[steady], blur / max(float(np.median(seen.rho[steady])), TINY))
    tube = np.arctan2(seen.height, seen.rho - major)
    tube_blur = blur / max(minor, TINY)
    if major > minor:
        low, tube_span, tube_full = turn(tube, tube_blur, (major - minor) / major)
    else:
        low, high = ends(tube, (tube_blur, tube_blur))
        tube_span, tube_full = high - low, False
    # The area up to an angle, over minor_radius and span.
    middle = low + tube_span / 2.0
    unwrapped = middle + np.mod(tube - middle + np.pi, 2.0 * np.pi) - np.pi
    grown = major * (unwrapped - low) + minor * (np.sin(unwrapped) - np.sin(low))
    whole = float(major * tube_span + minor * (np.sin(low + tube_span) - np.sin(low)))
    area = minor * span * whole
    length = minor * tube_span
    share = seen.share(start, span)
    return {
        "start_angle": start,
        "span": span,
        "full_turn": full,
        "area": area,
        "tube_span": tube_span,
        "tube_start_angle": float(np.mod(low, 2.0 * np.pi)),
        "tube_full_turn": tube_full,
        "coverage": coverage(grown / max(whole, TINY), share, length**2 / max(area, TINY)),
    }


def sphere(primitive: Any, feet: Array, blur: float) -> dict[str, Any]:
    directions = (feet - primitive.center) / primitive.radius
    radius = primitive.radius
    axis, depth = _cap(directions, blur / radius)
    # Points left to chance leave a cap empty, of this share of the area at most.
    chance = (np.log(len(feet)) + CHANCE + 2.0) / len(feet)
    full = (2.0 - depth) / 2.0 <= min(chance, 0.25)
    if full:
        axis, depth = Z_AXIS, 2.0
    first, second = basis(axis)
    azimuth = np.arctan2(directions @ second, directions @ first)
    heights = _heights(directions, axis)
    low = 0.0 if full else _hole(heights, depth, azimuth, blur / radius)
    half_angle, start = _angle(depth), _angle(low)
    middle = np.sqrt(1.0 - (1.0 - (low + depth) / 2.0) ** 2)
    aspect = (half_angle - start) / (2.0 * np.pi * max(middle, TINY))
    return {
        "axis": axis,
        "half_angle": half_angle,
        "start_half_angle": start,
        "full_sphere": bool(full),
        "area": 2.0 * np.pi * radius**2 * (depth - low),
        "coverage": coverage((heights - low) / (depth - low), azimuth / (2.0 * np.pi) + 0.5, aspect),
    }


def _angle(height: float) -> float:
    """From the axis; of 1 - cos of it."""
    return float(2.0 * np.arcsin(np.sqrt(height / 2.0)))


def _hole(heights: Array, depth: float, azimuth: Array, blur: float) -> float:
    """The height where a zone begins; 0 of a cap, whose middle holds points or which is not full around."""
    least = max(float(heights.min()), 0.0)
    if least * len(heights) <= CHANCE * depth:
        return 0.0
    low = float(np.clip(ends(heights, (blur * np.sqrt(least * (2.0 - least)), 0.0))[0], 0.0, depth))
    angles = np.sort(np.arccos(1.0 - np.clip(heights, 0.0, 2.0)))
    usual = (
        float(np.partition(np.diff(angles), -USUAL_GAPS)[-USUAL_GAPS]) if len(angles) > USUAL_GAPS else 0.0
    )
    if _angle(low) <= USUAL * usual or low >= depth or not turn(azimuth)[2]:
        return 0.0
    return low


def _cap(directions: Array, blur: float) -> tuple[Array, float]:
    """Axis of the smallest cap about unit vectors (N, 3), and its height, 1 - cos of its half-angle."""
    axis = _start(directions)
    depth = 2.0
    for _ in range(2):
        heights = _heights(directions, axis)
        depth = _rim(heights, blur)
        held = directions[heights <= depth]
        if len(held) < 3:
            break
        outermost = np.argpartition(held @ axis, min(OUTERMOST, len(held) - 1))[:OUTERMOST]
        axis = _tightened(axis, np.concatenate([held[outermost], held[:: -(-len(held) // ALL_ROUND)]]))
    return axis, _rim(_heights(directions, axis), blur)


def _heights(directions: Array, axis: Array) -> Array:
    """1 - cos of the angles to the axis; of small caps, too, whose cosines are all 1."""
    apart = directions - axis
    return np.einsum("ij,ij->i", apart, apart) / 2.0


def _rim(heights: Array, blur: float) -> float:
    """Where the heights of the points on a cap end; equal heights are equal areas."""
    highest = min(float(heights.max()), 2.0)
    slope = np.sqrt(max(highest * (2.0 - highest), 0.0))
    return float(np.clip(ends(heights, (0.0, blur * slope))[1], TINY, 2.0))


def _start(directions: Array) -> Array:
    """An axis away from where there are no points: their mean, or the best of many directions."""
    mean = directions.mean(axis=0)
    size = np.sqrt(mean @ mean)
    if size > 0.5:  # the mean of a hemisphere
        return unit(mean)
    sample = directions[:: -(-len(directions) // ASKED)]
    tree = cKDTree(sample, balanced_tree=False, compact_nodes=False)
    apart = tree.query(-SPREAD, k=[min(NEAREST, len(sample))])[0][:, 0]
    return unit(SPREAD[np.argmax(apart)])


def _tightened(axis: Array, directions: Array) -> Array:
    """The axis of the smallest cap near that of a given one, moved while the cap becomes smaller."""
    across = np.ascontiguousarray(directions.T)
    step, lowest = LARGEST_STEP, float((axis @ across).min())
    while step > SMALLEST_STEP:
        tried = math.cos(step) * axis + math.sin(step) * (WAYS @ np.array(basis(axis)))
        reached = (tried @ across).min(axis=1)
        best = int(reached.argmax())
        if reached[best] > lowest:
            axis, lowest = tried[best], float(reached[best])
        else:
            step /= 2.0
    return unit(axis)


def feet_of(primitive: Primitive, points: Array) -> Array:
    return points - primitive.signed_distance(points)[:, None] * primitive.gradient(points)
