"""Pieces of pictures. Lengths are whole tenths of a pixel: paths are short, and the same everywhere."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from primfit.fitting.geometry.vectors import Array

from ..colors import diverging
from .markup import Markup, element, joined

LEVELS = 31
"""Colors that residuals are drawn in."""

FEW = 1200
"""From so many points on dots are as small as they get."""

PICTURE_STYLE = Markup(Path(__file__).with_name("picture.css").read_text(encoding="utf-8"))
"""Colors of the page where it has some, else those of a white one."""

MOST_DIGITS, MOST_DECIMALS = 7, 6
"""Letters of a number at an axis, and decimals."""

FONT = 180
"""Height of the letters at the axes; `picture.css` has it, too."""

MOST_MARKS = 300
"""Dots that stand for points beyond a picture."""

HALO = 9
"""How much wider than a dot the ring around it is."""


def picture(width: int, height: int, *parts: object, title: str, class_: str = "", **more: object) -> Markup:
    """An image with a text for those who do not see it; `PICTURE_STYLE` has to be on its page or in it."""
    attributes = {"viewBox": f"0 0 {width} {height}", "role": "img", "class_": f"primfit {class_}".rstrip()}
    return element("svg", element("title", title), *parts, **attributes, **more)


def text(x: float, y: float, content: object, anchor: str = "start", **attributes: object) -> Markup:
    return element("text", content, x=round(x), y=round(y), text_anchor=anchor, **attributes)


def line_path(points: Array, closed: bool = False) -> str:
    """Path data of a polyline (K, 2): the first place, then steps."""
    places = np.rint(points).astype(np.int64)
    steps = np.diff(places, axis=0)
    first = f"M{places[0, 0]} {places[0, 1]}"
    return first + "l" + " ".join(f"{x} {y}" for x, y in steps.tolist()) + ("z" if closed else "")


def colored(values: Array, limit: float) -> tuple[NDArray[np.intp], list[str]]:
    """Which of `LEVELS` colors each value (N,) has, and the colors."""
    share = np.clip(values / limit, -1.0, 1.0) if limit > 0.0 else np.zeros(len(values))
    level = np.rint((share + 1.0) / 2.0 * (LEVELS - 1)).astype(np.intp)
    return level, [f"#{r:02x}{g:02x}{b:02x}" for r, g, b in diverging(np.linspace(-1.0, 1.0, LEVELS), 1.0)]


def dots(places: Array, level: NDArray[np.intp], colors: list[str], size: int) -> Markup:
    """Round dots at places (N, 2), with a ring each so that all of them are seen on any ground.

    Colors in which no dot is are left out.
    """
    if not len(places):
        return Markup("")
    spots = [f"M{x} {y}h0" for x, y in np.rint(places).astype(np.int64).tolist()]
    parts = [element("path", d="".join(spots), class_="halo", stroke_width=size + HALO)]
    for i, color in enumerate(colors):
        chosen = "".join(spots[j] for j in np.flatnonzero(level == i))
        if chosen:
            parts.append(element("path", d=chosen, stroke=color, stroke_width=size))
    return element("g", *parts, stroke_linecap="round", fill="none")


def dot_size(least: int, n_points: int) -> int:
    """Of dots that are up to twice as wide where they are few."""
    return round(least * min(max((FEW / max(n_points, 1)) ** 0.5, 1.0), 2.0))


def beyond(places: Array, size: int) -> Markup:
    """Hollow dots at places (N, 2) on the edge of a picture, for points that lie beyond it."""
    spots = np.unique(np.rint(places / size).astype(np.int64) * size, axis=0)[:MOST_MARKS]
    data = "".join(f"M{x} {y}h0" for x, y in spots.tolist())
    rings = [
        element("path", d=data, class_=class_, stroke_width=width)
        for class_, width in (("ring", size + 24), ("hole", size))
    ]
    return element("g", *rings, stroke_linecap="round", fill="none") if data else Markup("")


def color_bar(x: int, y: int, width: int, height: int) -> Markup:
    """The colors from left to right."""
    colors = colored(np.zeros(1), 1.0)[1]
    edges = np.rint(np.linspace(x, x + width, LEVELS + 1)).astype(int).tolist()
    return joined(
        element("rect", x=left, y=y, width=right - left + 1, height=height, fill=color)
        for left, right, color in zip(edges[:-1], edges[1:], colors, strict=True)
    )


@dataclass(frozen=True, eq=False)
class Axis:
    """Round numbers along an axis, and what is written at them.

    Attributes
    ----------
    values : where they are, in the numbers of the axis
    labels : one each
    less : what the labels leave out of the values, as text; empty where it is nothing
    """

    values: list[float]
    labels: list[str]
    less: str = ""

    @classmethod
    def of(cls, low: float, high: float, room: float, is_upright: bool = False) -> "Axis":
        """From low to high, as many as have room (tenths of a pixel) beside each other, or above."""
        found = cls([], [])
        for most in range(max(int(room / (2.2 * FONT)), 1), 0, -1):
            found = cls._of(ticks(low, high, most), nice((high - low) / most))
            widest = 0.0 if is_upright else max(map(len, found.labels), default=0) * 0.6 * FONT
            if len(found.labels) * (widest + 0.8 * FONT) <= room * 1.1 or is_upright:
                break
        return found

    @classmethod
    def _of(cls, values: list[float], step: float) -> "Axis":
        """With labels that tell numbers a step apart."""
        if not values:
            return cls([], [])
        decimals = max(-int(np.floor(np.log10(step) + 1e-6)), 0)
        largest = max(map(abs, values))
        if decimals > MOST_DECIMALS or step >= 10.0**MOST_DIGITS:
            return cls(values, [f"{value:.3g}" for value in values])
        if len(f"{largest:.{decimals}f}") <= MOST_DIGITS:
            return cls(values, [f"{value:z.{decimals}f}" for value in values])
        labels = [f"{value - values[0]:z.{decimals}f}" for value in values]
        return cls(values, labels, f"{values[0]:,.{decimals}f}")

    def named(self, name: str, unit: str) -> str:
        """What is written beside the axis."""
        less = f" \u2212 {self.less}".replace("\u2212 -", "+ ") if self.less else ""
        return name + less + (f" [{unit}]" if unit else "")


def ticks(low: float, high: float, most: int) -> list[float]:
    """Round numbers from low to high: 1, 2 or 5 times a power of ten apart, at most so many."""
    step = nice((high - low) / most)
    first, last = int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9))
    return [i * step for i in range(first, last + 1)]


def nice(least: float) -> float:
    """The smallest of 1, 2 and 5 times a power of ten that is not less."""
    power = 10.0 ** np.floor(np.log10(least))
    return float(next(m * power for m in (1.0, 2.0, 5.0, 10.0) if m * power >= least * (1.0 - 1e-9)))
