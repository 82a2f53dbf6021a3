"""Where points begin and end along a line or around a circle, and how densely they cover what is between.

A few stray points beyond an end, and noise along the surface, must not widen it.
"""

import numpy as np

from ..geometry.vectors import Array

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
"""Cells that points are counted in hold so many on average; of random points 0.7 % of the cells are empty."""


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
    if n >= FEWEST:
        inner = max(20, n // MOST_STRAY)
        k = np.arange(n // MOST_STRAY + 1)
        apart = (ordered[k + NEXT] - ordered[k]) / NEXT
        usual = (ordered[k + NEXT + inner] - ordered[k + NEXT]) / inner
        start = int(np.argmin(apart > STRAY * usual))
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
