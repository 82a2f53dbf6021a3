"""The residuals on the unrolled surface: along u and v of the kind, as mean values of cells or as points."""

import numpy as np

from primfit.fitting.geometry.vectors import Array

from ..colors import SATURATED
from ..drawing import DRAWINGS
from ..drawing.unrolled import Unrolled
from ..fitted import Fitted
from .markup import Markup, element, joined
from .scene import SHOWN_POINTS
from .svg import color_bar, colored, dot_size, dots, picture, text, ticks

LEFT, RIGHT, TOP, BOTTOM = 900, 200, 160, 1000
WIDTH, HIGHEST, NARROWEST = 10000, 4600, 200
MOST_CELLS, POINTS_A_CELL = 2600, 4.0
DOT = 34


def unrolled_map(fitted: Fitted, limit: float, unit: str) -> Markup:
    """The residuals of the inliers, with axes and the colours: points where they are few, else cells."""
    inlier = fitted.residuals.inlier
    points, distance = fitted.points[inlier], fitted.residuals.distance[inlier]
    primitive = fitted.primitive
    on = DRAWINGS[primitive.kind].unrolled(primitive, fitted.shape, points, unit).lying()
    low = np.array([on.across.min(), on.along.min()])
    span = np.maximum(np.array([on.across.max(), on.along.max()]) - low, 1e-12 * np.abs(low).max() + 1e-300)
    room = np.array([WIDTH - LEFT - RIGHT, HIGHEST])
    if all(on.lengths):
        size = np.maximum(span * float(np.min(room / span)), NARROWEST)
    else:
        size = np.array([room[0], 0.75 * HIGHEST])
    scale = size / span
    left = LEFT + (room[0] - size[0]) / 2.0
    height = round(TOP + size[1] + BOTTOM)
    x = left + (on.across - low[0]) * scale[0]
    y = TOP + size[1] - (on.along - low[1]) * scale[1]
    place = np.stack([x, y], axis=1)
    if len(points) <= SHOWN_POINTS:
        level, colors = colored(distance, limit)
        drawn = dots(place, level, colors, dot_size(DOT, len(place)))
    else:
        limit, drawn = _cells(place, distance, np.array([left, TOP]), size)
    frame = element("rect", x=round(left), y=TOP, width=round(size[0]), height=round(size[1]), class_="frame")
    return picture(
        WIDTH,
        height,
        frame,
        drawn,
        _ticks(on, low, span, scale, left, size),
        _key(height, limit, unit),
        title="residuals on the unrolled surface",
    )


def _cells(place: Array, distance: Array, corner: Array, size: Array) -> tuple[float, Markup]:
    """Mean residuals of the points in each cell, and where their colours end; others stay empty."""
    wanted = min(len(place) / POINTS_A_CELL, MOST_CELLS)
    side = float(np.sqrt(size[0] * size[1] / wanted))
    columns, rows = (max(round(float(length) / side), 1) for length in size)
    step = size / (columns, rows)
    cell = np.clip(((place - corner) / step).astype(np.intp), 0, (columns - 1, rows - 1))
    number = cell[:, 1] * columns + cell[:, 0]
    count = np.bincount(number, minlength=rows * columns)
    filled = np.flatnonzero(count)
    mean = np.bincount(number, distance, rows * columns)[filled] / count[filled]
    limit = float(np.percentile(np.abs(mean), SATURATED))
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


def _ticks(on: Unrolled, low: Array, span: Array, scale: Array, left: float, size: Array) -> Markup:
    parts: list[Markup] = []
    bottom = TOP + size[1]
    for value in ticks(low[0], low[0] + span[0], 10):
        x = round(left + (value - low[0]) * scale[0])
        parts.append(element("path", d=f"M{x} {round(bottom)}v50", class_="line"))
        parts.append(text(x, bottom + 210, _label(value, on.lengths[0]), "middle"))
    for value in ticks(low[1], low[1] + span[1], 6):
        y = round(bottom - (value - low[1]) * scale[1])
        parts.append(element("path", d=f"M{round(left)} {y}h-50", class_="line"))
        parts.append(text(left - 90, y + 50, _label(value, on.lengths[1]), "end"))
    parts.append(text(left + size[0] / 2.0, bottom + 430, on.names[0], "middle", class_="name"))
    x, y = left - 720, TOP + size[1] / 2.0
    turned = f"rotate(-90 {round(x)} {round(y)})"
    parts.append(text(x, y, on.names[1], "middle", class_="name", transform=turned))
    return joined(parts)


def _label(value: float, is_length: bool) -> str:
    """Degrees start again after a full turn."""
    return f"{value if is_length or value < 360.0 else value - 360.0:.6g}"


def _key(height: int, limit: float, unit: str) -> Markup:
    """The colours and what they stand for."""
    x, width, y = 3000, 4000, height - 380
    return joined(
        [
            color_bar(x, y, width, 120),
            text(x, y + 290, f"{-limit:.3g} {unit}", "middle"),
            text(x + width / 2.0, y + 290, "0", "middle"),
            text(x + width, y + 290, f"+{limit:.3g} {unit}", "middle"),
        ]
    )
