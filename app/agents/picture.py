"""The picture of a fit as a small PNG: points colored by their signed distances, over the trimmed primitive.

It shows what the isometric view of the report shows, with a title, the leading figures and a legend.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache
from io import BytesIO
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageColor, ImageDraw, ImageFont

from primfit.fitting.answer.summary import headline
from primfit.fitting.geometry.vectors import Array

from ..exports import Fitted
from ..exports.colors import diverging
from ..exports.drawing import DRAWINGS
from ..exports.report.numbers import Unit, count
from ..exports.report.ranges import color_reach
from ..exports.report.scene import Camera, Scene, shown
from ..exports.report.svg import nice
from ..exports.report.views import INSIDE, ISOMETRIC, LIGHT, MARGIN, OUTSIDE, SIZE, Frame, Front, is_beyond

WIDTH, HEIGHT = 640, 480
SMOOTH = 2
"""Drawn so many times larger, then made smaller: edges become smooth."""

SCENE_TOP, SCENE_SIZE = 78, 400
"""The square of the scene, at the left."""

COLUMN, BAR_TOP, BAR = 428, 306, (16, 108)
"""Left of the column of figures, top of the legend of colors, and the size of its bar."""

SEE_THROUGH = 0.55
"""How much the surface covers of what is behind it."""

MOST_OUTLIERS = 200
"""So many are drawn at least, where there are; the other points are a sample."""

INK, GRAY, PAPER, EDGE = "#16202b", "#5a6672", "#ffffff", "#1d252e"


def picture(fitted: Fitted, answer: Mapping[str, Any]) -> bytes:
    """A PNG of 640 x 480 pixels.

    Of an ambiguous answer it shows the first kind, of `no_fit` the best try; the title says so. Outliers are
    rings, the others are dots. Points behind the surface are seen through it.

    Parameters
    ----------
    answer : the body of `POST /fit` for what was fitted
    """
    sheet = _Sheet()
    for line in _title(answer):
        sheet.write_line(*line)
    drawn = _Drawn.of(fitted)
    _draw_scene(sheet, drawn)
    _draw_figures(sheet, answer)
    _draw_legend(sheet, drawn)
    return sheet.png()


class _Sheet:
    """An image and a pen; places are in pixels of the finished picture."""

    def __init__(self) -> None:
        self.image = Image.new("RGB", (WIDTH * SMOOTH, HEIGHT * SMOOTH), PAPER)
        self.pen = ImageDraw.Draw(self.image)
        self._line = 6.0

    def text(
        self, x: float, y: float, words: str, size: float = 12, fill: str = INK, anchor: str = "la"
    ) -> None:
        self.pen.text((x * SMOOTH, y * SMOOTH), words, fill, _font(size), anchor)

    def write_line(self, words: str, size: float, fill: str) -> None:
        """The next line from the top."""
        self.text(10, self._line, words, size, fill)
        self._line += 1.3 * size

    def png(self) -> bytes:
        small = self.image.resize((WIDTH, HEIGHT), Image.Resampling.BOX)
        stream = BytesIO()
        small.quantize(palette=_palette(), dither=Image.Dither.NONE).save(stream, "PNG", optimize=True)
        return stream.getvalue()


@cache
def _palette() -> Image.Image:
    """256 colors: those of the distances, alone, at the rim of a dot, behind the surface; and the rest."""
    distances = diverging(np.linspace(-1.0, 1.0, 65), 1.0).astype(np.float64)
    few = distances[::2]
    mixes = [
        distances,
        *(_mixed(few, color, share) for color, share in ((GRAY, 0.5), (OUTSIDE[0], SEE_THROUGH))),
    ]
    lines = [(PAPER, INK, 33), (PAPER, GRAY, 17)]
    sides = [
        (_mixed(PAPER, side[0], SEE_THROUGH), _mixed(PAPER, side[1], SEE_THROUGH), 24)
        for side in (OUTSIDE, INSIDE)
    ]
    mixes += [_mixed(start, end, np.linspace(0.0, 1.0, n)[:, None]) for start, end, n in (*lines, *sides)]
    colors = np.rint(np.concatenate(mixes)).astype(np.uint8)
    image = Image.new("P", (1, 1))
    image.putpalette(colors.tobytes())
    return image


def _mixed(color: Any, other: Any, share: Any) -> Any:
    """Colors, of which the other has so large a share."""
    one, two = (
        np.array(ImageColor.getrgb(each) if isinstance(each, str) else each, np.float64)
        for each in (color, other)
    )
    return (1.0 - share) * one + share * two


def _font(size: float) -> Any:
    return ImageFont.load_default(size * SMOOTH)


def _fits(words: str, size: float, width: float) -> bool:
    return bool(_font(size).getlength(words) <= width * SMOOTH)


def _wrapped(words: str, size: float, width: float, most: int) -> list[str]:
    """Lines of a text, of which the last may end early."""
    lines = [""]
    for word in words.split():
        longer = f"{lines[-1]} {word}".strip()
        if _fits(longer, size, width):
            lines[-1] = longer
        elif len(lines) < most:
            lines.append(word)
        else:
            lines[-1] += " ..."
            break
    return lines


def _title(answer: Mapping[str, Any]) -> Iterator[tuple[str, float, str]]:
    """What it is, with its main size, and the message below: each line with its size and color."""
    words, width = _what(answer), WIDTH - 20
    size = next((size for size in (19, 17, 15, 13) if _fits(words, size, width)), 12)
    yield words, size, INK
    for line in _wrapped(answer["message"], 12, width, 2):
        yield line, 12, GRAY


def _what(answer: Mapping[str, Any]) -> str:
    if answer["primitive"] is None:
        return "No fit, and no kind could be tried"
    (_, _), *rows = headline(answer)
    first = answer["primitive"]["kind"]
    named = f"{first}, {' '.join(rows[0])}" if rows else first
    match answer["status"]:
        case "no_fit":
            return f"No fit. Drawn is the best try: {named}"
        case "ambiguous":
            kinds = [first, *(other["kind"] for other in answer["alternatives"])]
            return f"Ambiguous: {' or '.join(kinds)}. Drawn: {named}"
    return named[:1].upper() + named[1:]


@dataclass(frozen=True, eq=False)
class _Drawn:
    """What the scene shows.

    Attributes
    ----------
    inlier : (N,) which of the points of the scene belong to the primitive
    limit : where the colors end [length]
    n_points, n_outliers : of the whole cloud
    positive : where distances are positive, in words
    """

    scene: Scene
    inlier: NDArray[np.bool_]
    limit: float
    n_points: int
    n_outliers: int
    unit: str | None
    positive: str

    @classmethod
    def of(cls, fitted: Fitted) -> "_Drawn":
        found, points = fitted.recognition, fitted.points
        unit, n_points = found.unit, len(points)
        if found.primitive is None:
            scene = Scene.of(fitted)
            return cls(scene, np.ones(len(scene.points), bool), 0.0, n_points, 0, unit, "")
        # The best try is drawn like an answer: it shows why it is none.
        fitted = replace(fitted, recognition=replace(found, status="fitted"))
        scene = Scene.of(fitted)
        residuals = fitted.residuals
        outliers = np.flatnonzero(~residuals.inlier)
        rows = np.union1d(shown(n_points), np.random.default_rng(0).permutation(outliers)[:MOST_OUTLIERS])
        scene = replace(scene, points=points[rows], distance=residuals.distance[rows])
        return cls(
            scene,
            residuals.inlier[rows],
            color_reach(residuals, fitted.rounding),
            n_points,
            len(outliers),
            unit,
            DRAWINGS[fitted.primitive.kind].POSITIVE,
        )

    @property
    def colors(self) -> list[tuple[int, ...]]:
        """Of each point, in sRGB."""
        if self.scene.distance is None:
            return [(91, 143, 201)] * len(self.scene.points)
        return [tuple(color) for color in diverging(self.scene.distance, self.limit).tolist()]


def _placed(place: Array) -> Array:
    """Places of the view in pixels of the large image."""
    return (place * (SCENE_SIZE / SIZE) + [4.0, SCENE_TOP]) * SMOOTH


def _draw_scene(sheet: _Sheet, drawn: _Drawn) -> None:
    scene = drawn.scene
    _, azimuth, elevation = ISOMETRIC
    camera = Camera.at(scene.axis, scene.front, azimuth, elevation)
    frame = Frame.about(scene, camera)
    place, depth = frame.places(scene.points)
    beyond = is_beyond(place)
    hidden = np.zeros(len(place), bool)
    if scene.surface is not None:
        front = Front.of(scene.surface, frame)
        hidden = front.hides(place, depth)
        _draw_points(sheet, drawn, place, np.flatnonzero(hidden & ~beyond))
        _draw_surface(sheet, scene, frame, front)
    # Outliers last: they are few, and must be seen.
    before = np.lexsort((depth, ~drawn.inlier))
    _draw_points(sheet, drawn, place, before[~(hidden | beyond)[before]])
    _draw_scale(sheet, frame.radius, drawn.unit)
    _draw_axes(sheet, camera)
    n_beyond = int(is_beyond(frame.places(scene.cloud)[0]).sum())
    if n_beyond:
        sheet.text(SCENE_SIZE, HEIGHT - 20, f"{count(n_beyond, 'point')} beyond the picture", 11, GRAY, "ra")


def _draw_points(sheet: _Sheet, drawn: _Drawn, place: Array, rows: NDArray[np.intp]) -> None:
    radius = SMOOTH * (2.4 if len(place) < 1000 else 1.8)
    colors = drawn.colors
    for (x, y), row in zip(_placed(place[rows]).tolist(), rows.tolist(), strict=True):
        (_dot if drawn.inlier[row] else _ring)(sheet.pen, x, y, radius, colors[row])


def _dot(pen: Any, x: float, y: float, radius: float, color: tuple[int, ...]) -> None:
    pen.ellipse((x - radius, y - radius, x + radius, y + radius), color, GRAY, 1)


def _ring(pen: Any, x: float, y: float, radius: float, color: tuple[int, ...]) -> None:
    outer = 2.2 * radius
    for fill, size, width in ((INK, outer, 2 * SMOOTH), (color, outer - SMOOTH / 2, 2 * SMOOTH - 1)):
        pen.ellipse((x - size, y - size, x + size, y + size), outline=fill, width=width)


def _draw_surface(sheet: _Sheet, scene: Scene, frame: Frame, front: Front) -> None:
    """All of the surface at once, so that what lies behind is covered alike wherever it is folded."""
    surface = scene.surface
    assert surface is not None
    layer = Image.new("RGBA", sheet.image.size, (0, 0, 0, 0))
    pen = ImageDraw.Draw(layer)
    place, depth = frame.places(surface.pieces)
    lit = np.abs(frame.camera.seen(surface.normals) @ (LIGHT / np.linalg.norm(LIGHT)))
    outside = surface.normals @ frame.camera.toward >= 0.0
    for i in np.argsort(depth.mean(axis=1), kind="stable"):
        light, dark = np.array(OUTSIDE if outside[i] else INSIDE, np.float64)
        color = (*np.rint(lit[i] * light + (1.0 - lit[i]) * dark).astype(int).tolist(), 255)
        pen.polygon([tuple(corner) for corner in _placed(place[i]).tolist()], color, color)
    layer.putalpha(layer.getchannel("A").point(lambda alpha: round(SEE_THROUGH * alpha)))
    sheet.image.paste(layer, (0, 0), layer)
    for edge in surface.edges:
        _draw_edge(sheet, edge, frame, front)


def _draw_edge(sheet: _Sheet, edge: Array, frame: Frame, front: Front) -> None:
    """A line where the surface ends, of which every other piece is left out where it is hidden."""
    place, depth = frame.places(edge)
    hidden = front.hides(place, depth)
    ends = _placed(place).tolist()
    for i, (start, end) in enumerate(pairwise(ends)):
        if not hidden[i] or i % 2:
            sheet.pen.line((*start, *end), EDGE, 3 if not hidden[i] else 2)


def _draw_scale(sheet: _Sheet, radius: float, unit: str | None) -> None:
    """A length that is a round number."""
    length = nice(0.16 * radius)
    width = length / radius * (SIZE / 2.0 - MARGIN) * SCENE_SIZE / SIZE
    x, y = 12, HEIGHT - 12
    line = [(x, y - 4), (x, y), (x + width, y), (x + width, y - 4)]
    sheet.pen.line([(SMOOTH * a, SMOOTH * b) for a, b in line], INK, SMOOTH + 1)
    of = Unit.of(length, unit)
    sheet.text(x, y - 6, f"{length * of.factor:.6g} {of.name}".rstrip(), 11, INK, "ld")


def _draw_axes(sheet: _Sheet, camera: Camera) -> None:
    """The axes of the coordinates of the input."""
    origin = np.array([34.0, SCENE_TOP + 34.0])
    for axis, name in zip(camera.seen(np.eye(3)), "xyz", strict=True):
        along = axis[:2] * [1.0, -1.0]
        if np.linalg.norm(along) > 0.15:
            end = origin + 20.0 * along
            sheet.pen.line([tuple(SMOOTH * origin), tuple(SMOOTH * end)], GRAY, SMOOTH + 1)
            x, y = (end + 8.0 * along / np.linalg.norm(along)).tolist()
            sheet.text(x, y, name, 11, GRAY, "mm")


def _draw_figures(sheet: _Sheet, answer: Mapping[str, Any]) -> None:
    """The leading rows of the summary, each name above its value."""
    y = SCENE_TOP - 10.0
    for name, value in headline(answer)[1:6]:
        sheet.text(COLUMN, y, name, 11, GRAY)
        for line in _wrapped(value, 12, WIDTH - COLUMN - 8, 2):
            sheet.text(COLUMN, y + 13, line)
            y += 15
        y += 21


def _draw_legend(sheet: _Sheet, drawn: _Drawn) -> None:
    """What colors and shapes mean."""
    if drawn.scene.distance is not None:
        _draw_bar(sheet, drawn)
    y, radius = HEIGHT - 38, SMOOTH * 2.6
    n_inliers = drawn.n_points - drawn.n_outliers
    _dot(sheet.pen, (COLUMN + 6) * SMOOTH, y * SMOOTH, radius, (247, 247, 247))
    sheet.text(COLUMN + 18, y, count(n_inliers, "inlier"), 12, INK, "lm")
    if drawn.n_outliers:
        _ring(sheet.pen, (COLUMN + 6) * SMOOTH, (y + 16) * SMOOTH, radius, (178, 24, 43))
        sheet.text(COLUMN + 18, y + 16, count(drawn.n_outliers, "outlier"), 12, INK, "lm")
    if len(drawn.scene.points) < drawn.n_points:
        sheet.text(COLUMN, y + 30, f"{len(drawn.scene.points):,} of the points are drawn", 10, GRAY, "lm")


def _draw_bar(sheet: _Sheet, drawn: _Drawn) -> None:
    """The colors with the distances that they stand for."""
    of = Unit.of(drawn.limit, drawn.unit)
    sheet.text(COLUMN, BAR_TOP - 24, f"signed distance{of.bracketed}", 12)
    width, height = BAR
    shares = np.linspace(1.0, -1.0, height * SMOOTH)
    for y, color in enumerate(diverging(shares, 1.0).tolist(), BAR_TOP * SMOOTH):
        sheet.pen.line((COLUMN * SMOOTH, y, (COLUMN + width) * SMOOTH, y), tuple(color))
    outline = (COLUMN, BAR_TOP, COLUMN + width, BAR_TOP + height)
    sheet.pen.rectangle([SMOOTH * each for each in outline], None, GRAY, SMOOTH)
    ends = {
        1.0: f"+{of.two(drawn.limit)} {drawn.positive}",
        -1.0: f"-{of.two(drawn.limit)} on the other side",
    }
    half = of.two(drawn.limit / 2.0)
    for share, told in {**ends, 0.5: f"+{half}", 0.0: "0", -0.5: f"-{half}"}.items():
        beside = BAR_TOP + (1.0 - share) / 2.0 * height
        for i, line in enumerate(_wrapped(told, 11, WIDTH - COLUMN - width - 10, 2)):
            sheet.text(COLUMN + width + 6, beside + 12 * i, line, 11, INK, "lm")
