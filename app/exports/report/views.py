"""Views of the points with the trimmed primitive: shaded, with its edges, its axis and what is hidden."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.geometry.vectors import Array

from .markup import Markup, element, joined
from .numbers import Unit, count
from .scene import Camera, Scene, Surface
from .svg import PICTURE_STYLE, beyond, colored, dot_size, dots, line_path, nice, picture, text

SIZE, STRIP, MARGIN = 3600, 520, 240
"""The square of the scene, the strip below it, and what is free beside the scene."""

DOT = 24
EDGES = (2 * DOT, SIZE - 2 * DOT)
"""From where to where points are drawn."""

View = tuple[str, float, float]
ISOMETRIC: View = ("isometric", 45.0, float(np.degrees(np.arctan(np.sqrt(0.5)))))
VIEWS = (ISOMETRIC, ("from the side", 0.0, 0.0), ("from above", 0.0, 90.0))
"""Title, azimuth and elevation [degrees]."""

CELLS = 110
"""Cells each way of the picture in which the nearest surface is known."""

LIGHT = np.array([-0.35, 0.55, 0.76])
OUTSIDE, INSIDE = ((150, 166, 186), (88, 104, 126)), ((168, 150, 132), (104, 90, 78))
"""Colors in the light and in the shade, of either side of the surface."""

ARM, BEYOND_ARM = 130.0, 75.0
"""Length of the axes of the coordinates, and how far their names are from the ends and from other axes."""

APART = 110.0
"""Least distance of two names of axes."""

SHORTEST = 0.35
"""An axis that looks shorter, over its length, points to the viewer."""

FAR = 1.5
"""An axis farther from the middle than so many times half the picture is not drawn."""

SHADES = 10
NEUTRAL = "#5b8fc9"


def views(scene: Scene, limit: float, unit: str | None) -> Markup:
    """Three figures, each with its scale."""
    return joined(
        element("figure", _view(scene, view, limit, unit), element("figcaption", view[0])) for view in VIEWS
    )


def lone_view(scene: Scene, limit: float, unit: str | None) -> Markup:
    """The isometric view with its own style: a file, or a part of any page."""
    ground = element("rect", width=SIZE, height=SIZE + STRIP, fill="#f5f7f9")
    beside = (element("style", PICTURE_STYLE), ground)
    return _view(scene, ISOMETRIC, limit, unit, *beside, xmlns="http://www.w3.org/2000/svg")


@dataclass(frozen=True, eq=False)
class Frame:
    """From points to places (N, 2) in the picture and depths (N,), both in tenths of a pixel.

    `middle` (3,) comes to the middle of the picture, and what is `radius` beside it to the margin.
    """

    camera: Camera
    middle: Array
    radius: float

    @classmethod
    def about(cls, scene: Scene, camera: Camera) -> Self:
        """That holds what the scene reaches to."""
        origin = scene.near[0] if scene.surface is None else scene.surface.pieces[0, 0]
        low, high = scene.reach(camera, origin)
        axes = np.stack([camera.right, camera.up, camera.toward])
        return cls(camera, origin + (low / 2.0 + high / 2.0) @ axes, float(np.max((high - low)[:2])) / 2.0)

    def places(self, points: Array) -> tuple[Array, Array]:
        seen = self.camera.seen((points - self.middle) / self.radius) * (SIZE / 2.0 - MARGIN)
        return np.stack([SIZE / 2.0 + seen[..., 0], SIZE / 2.0 - seen[..., 1]], axis=-1), seen[..., 2]


@dataclass(frozen=True, eq=False)
class Front:
    """What of a surface is nearest to the viewer.

    Attributes
    ----------
    nearest : (CELLS, CELLS) depth of the nearest sample in each cell; -inf where there is none
    unit : the side of a cell or, of a surface that is deeper than the picture is wide, as large a part of
        its depth: within a cell that may change so much
    """

    nearest: Array
    unit: float

    @classmethod
    def of(cls, surface: Surface, frame: Frame) -> Self:
        nearest = np.full((CELLS, CELLS), -np.inf)
        place, depth = frame.places(surface.fine)
        row, column = _cells(place).T
        np.maximum.at(nearest, (row, column), depth)
        return cls(nearest, max(SIZE, float(np.ptp(depth)) if len(depth) else 0.0) / CELLS)

    def hides(self, place: Array, depth: Array, slack: float = 3.0) -> NDArray[np.bool_]:
        """Whether the surface is in front by more than so many units."""
        cell = _cells(place)
        return self.nearest[cell[..., 0], cell[..., 1]] > depth + slack * self.unit


def _cells(place: Array) -> NDArray[np.intp]:
    return np.clip(place[..., ::-1] * (CELLS / SIZE), 0, CELLS - 1).astype(np.intp)


def _view(
    scene: Scene, view: View, limit: float, unit: str | None, *behind: Markup, **attributes: str
) -> Markup:
    title, azimuth, elevation = view
    camera = Camera.at(scene.axis, scene.front, azimuth, elevation)
    frame = Frame.about(scene, camera)
    place, depth = frame.places(scene.points)
    inside = ~is_beyond(place)
    place, depth, outside = place[inside], depth[inside], place[~inside]
    if scene.distance is None:
        level, colors = np.zeros(len(place), np.intp), [NEUTRAL]
    else:
        level, colors = colored(scene.distance[inside], limit)
    parts = list(behind)
    size = dot_size(DOT, len(place))
    hidden = np.zeros(len(place), bool)
    if scene.surface is not None:
        front = Front.of(scene.surface, frame)
        hidden = front.hides(place, depth)
        parts.append(dots(place[hidden], level[hidden], colors, size))
        parts.append(_pieces(scene.surface, frame, front))
        parts += [_edge(edge, frame, front) for edge in scene.surface.edges]
        parts.append(_axis(scene.surface, frame))
    parts += [dots(place[~hidden], level[~hidden], colors, size), beyond(drawn_in(outside), 40)]
    n_beyond = int(is_beyond(frame.places(scene.cloud)[0]).sum())
    parts += [_scale_bar(frame.radius, unit), triad(camera), _told(n_beyond)]
    about = f"points and primitive, {title}"
    return picture(SIZE, SIZE + STRIP, *parts, title=about, class_="view", **attributes)


def is_beyond(place: Array) -> NDArray[np.bool_]:
    """Which places (N, 2) are not in the picture."""
    return np.any((place < EDGES[0]) | (place > EDGES[1]), axis=1)


def drawn_in(place: Array) -> Array:
    """Where the lines from the middle to places (N, 2) beyond the picture leave it."""
    half = (EDGES[1] - EDGES[0]) / 2.0
    away = place - SIZE / 2.0
    return SIZE / 2.0 + away * (half / np.abs(away).max(axis=1, keepdims=True))


def _told(n_beyond: int) -> Markup:
    """How many points lie beyond the picture."""
    if not n_beyond:
        return Markup("")
    return text(SIZE / 2.0, SIZE + STRIP - 90, f"{count(n_beyond, 'point')} beyond", "middle")


def _pieces(surface: Surface, frame: Frame, front: Front) -> Markup:
    """The pieces from the farthest to the nearest, without those that are hidden."""
    place, depth = frame.places(surface.pieces)
    towards = surface.normals @ frame.camera.toward
    lit = frame.camera.seen(surface.normals) @ (LIGHT / np.linalg.norm(LIGHT))
    outside = towards >= 0.0
    shade = np.rint(np.clip(np.where(outside, lit, -lit), 0.0, 1.0) * (SHADES - 1)).astype(np.intp)
    kept = ~np.all(front.hides(place, depth, 6.0), axis=1)
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


def _edge(edge: Array, frame: Frame, front: Front) -> Markup:
    """A line that is dashed where it is hidden."""
    place, depth = frame.places(edge)
    hidden = front.hides(place, depth)
    cuts = np.flatnonzero(np.diff(hidden)) + 1
    parts = []
    for start, stop in zip([0, *cuts], [*cuts, len(place)], strict=True):
        run = place[start : stop + 1]
        if len(run) > 1:
            class_ = "edge behind" if hidden[start] else "edge"
            parts.append(element("path", d=line_path(run), class_=class_))
    return joined(parts)


def _axis(surface: Surface, frame: Frame) -> Markup:
    """The axis, unless it is far from a surface that hardly bends about it: then it would cut through."""
    if surface.axis is None:
        return Markup("")
    start, end = surface.axis
    along = (end - start) / np.linalg.norm(end - start)
    away = frame.middle - start
    if np.linalg.norm(away - (away @ along) * along) > FAR * frame.radius:
        return Markup("")
    return element("path", d=line_path(frame.places(surface.axis)[0]), class_="axis")


def _scale_bar(radius: float, unit: str | None) -> Markup:
    """A length that is a round number, a tenth of the picture or more."""
    length = nice(0.16 * radius)
    width = length / radius * (SIZE / 2.0 - MARGIN)
    x, y = 120, SIZE + STRIP - 90
    of = Unit.of(length, unit)
    said = f"{length * of.factor:.6g} {of.name}".rstrip()
    return element(
        "g",
        element("path", d=f"M{x} {y - 50}v50h{round(width)}v-50", class_="line"),
        text(x, y - 80, said),
    )


def triad(camera: Camera) -> Markup:
    """The axes of the coordinates of the input; one that points to the viewer is left out."""
    origin = np.array([SIZE - 450.0, SIZE + 150.0])
    arms = {name: axis[:2] * [ARM, -ARM] for axis, name in zip(camera.seen(np.eye(3)), "xyz", strict=True)}
    longest_first = sorted(arms, key=lambda name: -np.linalg.norm(arms[name]))
    shown = {name: arms[name] for name in longest_first if np.linalg.norm(arms[name]) > SHORTEST * ARM}
    parts = []
    for name, place in _letters(shown).items():
        x, y = origin + place
        parts.append(element("path", d=line_path(np.stack([origin, origin + shown[name]])), class_="line"))
        parts.append(text(x, y + 45.0, name, "middle"))
    return element("g", *parts)


def _letters(arms: Mapping[str, Array]) -> dict[str, Array]:
    """Where the names of the axes stand: beyond their ends, and neither on each other nor on another axis."""
    places: dict[str, Array] = {}
    for name, arm in arms.items():
        along = arm / np.linalg.norm(arm)
        place = arm + BEYOND_ARM * along
        others = [other for each, other in arms.items() if each != name]
        while any(np.linalg.norm(place - other) < APART for other in places.values()) or any(
            _distance(place, other) < BEYOND_ARM for other in others
        ):
            place = place + 20.0 * along
        places[name] = place
    return places


def _distance(place: Array, arm: Array) -> float:
    """From a line that begins at the origin."""
    along = np.clip(place @ arm / (arm @ arm), 0.0, 1.0)
    return float(np.linalg.norm(place - along * arm))
