"""The residuals on the unrolled surface: along u and v of the kind, as mean values of cells or as points."""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from primfit.fitting.extents.plane import PlaneExtents
from primfit.fitting.geometry.vectors import Array, around_axis, cross
from primfit.fitting.primitives.cylinder import Cylinder
from primfit.fitting.primitives.sphere import Sphere
from primfit.fitting.primitives.torus import Torus

from ..colors import SATURATED
from ..fitted import Fitted
from ..patch import Patch, Pieces
from .markup import Markup, element, joined
from .scene import SHOWN_POINTS
from .svg import color_bar, colored, dot_size, dots, picture, text, ticks

LEFT, RIGHT, TOP, BOTTOM = 900, 200, 160, 1000
WIDTH, HIGHEST, NARROWEST = 10000, 4600, 200
MOST_CELLS, POINTS_A_CELL = 2600, 4.0
DOT = 34
BOTH, NEITHER = (True, True), (False, False)


@dataclass(frozen=True, eq=False)
class Unrolled:
    """Points on the unrolled surface.

    Attributes
    ----------
    across, along : (N,) coordinates; lengths or degrees
    names : what they are, with the unit
    lengths : which of them are

    A cap of no more than a hemisphere is laid flat with true distances from its middle.
    """

    across: Array
    along: Array
    names: tuple[str, str]
    lengths: tuple[bool, bool]

    @classmethod
    def of(cls, fitted: Fitted, patch: Patch | Pieces, points: Array, unit: str) -> Self:
        extents = fitted.recognition.extents
        if isinstance(extents, PlaneExtents):
            relative = points - extents.center
            names = (f"along the length [{unit}]", f"along the width [{unit}]")
            return cls(relative @ extents.length_direction, relative @ extents.width_direction, names, BOTH)
        assert isinstance(patch, Patch)
        radial, rho, height = around_axis(points, patch.origin, patch.axis)
        beyond = cross(patch.axis, patch.reference)
        middle = float(np.mean(patch.u))
        angle = _about(np.arctan2(radial @ beyond, radial @ patch.reference), middle)
        degrees = np.degrees(angle)
        match patch.primitive:
            case Cylinder(radius=radius):
                names = (f"around the axis, as length [{unit}]", f"along the axis [{unit}]")
                return cls(radius * (angle - patch.u[0]), height - patch.v[0], names, BOTH)
            case Sphere(radius=radius) if patch.v[0] >= 0.0:
                away = radius * (np.pi / 2.0 - np.arctan2(height, rho))
                name = f"from the middle of the cap [{unit}]"
                return cls(away * np.cos(angle), away * np.sin(angle), (name, name), BOTH)
            case Sphere():
                names = ("around the axis of the cap [degrees]", "above its equator [degrees]")
                return cls(degrees, np.degrees(np.arctan2(height, rho)), names, NEITHER)
            case Torus(major_radius=major):
                tube = _about(np.arctan2(height, rho - major), float(np.mean(patch.v)))
                names = ("around the axis [degrees]", "around the tube [degrees]")
                return cls(degrees, np.degrees(tube), names, NEITHER)
        return cls(degrees, height, ("around the axis [degrees]", f"from the apex [{unit}]"), (False, True))

    def lying(self) -> Self:
        """The same with the longer side across, where both are lengths."""
        if not all(self.lengths) or np.ptp(self.along) <= np.ptp(self.across):
            return self
        return replace(self, across=self.along, along=self.across, names=self.names[::-1])


def _about(angle: Array, middle: float) -> Array:
    """Angles within half a turn of the middle."""
    return (angle - middle + np.pi) % (2.0 * np.pi) - np.pi + middle


def unrolled_map(fitted: Fitted, patch: Patch | Pieces, limit: float, unit: str) -> Markup:
    """The residuals of the inliers, with axes and the colours: points where they are few, else cells."""
    inlier = fitted.residuals.inlier
    points, distance = fitted.points[inlier], fitted.residuals.distance[inlier]
    on = Unrolled.of(fitted, patch, points, unit).lying()
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
