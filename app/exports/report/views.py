"""Views of the points with the trimmed primitive: shaded, with its edges, its axis and what is hidden."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.geometry.vectors import Array

from .markup import Markup, element, joined
from .scene import Camera, Scene, Surface
from .svg import PICTURE_STYLE, colored, dot_size, dots, line_path, nice, picture, text

SIZE, MARGIN, CORNER = 3600, 300, 120
DOT = 24

View = tuple[str, float, float]
ISOMETRIC: View = ("isometric", 45.0, float(np.degrees(np.arctan(np.sqrt(0.5)))))
VIEWS = (ISOMETRIC, ("from the side", 0.0, 0.0), ("from above", 0.0, 90.0))
"""Title, azimuth and elevation [degrees]."""

CELLS = 110
"""Cells each way of the picture in which the nearest surface is known."""

LIGHT = np.array([-0.35, 0.55, 0.76])
OUTSIDE, INSIDE = ((150, 166, 186), (88, 104, 126)), ((168, 150, 132), (104, 90, 78))
"""Colours in the light and in the shade, of either side of the surface."""

SHADES = 10
NEUTRAL = "#5b8fc9"


def views(scene: Scene, limit: float, unit: str) -> Markup:
    """Three figures, each with its scale."""
    return joined(
        element("figure", _view(scene, view, limit, unit), element("figcaption", view[0])) for view in VIEWS
    )


def lone_view(scene: Scene, limit: float, unit: str) -> Markup:
    """The isometric view with its own style: a file, or a part of any page."""
    ground = element("rect", width=SIZE, height=SIZE, fill="#f5f7f9")
    beside = (element("style", PICTURE_STYLE), ground)
    return _view(scene, ISOMETRIC, limit, unit, *beside, xmlns="http://www.w3.org/2000/svg")


@dataclass(frozen=True, eq=False)
class _Frame:
    """From points to places (N, 2) in the picture and depths (N,), both in tenths of a pixel.

    `middle` (3,) comes to the middle of the picture, and what is `radius` beside it to the margin.
    """

    camera: Camera
    middle: Array
    radius: float

    @classmethod
    def about(cls, points: Array, camera: Camera) -> Self:
        """That holds all the points (N, 3)."""
        origin = points[0]
        seen = camera.seen(points - origin)
        low, high = seen.min(axis=0), seen.max(axis=0)
        axes = np.stack([camera.right, camera.up, camera.toward])
        return cls(camera, origin + (low / 2.0 + high / 2.0) @ axes, float(np.max((high - low)[:2])) / 2.0)

    def places(self, points: Array) -> tuple[Array, Array]:
        seen = self.camera.seen((points - self.middle) / self.radius) * (SIZE / 2.0 - MARGIN)
        return np.stack([SIZE / 2.0 + seen[..., 0], SIZE / 2.0 - seen[..., 1]], axis=-1), seen[..., 2]


def _view(scene: Scene, view: View, limit: float, unit: str, *behind: Markup, **attributes: str) -> Markup:
    title, azimuth, elevation = view
    camera = Camera.at(scene.axis, scene.front, azimuth, elevation)
    frame = _Frame.about(scene.framed, camera)
    place, depth = frame.places(scene.points)
    inside = np.all((place > 0.0) & (place < SIZE), axis=1)
    place, depth = place[inside], depth[inside]
    if scene.distance is None:
        level, colors = np.zeros(len(place), np.intp), [NEUTRAL]
    else:
        level, colors = colored(scene.distance[inside], limit)
    parts = list(behind)
    size = dot_size(DOT, len(place))
    hidden = np.zeros(len(place), bool)
    if scene.surface is not None:
        nearest = _nearest(scene.surface, frame)
        hidden = _is_hidden(place, depth, nearest)
        parts.append(dots(place[hidden], level[hidden], colors, size))
        parts.append(_pieces(scene.surface, frame, nearest))
        parts += [_edge(edge, frame, nearest) for edge in scene.surface.edges]
        parts.append(_axis(scene.surface, frame))
    parts.append(dots(place[~hidden], level[~hidden], colors, size))
    parts += [_scale_bar(frame.radius, unit), _triad(camera)]
    return picture(SIZE, SIZE, *parts, title=f"points and primitive, {title}", class_="view", **attributes)


def _nearest(surface: Surface, frame: _Frame) -> Array:
    """Depth (CELLS, CELLS) of the surface that is nearest to the viewer; -inf where there is none."""
    nearest = np.full((CELLS, CELLS), -np.inf)
    place, depth = frame.places(surface.fine)
    row, column = _cells(place).T
    np.maximum.at(nearest, (row, column), depth)
    return nearest


def _cells(place: Array) -> NDArray[np.intp]:
    return np.clip(place[..., ::-1] * (CELLS / SIZE), 0, CELLS - 1).astype(np.intp)


def _is_hidden(place: Array, depth: Array, nearest: Array, slack: float = 3.0) -> NDArray[np.bool_]:
    """Whether the surface is in front by more than so many cells."""
    cell = _cells(place)
    return nearest[cell[..., 0], cell[..., 1]] > depth + slack * SIZE / CELLS


def _pieces(surface: Surface, frame: _Frame, nearest: Array) -> Markup:
    """The pieces from the farthest to the nearest, without those that are hidden."""
    place, depth = frame.places(surface.pieces)
    towards = surface.normals @ frame.camera.toward
    lit = frame.camera.seen(surface.normals) @ (LIGHT / np.linalg.norm(LIGHT))
    outside = towards >= 0.0
    shade = np.rint(np.clip(np.where(outside, lit, -lit), 0.0, 1.0) * (SHADES - 1)).astype(np.intp)
    kept = ~np.all(_is_hidden(place, depth, nearest, 6.0), axis=1)
    order = np.flatnonzero(kept)[np.argsort(depth[kept].mean(axis=1), kind="stable")]
    runs: list[tuple[str, list[str]]] = []
    for i in order:
        fill = _fill(bool(outside[i]), int(shade[i]))
        if not runs or runs[-1][0] != fill:
            runs.append((fill, []))
        runs[-1][1].append(line_path(place[i], closed=True))
    paths = (element("path", d="".join(data), fill=fill, stroke=fill) for fill, data in runs)
    return element("g", *paths, stroke_width=6, stroke_linejoin="round", opacity=0.82)


def _fill(outside: bool, shade: int) -> str:
    light, dark = np.array(OUTSIDE if outside else INSIDE, np.float64)
    share = shade / (SHADES - 1)
    red, green, blue = np.rint(share * light + (1.0 - share) * dark).astype(int)
    return f"#{red:02x}{green:02x}{blue:02x}"


def _edge(edge: Array, frame: _Frame, nearest: Array) -> Markup:
    """A line that is dashed where it is hidden."""
    place, depth = frame.places(edge)
    hidden = _is_hidden(place, depth, nearest)
    cuts = np.flatnonzero(np.diff(hidden)) + 1
    parts = []
    for start, stop in zip([0, *cuts], [*cuts, len(place)], strict=True):
        run = place[start : stop + 1]
        if len(run) > 1:
            class_ = "edge behind" if hidden[start] else "edge"
            parts.append(element("path", d=line_path(run), class_=class_))
    return joined(parts)


def _axis(surface: Surface, frame: _Frame) -> Markup:
    if surface.axis is None:
        return Markup("")
    return element("path", d=line_path(frame.places(surface.axis)[0]), class_="axis")


def _scale_bar(radius: float, unit: str) -> Markup:
    """A length that is a round number, a tenth of the picture or more."""
    length = nice(0.25 * radius)
    width = length / radius * (SIZE / 2.0 - MARGIN)
    x, y = CORNER, SIZE - CORNER
    return element(
        "g",
        element("path", d=f"M{x} {y - 40}v40h{round(width)}v-40", class_="line"),
        text(x + width / 2.0, y - 60, f"{length:g} {unit}".rstrip(), "middle"),
    )


def _triad(camera: Camera) -> Markup:
    """The axes of the coordinates of the input; those across the picture only."""
    x, y, length = SIZE - 380, SIZE - 380, 190.0
    parts = []
    for axis, name in zip(camera.seen(np.eye(3)), "xyz", strict=True):
        across, up = (float(value) for value in axis[:2])
        if np.hypot(across, up) > 0.15:
            end = (x + length * across, y - length * up)
            beyond = (x + 1.4 * length * across, y - 1.4 * length * up + 45)
            parts.append(element("path", d=f"M{x} {y}L{round(end[0])} {round(end[1])}", class_="line"))
            parts.append(text(*beyond, name, "middle"))
    return element("g", *parts)
