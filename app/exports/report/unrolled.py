"""The residuals on the unrolled surface: along u and v of the kind, as mean values of cells or as points."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from primfit.fitting.geometry.vectors import Array

from ..colors import SATURATED
from ..drawing import DRAWINGS
from ..drawing.unrolled import Unrolled
from ..fitted import Fitted
from .markup import Markup, element, joined
from .numbers import Unit, count
from .ranges import range_about
from .scene import SHOWN_POINTS
from .svg import Axis, beyond, color_bar, colored, dot_size, dots, picture, text

LEFT, RIGHT, TOP, BOTTOM = 950, 350, 420, 1250
WIDTH, HIGHEST = 6000, 2500
NARROWEST = 0.25
"""A side is at least this share of the other; where it is stretched for that, its name says so."""

OUTSIDE, MARGIN = 0.05, 0.02
"""How far points are shown beyond the trimmed surface, and what is left free, as shares of the range."""

MOST_CELLS, POINTS_A_CELL = 2600, 4.0
DOT = 30


@dataclass(frozen=True, eq=False)
class _Frame:
    """Where the map is in the picture, in tenths of a pixel.

    Attributes
    ----------
    low, span : (2,) the range of the map, in its coordinates
    left : of the frame
    size : (2,) of the frame
    stretched : which side is drawn larger than the other one's scale would have it, if any
    """

    low: Array
    span: Array
    left: float
    size: Array
    stretched: int | None

    @classmethod
    def of(cls, on: Unrolled, surface: Unrolled) -> Self:
        """About the points, as far as these are near the trimmed surface."""
        points, shown = (np.stack([each.across, each.along], axis=1) for each in (on, surface))
        low, high = range_about(points, shown, OUTSIDE * np.ptp(shown, axis=0))
        low, high = np.maximum(low, points.min(axis=0)), np.minimum(high, points.max(axis=0))
        span = np.maximum(high - low, 1e-12 * np.abs(low).max() + 1e-300)
        low, span = low - MARGIN * span, (1.0 + 2.0 * MARGIN) * span
        room = np.array([WIDTH - LEFT - RIGHT, HIGHEST], np.float64)
        size, stretched = room.copy(), None
        if all(on.lengths):
            size = span * float(np.min(room / span))
            least = NARROWEST * float(size.max())
            if ((narrow := int(np.argmin(size))) == 1 and size[1] < least) or size[0] < least:
                size[narrow], stretched = least, narrow
        return cls(low, span, LEFT + (room[0] - size[0]) / 2.0, size, stretched)

    @property
    def bottom(self) -> float:
        return TOP + float(self.size[1])

    def places(self, on: Unrolled) -> Array:
        """(N, 2)"""
        x = self.left + (on.across - self.low[0]) * (self.size[0] / self.span[0])
        y = self.bottom - (on.along - self.low[1]) * (self.size[1] / self.span[1])
        return np.stack([x, y], axis=1)


def unrolled_map(fitted: Fitted, limit: float, unit: str | None) -> Markup:
    """The residuals of the inliers, with axes and the colors: points where they are few, else cells."""
    inlier = fitted.residuals.inlier
    points, distance = fitted.points[inlier], fitted.residuals.distance[inlier]
    primitive, shape = fitted.primitive, fitted.shape
    unroll = DRAWINGS[primitive.kind].unrolled
    on = unroll(primitive, shape, points)
    surface = unroll(primitive, shape, shape.pieces().reshape(-1, 3))
    if surface.is_upright:
        on, surface = on.turned(), surface.turned()
    frame = _Frame.of(on, surface)
    place = frame.places(on)
    corner, size = np.array([frame.left, TOP]), frame.size
    nearest = np.clip(place, corner, corner + size)
    outside = np.any(place != nearest, axis=1)
    place, distance = place[~outside], distance[~outside]
    if len(points) <= SHOWN_POINTS:
        level, colors = colored(distance, limit)
        drawn = dots(place, level, colors, dot_size(DOT, len(place)))
    else:
        limit, drawn = _cells(place, distance, corner, size, limit)
    ground = element(
        "rect", x=round(frame.left), y=TOP, width=round(size[0]), height=round(size[1]), class_="frame"
    )
    hidden = int(outside.sum())
    return picture(
        WIDTH,
        round(frame.bottom + BOTTOM + (260 if hidden else 0)),
        ground,
        drawn,
        beyond(nearest[outside], DOT),
        _across(on, frame, unit),
        _upwards(on, frame, unit),
        _key(round(frame.bottom), limit, unit, hidden),
        title="residuals on the unrolled surface",
    )


def _cells(place: Array, distance: Array, corner: Array, size: Array, limit: float) -> tuple[float, Markup]:
    """Mean residuals of the points in each cell, and where their colors end; others stay empty."""
    wanted = min(len(place) / POINTS_A_CELL, MOST_CELLS)
    side = float(np.sqrt(size[0] * size[1] / wanted))
    columns, rows = (max(round(float(length) / side), 1) for length in size)
    step = size / (columns, rows)
    cell = np.clip(((place - corner) / step).astype(np.intp), 0, (columns - 1, rows - 1))
    number = cell[:, 1] * columns + cell[:, 0]
    count = np.bincount(number, minlength=rows * columns)
    filled = np.flatnonzero(count)
    mean = np.bincount(number, distance, rows * columns)[filled] / count[filled]
    limit = min(float(np.percentile(np.abs(mean), SATURATED)), limit)
    level, colors = colored(mean, limit)
    x = np.rint(corner[0] + np.arange(columns + 1) * step[0]).astype(int)
    y = np.rint(corner[1] + np.arange(rows + 1) * step[1]).astype(int)
    parts = []
    for i, color in enumerate(colors):
        chosen = filled[level == i]
        if len(chosen):
            pieces = (
                f"M{x[c]} {y[r]}h{x[c + 1] - x[c]}v{y[r + 1] - y[r]}H{x[c]}z"
                for r, c in zip(*np.divmod(chosen, columns), strict=True)
            )
            parts.append(element("path", d="".join(pieces), fill=color))
    return limit, element("g", *parts, shape_rendering="crispEdges")


def _axis(on: Unrolled, frame: _Frame, unit: str | None, way: int) -> tuple[Axis, Array, str]:
    """The axis of either way, how far along the frame each of its numbers is, and its name."""
    low, span = float(frame.low[way]), float(frame.span[way])
    is_length = on.lengths[way]
    of = Unit("degrees")
    if is_length:
        # Both sides in one unit where both are lengths.
        ways = [other for other in (0, 1) if on.lengths[other]]
        of = Unit.of(float(np.abs([frame.low[ways], (frame.low + frame.span)[ways]]).max()), unit)
    axis = Axis.of(low * of.factor, (low + span) * of.factor, float(frame.size[way]), is_upright=way == 1)
    name = axis.named(on.names[way], of.name) + (", stretched" if frame.stretched == way else "")
    along = (np.array(axis.values) / of.factor - low) * (frame.size[way] / span)
    return axis, along, name


def _across(on: Unrolled, frame: _Frame, unit: str | None) -> Markup:
    axis, along, name = _axis(on, frame, unit, 0)
    parts: list[Markup] = []
    bottom = round(frame.bottom)
    for x, label in zip(along + frame.left, _turned(axis, on.lengths[0]), strict=True):
        parts.append(element("path", d=f"M{round(x)} {bottom}v50", class_="line"))
        parts.append(text(x, bottom + 240, label, "middle"))
    return joined([*parts, text((LEFT + WIDTH - RIGHT) / 2.0, bottom + 500, name, "middle", class_="name")])


def _upwards(on: Unrolled, frame: _Frame, unit: str | None) -> Markup:
    axis, along, name = _axis(on, frame, unit, 1)
    parts: list[Markup] = []
    left = round(frame.left)
    for y, label in zip(frame.bottom - along, _turned(axis, on.lengths[1]), strict=True):
        parts.append(element("path", d=f"M{left} {round(y)}h-50", class_="line"))
        parts.append(text(left - 90, y + 60, label, "end"))
    return joined([*parts, text(min(left, LEFT) - 700, TOP - 160, name, class_="name")])


def _turned(axis: Axis, is_length: bool) -> list[str]:
    """Degrees start again after a full turn."""
    if is_length or axis.less:
        return axis.labels
    return [
        label if value < 360.0 else f"{float(label) - 360.0:g}"
        for value, label in zip(axis.values, axis.labels, strict=True)
    ]


def _key(bottom: int, limit: float, unit: str | None, hidden: int) -> Markup:
    """The colors and what they stand for."""
    x, width, y = 2000, 2900, bottom + 720
    of = Unit.of(limit, unit)
    parts = [text(x + width / 2.0, y + 400, "0", "middle"), color_bar(x, y, width, 150)]
    if limit > 0.0:
        ends = ((x, f"\u2212{of.short(limit)}"), (x + width, f"+{of.said(limit)}"))
        parts += [text(at, y + 400, said, "middle") for at, said in ends]
    if hidden:
        parts.append(text(x + width / 2.0, y + 680, f"{count(hidden, 'point')} beyond the map", "middle"))
    return joined(parts)
